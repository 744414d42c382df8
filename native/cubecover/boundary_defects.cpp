#include "cubecover/boundary_defects.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "cubecover/vertex_star.hpp"

namespace neurframe {

namespace {

constexpr double narrowest = std::numbers::pi / 6;  // between two features along different axes

// Whether the direction, laid into the face's plane, points from the corner into the face.
bool points_into_face(const FieldMesh& mesh, int half_face, int vertex, const Eigen::Vector3d& direction) {
  const std::array<int, 3> corners = half_face_vertices(mesh.tets, half_face);
  const auto corner =
      static_cast<std::size_t>(std::find(corners.begin(), corners.end(), vertex) - corners.begin());
  const Eigen::Vector3d normal = area_vector(mesh, half_face);
  const Eigen::Vector3d first = at(mesh.points, corners[(corner + 1) % 3]) - at(mesh.points, vertex);
  const Eigen::Vector3d second = at(mesh.points, corners[(corner + 2) % 3]) - at(mesh.points, vertex);
  return normal.dot(first.cross(direction)) >= 0 && normal.dot(direction.cross(second)) >= 0;
}

// A line that leaves a vertex of the boundary along a chart axis in the plane of a part of the boundary that
// goes the same way would lie in that plane, and what is between has no volume.
bool is_grazing(const CombedField& field, const SingularEdge& edge, int vertex,
                const std::vector<int>& faces_at_vertex) {
  const SignedAxis leaving = axis_at(edge, vertex, false);
  return std::any_of(faces_at_vertex.begin(), faces_at_vertex.end(), [&](int face) {
    const SignedAxis axis = carried(transport_in_star(field.mesh, vertex, edge.tet, face / 4), leaving);
    return axis.axis != at(field.boundary_axis, face).axis &&
           points_into_face(field.mesh, face, vertex, direction_of(at(field.mesh.frames, face / 4), axis));
  });
}

void add_grazing_ends(const CombedField& field, std::vector<Defect>& defects) {
  std::vector<std::vector<int>> faces(field.mesh.points.size());
  for (int h = 0; h < field.mesh.half_face_count(); ++h) {
    if (at(field.mesh.twin, h) >= 0) continue;
    for (const int vertex : half_face_vertices(field.mesh.tets, h)) at(faces, vertex).push_back(h);
  }
  for (const SingularEdge& edge : field.singular.edges) {
    for (const int end : edge.vertices) {
      if (edge.axis >= 0 && !at(faces, end).empty() && is_grazing(field, edge, end, at(faces, end)))
        defects.push_back({Defect::Kind::grazing_end, at(field.mesh.points, end)});
    }
  }
}

std::optional<Defect::Kind> sector_defect(int quarter_turns, bool feature) {
  if (quarter_turns == 0) return Defect::Kind::empty_sector;
  if (quarter_turns == 4) return Defect::Kind::overfull_sector;
  if (quarter_turns < 0 || (quarter_turns != 2 && !feature)) return Defect::Kind::crooked_sector;
  return {};
}

void add_sector_defects(const CombedField& field, std::vector<Defect>& defects) {
  for (const BoundaryEdge& edge : field.boundary_edges) {
    const bool feature = is_feature(field.mesh, edge_key(edge.vertices[0], edge.vertices[1]));
    const int quarter_turns = sector_quarter_turns(field.mesh, edge, field.boundary_axis);
    if (const auto kind = sector_defect(quarter_turns, feature)) {
      defects.push_back({*kind, edge_middle(field.mesh, edge.vertices)});
    }
  }
}

// Walks over the boundary faces at a vertex, from one feature to the next, with the first one's axis.
class CornerWalks {
 public:
  explicit CornerWalks(const CombedField& field)
      : field_(field), mesh_(field.mesh), edges_(mesh_.twin.size()) {
    for (const BoundaryEdge& edge : field.boundary_edges) {
      at(edges_, edge.begin_face).push_back(&edge);
      at(edges_, edge.end_face).push_back(&edge);
    }
  }

  void add_empty_corners(std::vector<Defect>& defects) const {
    for (const BoundaryEdge& edge : field_.boundary_edges) {
      if (!is_feature_edge(edge)) continue;
      for (const int face : {edge.begin_face, edge.end_face}) {
        for (const int vertex : edge.vertices) {
          if (const auto kind = corner_defect(edge, face, vertex))
            defects.push_back({*kind, at(mesh_.points, vertex)});
        }
      }
    }
  }

 private:
  bool is_feature_edge(const BoundaryEdge& edge) const {
    return is_feature(mesh_, edge_key(edge.vertices[0], edge.vertices[1]));
  }

  // The axis along the feature away from the vertex, in the chart behind one of its faces.
  SignedAxis axis_from(const BoundaryEdge& edge, int face, int vertex) const {
    SignedAxis axis{tangent_axis(mesh_, edge, field_.boundary_axis), 1};
    if (face == edge.end_face) axis = carried(edge.across, axis);
    const int other = edge.vertices[0] == vertex ? edge.vertices[1] : edge.vertices[0];
    const Eigen::Vector3d direction = at(mesh_.points, other) - at(mesh_.points, vertex);
    if (direction_of(at(mesh_.frames, face / 4), axis).dot(direction) < 0) axis.sign = -axis.sign;
    return axis;
  }

  const BoundaryEdge* next_edge(int face, int vertex, const BoundaryEdge* edge) const {
    for (const BoundaryEdge* next : at(edges_, face)) {
      if (next != edge && (next->vertices[0] == vertex || next->vertices[1] == vertex)) return next;
    }
    return nullptr;
  }

  double angle_at(int face, int vertex) const {
    const std::array<int, 3> corners = half_face_vertices(mesh_.tets, face);
    std::array<Eigen::Vector3d, 2> sides;
    std::size_t count = 0;
    for (const int v : corners)
      if (v != vertex) sides[count++] = (at(mesh_.points, v) - at(mesh_.points, vertex)).normalized();
    return std::acos(std::clamp(sides[0].dot(sides[1]), -1.0, 1.0));
  }

  // Two features that leave the vertex along one axis, on either side of a narrow part of the boundary.  Each
  // corner is told once.
  std::optional<Defect::Kind> corner_defect(const BoundaryEdge& first, int face, int vertex) const {
    SignedAxis axis = axis_from(first, face, vertex);
    const BoundaryEdge* edge = &first;
    double angle = angle_at(face, vertex);
    while (true) {
      edge = next_edge(face, vertex, edge);
      if (edge == nullptr || angle > std::numbers::pi) return {};
      if (is_feature_edge(*edge)) {
        if (first.ring >= edge->ring || !(axis == axis_from(*edge, face, vertex))) return {};
        return angle < narrowest ? Defect::Kind::cusp : Defect::Kind::empty_corner;
      }
      const bool forwards = edge->begin_face == face;
      axis = carried(forwards ? edge->across : edge->across.inverse(), axis);
      face = forwards ? edge->end_face : edge->begin_face;
      angle += angle_at(face, vertex);
    }
  }

  const CombedField& field_;
  const FieldMesh& mesh_;
  std::vector<std::vector<const BoundaryEdge*>> edges_;  // per boundary half-face
};

}  // namespace

void add_boundary_defects(const CombedField& field, std::vector<Defect>& defects) {
  add_grazing_ends(field, defects);
  add_sector_defects(field, defects);
  CornerWalks(field).add_empty_corners(defects);
}

}  // namespace neurframe
