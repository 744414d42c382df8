#include "cubecover/boundary_axes.hpp"

#include <cmath>
#include <queue>

namespace neurframe {

SignedAxis carried(OctahedralRotation rotation, SignedAxis axis) {
  for (int row = 0; row < 3; ++row) {
    if (rotation.axis(row) == axis.axis) return {row, rotation.sign(row) * axis.sign};
  }
  return {};
}

Eigen::Vector3d direction_of(const Eigen::Matrix3d& frame, SignedAxis axis) {
  return axis.sign * frame.col(axis.axis);
}

std::vector<BoundaryEdge> find_boundary_edges(const FieldMesh& mesh, const EdgeRings& rings) {
  std::vector<BoundaryEdge> edges;
  for (std::size_t e = 0; e < rings.vertices.size(); ++e) {
    if (!rings.on_boundary[e]) continue;
    const std::span<const int> ring = rings.ring(e);
    const auto [a, b] = rings.vertices[e];
    const int begin_face = detail::other_half_face(at(mesh.tets, ring.front() / 4), ring.front(), a, b);
    edges.push_back({rings.vertices[e], static_cast<int>(e), begin_face, ring.back(),
                     transport(mesh, ring.first(ring.size() - 1))});
  }
  return edges;
}

namespace {

SignedAxis nearest_axis(const Eigen::Matrix3d& frame, const Eigen::Vector3d& direction) {
  SignedAxis nearest;
  const Eigen::Vector3d cosines = frame.transpose() * direction;
  cosines.cwiseAbs().maxCoeff(&nearest.axis);
  nearest.sign = cosines(nearest.axis) < 0 ? -1 : 1;
  return nearest;
}

struct Proposal {
  double alignment;  // cosine between the axis and the normal
  int half_face;
  SignedAxis axis;
  bool operator<(const Proposal& other) const {
    return alignment != other.alignment ? alignment < other.alignment : half_face > other.half_face;
  }
};

Proposal propose(const FieldMesh& mesh, int half_face, SignedAxis axis) {
  const Eigen::Vector3d normal = area_vector(mesh, half_face).normalized();
  return {direction_of(at(mesh.frames, half_face / 4), axis).dot(normal), half_face, axis};
}

struct SmoothLink {
  int to_face;
  OctahedralRotation across;
};

std::vector<std::vector<SmoothLink>> smooth_links(const FieldMesh& mesh,
                                                  const std::vector<BoundaryEdge>& edges) {
  std::vector<std::vector<SmoothLink>> links(mesh.twin.size());
  for (const BoundaryEdge& edge : edges) {
    if (is_feature(mesh, edge_key(edge.vertices[0], edge.vertices[1]))) continue;
    at(links, edge.begin_face).push_back({edge.end_face, edge.across});
    at(links, edge.end_face).push_back({edge.begin_face, edge.across.inverse()});
  }
  return links;
}

}  // namespace

std::vector<SignedAxis> boundary_axes(const FieldMesh& mesh, const std::vector<BoundaryEdge>& edges) {
  const auto links = smooth_links(mesh, edges);
  std::vector<SignedAxis> axes(mesh.twin.size());
  std::priority_queue<Proposal> seeds;
  for (int h = 0; h < mesh.half_face_count(); ++h) {
    if (at(mesh.twin, h) >= 0) continue;
    seeds.push(propose(mesh, h, nearest_axis(at(mesh.frames, h / 4), area_vector(mesh, h).normalized())));
  }
  // per patch a maximal spanning tree of alignment, grown from its best face
  for (; !seeds.empty(); seeds.pop()) {
    if (at(axes, seeds.top().half_face).axis >= 0) continue;
    std::priority_queue<Proposal> front;
    front.push(seeds.top());
    while (!front.empty()) {
      const Proposal next = front.top();
      front.pop();
      if (at(axes, next.half_face).axis >= 0) continue;
      at(axes, next.half_face) = next.axis;
      for (const SmoothLink& link : at(links, next.half_face)) {
        if (at(axes, link.to_face).axis < 0)
          front.push(propose(mesh, link.to_face, carried(link.across, next.axis)));
      }
    }
  }
  return axes;
}

int sector_quarter_turns(const FieldMesh& mesh, const BoundaryEdge& edge,
                         const std::vector<SignedAxis>& axes) {
  const SignedAxis begin = carried(edge.across, at(axes, edge.begin_face));
  const SignedAxis end = at(axes, edge.end_face);
  const Eigen::Vector3d direction =
      (at(mesh.points, edge.vertices[1]) - at(mesh.points, edge.vertices[0])).normalized();
  if (begin == end) return 2;
  if (begin.axis == end.axis) {
    const double side =
        area_vector(mesh, edge.begin_face).cross(area_vector(mesh, edge.end_face)).dot(direction);
    return side < 0 ? 0 : 4;  // outward normals turn clockwise about a convex edge
  }
  const Eigen::Matrix3d& frame = at(mesh.frames, edge.end_face / 4);
  const double along = direction_of(frame, begin).cross(direction_of(frame, end)).dot(direction);
  if (std::abs(along) < 0.5) return -1;
  return along < 0 ? 1 : 3;
}

int tangent_axis(const FieldMesh& mesh, const BoundaryEdge& edge, const std::vector<SignedAxis>& axes) {
  const int begin = at(axes, edge.begin_face).axis;
  const int end = carried(edge.across.inverse(), at(axes, edge.end_face)).axis;
  if (begin != end) return 3 - begin - end;
  const Eigen::Vector3d direction = at(mesh.points, edge.vertices[1]) - at(mesh.points, edge.vertices[0]);
  Eigen::Vector3d along = (at(mesh.frames, edge.begin_face / 4).transpose() * direction).cwiseAbs();
  along(begin) = -1;
  int tangent = 0;
  along.maxCoeff(&tangent);
  return tangent;
}

}  // namespace neurframe
