#include "cubecover/defects.hpp"

#include <numeric>
#include <optional>
#include <random>

#include "core/fixed_point.hpp"
#include "cubecover/boundary_defects.hpp"
#include "cubecover/exact_map.hpp"
#include "cubecover/node_types.hpp"
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
    case Defect::Kind::empty_corner:
      return "empty corner";
    case Defect::Kind::cusp:
      return "cusp";
    case Defect::Kind::impossible_node:
      return "impossible node";
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
    case Defect::Kind::empty_corner:
    case Defect::Kind::cusp:
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
    case Defect::Kind::impossible_node:
      return 0;  // where edges are jagged their valence may be misread
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
      defects.push_back({Defect::Kind::compound_edge, edge_middle(field.mesh, edge.vertices)});
    } else if (edge.off_axis_deg > farthest_off_axis_deg) {
      defects.push_back({Defect::Kind::off_axis_edge, edge_middle(field.mesh, edge.vertices)});
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

// The edges of valence 3 and 5 at a vertex; none where there are others.
std::optional<NodeType> node_type(const SingularGraph& graph, int vertex) {
  NodeType type = {0, 0};
  for (const int e : at(graph.edges_of_vertex, vertex)) {
    const int valence = at(graph.edges, e).valence;
    if (valence != 3 && valence != 5) return {};
    ++(valence == 3 ? type.first : type.second);
  }
  return type;
}

}  // namespace

std::vector<int> impossible_nodes(const SingularGraph& graph) {
  std::vector<int> found;
  for (const int node : graph.nodes) {
    const std::optional<NodeType> type = node_type(graph, node);
    if (type && !is_node_type(*type)) found.push_back(node);
  }
  return found;
}

std::vector<Defect> field_defects(const CombedField& field) {
  std::vector<Defect> defects;
  add_edge_defects(field, defects);
  add_turning_points(field, defects);
  for (const int node : impossible_nodes(field.singular))
    defects.push_back({Defect::Kind::impossible_node, at(field.mesh.points, node)});
  add_boundary_defects(field, defects);
  return defects;
}

namespace {

// Fixed values make the answer repeatable.
Eigen::VectorXd random_columns(const ReducedMap& map, unsigned seed) {
  std::mt19937_64 random(seed);
  Eigen::VectorXd columns(map.column_count());
  for (Eigen::Index i = 0; i < columns.size(); ++i) columns(i) = static_cast<double>(random() % 65536);
  return columns;
}

}  // namespace

std::vector<Defect> degenerate_tets(const CombedField& field, const ReducedMap& map) {
  std::vector<int> flat(field.mesh.tets.size());
  std::iota(flat.begin(), flat.end(), 0);
  for (unsigned seed = 1; seed <= 2 && !flat.empty(); ++seed) {
    const ExactMap exact = round_to_grid(map, random_columns(map, seed));
    std::erase_if(flat, [&](int t) {
      const auto& u = at(exact.parameters, t);
      return orient3d(u[0], u[1], u[2], u[3]) != 0;
    });
  }
  std::vector<Defect> defects;
  for (const int t : flat) defects.push_back({Defect::Kind::degenerate_tet, tet_center(field.mesh, t)});
  return defects;
}

}  // namespace neurframe
