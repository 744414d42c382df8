#include "cubecover/polycube.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "cubecover/octahedral_coefficients.hpp"
#include "cubecover/rotation_field.hpp"

namespace neurframe {

namespace {

// The frame nearest to all those behind the boundary, weighted by area.
Eigen::Matrix3d common_frame(const FieldMesh& mesh) {
  FrameCoefficients sum = FrameCoefficients::Zero();
  for (int h = 0; h < mesh.half_face_count(); ++h) {
    if (at(mesh.twin, h) < 0) sum += area_vector(mesh, h).norm() * coefficients_of(at(mesh.frames, h / 4));
  }
  return nearest_frame(sum, Eigen::Matrix3d::Identity());
}

bool is_border(const BoundaryEdge& edge, const std::vector<SignedAxis>& labels) {
  return !(at(labels, edge.begin_face) == at(labels, edge.end_face));
}

// Along a border the axis normal to neither side follows the edge, in the sense that the frames have now.
void add_border_targets(const FieldMesh& mesh, const EdgeRings& rings, const BoundaryEdge& edge,
                        const std::vector<SignedAxis>& labels, std::vector<AxisTarget>& targets) {
  const int begin = at(labels, edge.begin_face).axis;
  const int end = at(labels, edge.end_face).axis;
  if (begin == end) return;
  const int tangent = 3 - begin - end;
  const Eigen::Vector3d along =
      (at(mesh.points, edge.vertices[1]) - at(mesh.points, edge.vertices[0])).normalized();
  const int sign = at(mesh.frames, edge.begin_face / 4).col(tangent).dot(along) < 0 ? -1 : 1;
  for (const int h : rings.ring(static_cast<std::size_t>(edge.ring)))
    targets.push_back({h / 4, {tangent, sign}, along});
}

std::vector<AxisTarget> axis_targets(const FieldMesh& mesh, const EdgeRings& rings,
                                     const std::vector<BoundaryEdge>& edges,
                                     const std::vector<SignedAxis>& labels) {
  std::vector<AxisTarget> targets;
  for (int h = 0; h < mesh.half_face_count(); ++h) {
    if (at(labels, h).axis >= 0) targets.push_back({h / 4, at(labels, h), area_vector(mesh, h).normalized()});
  }
  for (const BoundaryEdge& edge : edges) {
    if (is_border(edge, labels)) add_border_targets(mesh, rings, edge, labels, targets);
  }
  return targets;
}

// Turns the frame behind each boundary face so that its axis is along the normal exactly.
void align_to_labels(FieldMesh& mesh, const std::vector<SignedAxis>& labels) {
  for (int h = 0; h < mesh.half_face_count(); ++h) {
    if (at(labels, h).axis < 0) continue;
    Eigen::Matrix3d& frame = at(mesh.frames, h / 4);
    frame =
        Eigen::Quaterniond::FromTwoVectors(direction_of(frame, at(labels, h)), area_vector(mesh, h)) * frame;
  }
}

std::vector<EdgeKey> borders(const std::vector<BoundaryEdge>& edges, const std::vector<SignedAxis>& labels) {
  std::vector<EdgeKey> found;
  for (const BoundaryEdge& edge : edges) {
    if (is_border(edge, labels)) found.push_back(edge_key(edge.vertices[0], edge.vertices[1]));
  }
  std::sort(found.begin(), found.end());
  return found;
}

std::vector<EdgeKey> label_borders(const FieldMesh& polycube) {
  const std::vector<BoundaryEdge> edges =
      find_boundary_edges(polycube, edge_rings(polycube.tets, polycube.twin));
  return borders(edges, boundary_axes(polycube, edges));
}

}  // namespace

FieldMesh polycube_field(FieldMesh mesh, const LabelCosts& costs) {
  const EdgeRings rings = edge_rings(mesh.tets, mesh.twin);
  const Eigen::Matrix3d background = common_frame(mesh);
  std::fill(mesh.matchings.begin(), mesh.matchings.end(), OctahedralRotation());
  std::fill(mesh.frames.begin(), mesh.frames.end(), background);
  const std::vector<BoundaryEdge> edges = find_boundary_edges(mesh, rings);
  const std::vector<SignedAxis> labels = surface_labels(mesh, edges, costs);
  mesh.frames = rotation_field(mesh, axis_targets(mesh, rings, edges, labels), background);
  align_to_labels(mesh, labels);
  std::vector<EdgeKey> followed;
  const std::vector<EdgeKey> of_labels = borders(edges, labels);
  std::set_union(mesh.features.begin(), mesh.features.end(), of_labels.begin(), of_labels.end(),
                 std::back_inserter(followed));
  mesh.features = std::move(followed);
  return mesh;
}

FieldMesh without_inner_features(FieldMesh polycube) {
  polycube.features = label_borders(polycube);
  return polycube;
}

FieldMesh without_inner_features_at(FieldMesh polycube, const std::vector<int>& tets) {
  const std::vector<EdgeKey> kept = label_borders(polycube);
  std::vector<EdgeKey> inner;
  std::set_difference(polycube.features.begin(), polycube.features.end(), kept.begin(), kept.end(),
                      std::back_inserter(inner));
  std::vector<std::vector<int>> edges_of_vertex(polycube.points.size());
  for (int e = 0; e < static_cast<int>(inner.size()); ++e) {
    for (const int v : at(inner, e)) at(edges_of_vertex, v).push_back(e);
  }
  std::vector<int> reached;  // vertices whose inner features go
  for (const int t : tets)
    reached.insert(reached.end(), at(polycube.tets, t).begin(), at(polycube.tets, t).end());
  std::vector<char> released(inner.size(), 0);
  for (std::size_t i = 0; i < reached.size(); ++i) {
    for (const int e : at(edges_of_vertex, reached[i])) {
      if (at(released, e)) continue;
      at(released, e) = 1;
      for (const int v : at(inner, e)) {
        if (at(edges_of_vertex, v).size() == 2) reached.push_back(v);
      }
    }
  }
  std::erase_if(polycube.features, [&](const EdgeKey& edge) {
    const auto found = std::lower_bound(inner.begin(), inner.end(), edge);
    return found != inner.end() && *found == edge &&
           released[static_cast<std::size_t>(found - inner.begin())];
  });
  return polycube;
}

}  // namespace neurframe
