#include "cubecover/field_mesh.hpp"

#include <algorithm>
#include <numbers>
#include <string>
#include <utility>

#include "core/errors.hpp"

namespace neurframe {

namespace {

double signed_volume(const std::vector<Eigen::Vector3d>& points, const Tet& tet) {
  const Eigen::Vector3d origin = at(points, tet[0]);
  const Eigen::Vector3d first = at(points, tet[1]) - origin;
  return first.cross(at(points, tet[2]) - origin).dot(at(points, tet[3]) - origin) / 6;
}

void orient_tets(const std::vector<Eigen::Vector3d>& points, std::vector<Tet>& tets) {
  for (std::size_t t = 0; t < tets.size(); ++t) {
    const double volume = signed_volume(points, tets[t]);
    if (!(volume != 0)) throw InputError("tet " + std::to_string(t) + " has zero volume; remesh the input");
    if (volume < 0) std::swap(tets[t][2], tets[t][3]);
  }
}

// The nearest rotation, by the polar decomposition; a left-handed frame has its last axis turned round first,
// which is the same frame up to the symmetry of the cube.
Eigen::Matrix3d nearest_rotation(Eigen::Matrix3d frame, std::size_t tet) {
  if (frame.determinant() < 0) frame.col(2) *= -1;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(frame, Eigen::ComputeFullU | Eigen::ComputeFullV);
  if (!frame.allFinite() || svd.singularValues()(2) < 1e-6 * svd.singularValues()(0)) {
    throw InputError("the frame of tet " + std::to_string(tet) + " is not three independent vectors");
  }
  return svd.matrixU() * svd.matrixV().transpose();
}

}  // namespace

FieldMesh make_field_mesh(std::vector<Eigen::Vector3d> points, std::vector<Tet> tets,
                          std::vector<Eigen::Matrix3d> frames, std::vector<EdgeKey> features) {
  if (frames.size() != tets.size()) {
    throw InputError("expected one frame per tet, " + std::to_string(tets.size()) + ", found " +
                     std::to_string(frames.size()));
  }
  check_tets(tets, points.size());
  orient_tets(points, tets);
  for (std::size_t t = 0; t < frames.size(); ++t) frames[t] = nearest_rotation(frames[t], t);
  std::sort(features.begin(), features.end());
  features.erase(std::unique(features.begin(), features.end()), features.end());
  std::vector<int> twin = half_face_twins(tets, points.size());
  std::vector<OctahedralRotation> matchings(twin.size());
  return {std::move(points),   std::move(tets), std::move(frames),
          std::move(features), std::move(twin), std::move(matchings)};
}

int ring_of(const FieldMesh& mesh, const EdgeRings& rings, int tet, int a, int b) {
  const Tet& corners = at(mesh.tets, tet);
  return at(at(rings.edge_of_tet, tet), local_edge(corner_of(corners, a), corner_of(corners, b)));
}

int third_vertex(const FieldMesh& mesh, int half_face, int a, int b) {
  const auto vertices = half_face_vertices(mesh.tets, half_face);
  return *std::find_if(vertices.begin(), vertices.end(), [&](int v) { return v != a && v != b; });
}

double tet_volume(const FieldMesh& mesh, int tet) {
  return signed_volume(mesh.points, at(mesh.tets, tet));
}

double edge_length(const FieldMesh& mesh, const EdgeKey& edge) {
  return (at(mesh.points, edge[1]) - at(mesh.points, edge[0])).norm();
}

Eigen::Vector3d edge_middle(const FieldMesh& mesh, const EdgeKey& edge) {
  return (at(mesh.points, edge[0]) + at(mesh.points, edge[1])) / 2;
}

Eigen::Vector3d tet_center(const FieldMesh& mesh, int tet) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const int vertex : at(mesh.tets, tet)) sum += at(mesh.points, vertex);
  return sum / 4;
}

Eigen::Vector3d area_vector(const FieldMesh& mesh, int half_face) {
  const auto [a, b, c] = half_face_vertices(mesh.tets, half_face);
  const Eigen::Vector3d origin = at(mesh.points, a);
  return (at(mesh.points, b) - origin).cross(at(mesh.points, c) - origin) / 2;
}

double diagonal(const FieldMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& point : mesh.points) box.extend(point);
  return box.diagonal().norm();
}

std::vector<char> boundary_vertices(const FieldMesh& mesh) {
  std::vector<char> on_boundary(mesh.points.size(), 0);
  for (int h = 0; h < mesh.half_face_count(); ++h) {
    if (at(mesh.twin, h) >= 0) continue;
    for (const int vertex : half_face_vertices(mesh.tets, h)) at(on_boundary, vertex) = 1;
  }
  return on_boundary;
}

bool is_feature(const FieldMesh& mesh, const EdgeKey& edge) {
  return std::binary_search(mesh.features.begin(), mesh.features.end(), edge);
}

std::vector<EdgeKey> sharp_edges(const FieldMesh& mesh, double angle_deg) {
  const double cosine = std::cos(angle_deg * std::numbers::pi / 180);
  const EdgeRings rings = edge_rings(mesh.tets, mesh.twin);
  std::vector<EdgeKey> sharp;
  for (std::size_t e = 0; e < rings.vertices.size(); ++e) {
    if (!rings.on_boundary[e]) continue;
    const auto [a, b] = rings.vertices[e];
    const int begin_face =
        detail::other_half_face(at(mesh.tets, rings.ring(e).front() / 4), rings.ring(e).front(), a, b);
    const Eigen::Vector3d first = area_vector(mesh, begin_face).normalized();
    if (first.dot(area_vector(mesh, rings.ring(e).back()).normalized()) < cosine)
      sharp.push_back(edge_key(a, b));
  }
  std::sort(sharp.begin(), sharp.end());
  return sharp;
}

}  // namespace neurframe
