#include "cubecover/alignment.hpp"

#include <cmath>

namespace neurframe {

namespace {

struct BoundaryDirections {
  std::vector<Direction> normal;               // per vertex: mean outward normal where the surface is smooth
  std::vector<Direction> tangent;              // per vertex: along a feature curve that runs through it
  std::vector<std::vector<int>> feature_ends;  // per vertex: the other ends of its feature edges
};

constexpr double smooth_cosine = 0.8;      // normals of one tet closer than 37 degrees count as one surface
constexpr double orthogonal_cosine = 0.5;  // a second direction must be more than 60 degrees off the first

BoundaryDirections boundary_directions(const FieldMesh& mesh) {
  BoundaryDirections directions{std::vector<Direction>(mesh.points.size()),
                                std::vector<Direction>(mesh.points.size()),
                                std::vector<std::vector<int>>(mesh.points.size())};
  for (const auto& [a, b] : mesh.features) {
    at(directions.feature_ends, a).push_back(b);
    at(directions.feature_ends, b).push_back(a);
  }
  std::vector<Eigen::Vector3d> sum(mesh.points.size(), Eigen::Vector3d::Zero());
  for (int h = 0; h < mesh.half_face_count(); ++h) {
    if (at(mesh.twin, h) >= 0) continue;
    for (const int vertex : half_face_vertices(mesh.tets, h)) at(sum, vertex) += area_vector(mesh, h);
  }
  for (int v = 0; v < mesh.point_count(); ++v) {
    const std::vector<int>& ends = at(directions.feature_ends, v);
    if (ends.empty() && at(sum, v).norm() > 0) at(directions.normal, v) = at(sum, v).normalized();
    if (ends.size() == 2)
      at(directions.tangent, v) = (at(mesh.points, ends[1]) - at(mesh.points, ends[0])).normalized();
  }
  return directions;
}

// The rotation that takes unit vector `from` to unit vector `to` by the shortest way.
Eigen::Matrix3d shortest_rotation(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  return Eigen::Quaterniond::FromTwoVectors(from, to).toRotationMatrix();
}

int nearest_column(const Eigen::Matrix3d& frame, const Eigen::Vector3d& direction) {
  int column = 0;
  (frame.transpose() * direction).cwiseAbs().maxCoeff(&column);
  return column;
}

Direction feature_edge_in(const FieldMesh& mesh, int tet) {
  const Tet& corners = at(mesh.tets, tet);
  for (const auto& [i, j] : tet_edges) {
    const EdgeKey edge = edge_key(at(corners, i), at(corners, j));
    if (is_feature(mesh, edge)) return (at(mesh.points, edge[1]) - at(mesh.points, edge[0])).normalized();
  }
  return {};
}

Direction boundary_face_normal(const FieldMesh& mesh, int tet) {
  for (int corner = 0; corner < 4; ++corner) {
    if (at(mesh.twin, 4 * tet + corner) < 0) return area_vector(mesh, 4 * tet + corner).normalized();
  }
  return {};
}

// The directions of the vertices, when they agree up to sign: their mean; otherwise none.
Direction common_direction(const Tet& tet, const std::vector<Direction>& of_vertex) {
  Direction common;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const int vertex : tet) {
    const Direction& direction = at(of_vertex, vertex);
    if (!direction) continue;
    if (!common) common = direction;
    const double cosine = common->dot(*direction);
    if (std::abs(cosine) < smooth_cosine) return {};
    sum += std::copysign(1.0, cosine) * *direction;
  }
  return common ? Direction(sum.normalized()) : common;
}

Direction orthogonal_part(const Eigen::Vector3d& first, const Direction& second) {
  if (!second || std::abs(first.dot(*second)) >= orthogonal_cosine) return {};
  return (*second - first * first.dot(*second)).normalized();
}

Alignment alignment_of(const FieldMesh& mesh, const BoundaryDirections& directions, int tet) {
  const Direction normal = boundary_face_normal(mesh, tet);
  const Direction feature = feature_edge_in(mesh, tet);
  if (normal) return {normal, orthogonal_part(*normal, feature)};
  if (feature) return {feature, {}};
  const Tet& corners = at(mesh.tets, tet);
  const Direction from_surface = common_direction(corners, directions.normal);
  return {from_surface ? from_surface : common_direction(corners, directions.tangent), {}};
}

}  // namespace

std::vector<Alignment> boundary_alignments(const FieldMesh& mesh) {
  const BoundaryDirections directions = boundary_directions(mesh);
  std::vector<Alignment> alignments;
  for (int t = 0; t < mesh.tet_count(); ++t) alignments.push_back(alignment_of(mesh, directions, t));
  return alignments;
}

Eigen::Matrix3d aligned_frame(const Eigen::Matrix3d& frame, const Alignment& alignment) {
  if (!alignment.first) return frame;
  const Eigen::Vector3d& first = *alignment.first;
  const Eigen::Vector3d axis = frame.col(nearest_column(frame, first));
  const Eigen::Matrix3d turned = shortest_rotation(axis, std::copysign(1.0, axis.dot(first)) * first) * frame;
  if (!alignment.second) return turned;
  const Eigen::Vector3d side = turned.col(nearest_column(turned, *alignment.second));
  const Eigen::Vector3d target = std::copysign(1.0, side.dot(*alignment.second)) * *alignment.second;
  const double angle = std::atan2(side.cross(target).dot(first), side.dot(target));
  return Eigen::AngleAxisd(angle, first) * turned;
}

void align_boundary_layer(FieldMesh& mesh) {
  const std::vector<Alignment> alignments = boundary_alignments(mesh);
  for (int t = 0; t < mesh.tet_count(); ++t)
    at(mesh.frames, t) = aligned_frame(at(mesh.frames, t), at(alignments, t));
}

}  // namespace neurframe
