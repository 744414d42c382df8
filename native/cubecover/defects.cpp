#include "cubecover/defects.hpp"

#include <algorithm>
#include <optional>
#include <random>

#include "core/fixed_point.hpp"
#include "cubecover/exact_map.hpp"
#include "cubecover/vertex_star.hpp"

namespace neurframe {

const char* name_of(Defect::Kind kind) {
  switch (kind) {
    case Defect::Kind::compound_edge:
      return "compound edge";
    case Defect::Kind::off_axis_edge:
      return "off-axis edge";
    case Defect::Kind::turning_point:
      return "turning point";
    case Defect::Kind::grazing_end:
      return "grazing end";
    case Defect::Kind::empty_sector:
      return "empty sector";
    case Defect::Kind::overfull_sector:
      return "overfull sector";
    case Defect::Kind::crooked_sector:
      return "crooked sector";
    case Defect::Kind::degenerate_tet:
      return "degenerate tet";
  }
  return "";
}

double weight_of(Defect::Kind kind) {
  switch (kind) {
    case Defect::Kind::compound_edge:
      return 10;
    case Defect::Kind::empty_sector:
    case Defect::Kind::overfull_sector:
      return 5;
    case Defect::Kind::turning_point:
    case Defect::Kind::grazing_end:
      return 3;
    case Defect::Kind::crooked_sector:
      return 2;
    case Defect::Kind::degenerate_tet:
      return 1;
    case Defect::Kind::off_axis_edge:
      return 0;  // a short jog of a line; most maps carry a few
  }
  return 0;
}

double defect_score(const std::vector<Defect>& defects) {
  double score = 0;
  for (const Defect& defect : defects) score += weight_of(defect.kind);
  return score;
}

namespace {

constexpr double farthest_off_axis_deg = 54.7;  // the diagonal of the cube: beyond it another axis is nearer

Eigen::Vector3d middle(const FieldMesh& mesh, const EdgeKey& edge) {
  return (at(mesh.points, edge[0]) + at(mesh.points, edge[1])) / 2;
}

// The chart axis along the singular edge, pointing towards the vertex or away from it.
SignedAxis axis_at(const SingularEdge& edge, int vertex, bool towards) {
  const bool edge_ends_here = edge.vertices[1] == vertex;
  return {edge.axis, edge_ends_here == towards ? edge.orientation : -edge.orientation};
}

bool is_turning_point(const CombedField& field, int vertex) {
  const std::vector<int>& around = at(field.singular.edges_of_vertex, vertex);
  if (around.size() != 2) return false;
  const SingularEdge& arriving = at(field.singular.edges, around[0]);
  const SingularEdge& leaving = at(field.singular.edges, around[1]);
  if (arriving.axis < 0 || leaving.axis < 0) return false;
  const OctahedralRotation across = transport_in_star(field.mesh, vertex, arriving.tet, leaving.tet);
  return !(carried(across, axis_at(arriving, vertex, true)) == axis_at(leaving, vertex, false));
}

void add_edge_defects(const CombedField& field, std::vector<Defect>& defects) {
  for (const SingularEdge& edge : field.singular.edges) {
    if (edge.axis < 0) {
      defects.push_back({Defect::Kind::compound_edge, middle(field.mesh, edge.vertices)});
    } else if (edge.off_axis_deg > farthest_off_axis_deg) {
      defects.push_back({Defect::Kind::off_axis_edge, middle(field.mesh, edge.vertices)});
    }
  }
}

void add_turning_points(const CombedField& field, std::vector<Defect>& defects) {
  const std::vector<char> on_boundary = boundary_vertices(field.mesh);
  for (int v = 0; v < field.mesh.point_count(); ++v) {
    if (!at(on_boundary, v) && is_turning_point(field, v)) {
      defects.push_back({Defect::Kind::turning_point, at(field.mesh.points, v)});
    }
  }
}

// Whether the direction, laid into the face's plane, points from the corner into the face.
bool points_into_face(const FieldMesh& mesh, int half_face, int vertex, const Eigen::Vector3d& direction) {
  const std::array<int, 3> corners = half_face_vertices(mesh.tets, half_face);
  const auto corner = static_cast<std::size_t>(std::find(corners.begin(), corners.end(), vertex) - corners.begin());
  const Eigen::Vector3d normal = area_vector(mesh, half_face);
  const Eigen::Vector3d first = at(mesh.points, corners[(corner + 1) % 3]) - at(mesh.points, vertex);
  const Eigen::Vector3d second = at(mesh.points, corners[(corner + 2) % 3]) - at(mesh.points, vertex);
  return normal.dot(first.cross(direction)) >= 0 && normal.dot(direction.cross(second)) >= 0;
}

// A line that leaves a vertex of the boundary along a chart axis in the plane of a part of the boundary that goes
// the same way would lie in that plane, and what is between has no volume.
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
      defects.push_back({*kind, middle(field.mesh, edge.vertices)});
    }
  }
}

}  // namespace

std::vector<Defect> field_defects(const CombedField& field) {
  std::vector<Defect> defects;
  add_edge_defects(field, defects);
  add_turning_points(field, defects);
  add_grazing_ends(field, defects);
  add_sector_defects(field, defects);
  return defects;
}

std::vector<Defect> degenerate_tets(const CombedField& field, const ReducedMap& map) {
  std::mt19937_64 random(1);  // any values do; fixed ones make the answer repeatable
  Eigen::VectorXd columns(map.column_count());
  for (Eigen::Index i = 0; i < columns.size(); ++i) columns(i) = static_cast<double>(random() % 65536);
  const ExactMap exact = round_to_grid(map, columns);
  std::vector<Defect> defects;
  for (int t = 0; t < field.mesh.tet_count(); ++t) {
    const auto& u = at(exact.parameters, t);
    if (orient3d(u[0], u[1], u[2], u[3]) == 0) {
      defects.push_back({Defect::Kind::degenerate_tet, tet_center(field.mesh, t)});
    }
  }
  return defects;
}

}  // namespace neurframe
