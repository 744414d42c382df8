#include "cubecover/constraints.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cubecover/arc_orientation.hpp"

namespace neurframe {

CombedField comb_field(FieldMesh mesh) {
  CombedField field;
  field.cut = comb_and_cut(mesh);
  field.mesh = std::move(mesh);
  field.rings = edge_rings(field.mesh.tets, field.mesh.twin);
  field.classes = corner_classes(field.mesh, field.cut);
  field.boundary_edges = find_boundary_edges(field.mesh, field.rings);
  field.boundary_axis = boundary_axes(field.mesh, field.boundary_edges);
  field.singular = find_singular_graph(field.mesh, field.rings);
  orient_arcs(field.mesh, field.boundary_axis, field.singular);
  return field;
}

namespace {

Combination unknown_of(int unknown) {
  return {{unknown, Rational(1)}};
}

class Constraints {
 public:
  explicit Constraints(const CombedField& field) : field_(field), mesh_(field.mesh) {
    for (int i = 0; i < 3 * field.classes.count(); ++i) elimination_.add_real();
  }

  Elimination build() {
    align_boundary();
    close_seams();
    align_features();
    align_singular_edges();
    fix_nodes();
    pin_translations();
    return std::move(elimination_);
  }

 private:
  bool is_integral(const Combination& resolved) const {
    return std::all_of(resolved.begin(), resolved.end(), [&](const Term& term) {
      return elimination_.is_integer(term.unknown) && term.coefficient.denominator == 1;
    });
  }

  void make_integer(int unknown) {
    if (is_integral(elimination_.resolve(unknown))) return;
    const Term integer{elimination_.add_integer(), Rational(-1)};
    elimination_.require_zero(add_scaled(unknown_of(unknown), Rational(1), {integer}));
  }

  void make_equal(int first, int second) {
    elimination_.require_zero(add_scaled(unknown_of(first), Rational(-1), unknown_of(second)));
  }

  int coordinate(int tet, int vertex, int axis) const {
    return coordinate_unknown(field_, tet, corner_of(at(mesh_.tets, tet), vertex), axis);
  }

  void align_boundary() {
    for (int h = 0; h < mesh_.half_face_count(); ++h) {
      const int axis = at(field_.boundary_axis, h).axis;
      if (axis < 0) continue;
      const auto [a, b, c] = half_face_vertices(mesh_.tets, h);
      make_integer(coordinate(h / 4, a, axis));
      make_equal(coordinate(h / 4, b, axis), coordinate(h / 4, a, axis));
      make_equal(coordinate(h / 4, c, axis), coordinate(h / 4, a, axis));
    }
  }

  // u_s = R u_t + j at the three vertices of every cut face; each face brings its own three integers j, and
  // those of one sheet of the cut become one in the elimination.
  void close_seams() {
    for (int h = 0; h < mesh_.half_face_count(); ++h) {
      if (!at(field_.cut, h) || at(mesh_.twin, h) < h) continue;
      const OctahedralRotation rotation = at(mesh_.matchings, h);
      for (int row = 0; row < 3; ++row) {
        const int translation = elimination_.add_integer();
        for (const int vertex : half_face_vertices(mesh_.tets, h)) {
          const int to = coordinate(at(mesh_.twin, h) / 4, vertex, row);
          const int from = coordinate(h / 4, vertex, rotation.axis(row));
          Combination seam = add_scaled(unknown_of(to), Rational(-rotation.sign(row)), unknown_of(from));
          elimination_.require_zero(add_scaled(seam, Rational(-1), unknown_of(translation)));
        }
      }
    }
  }

  // Two coordinates are constant and integer along a feature: those transverse to it.
  void align_features() {
    for (const BoundaryEdge& edge : field_.boundary_edges) {
      if (!is_feature(mesh_, edge_key(edge.vertices[0], edge.vertices[1]))) continue;
      align_edge(edge.begin_face / 4, edge.vertices, tangent_axis(mesh_, edge, field_.boundary_axis));
    }
  }

  void align_singular_edges() {
    for (const SingularEdge& edge : field_.singular.edges) align_edge(edge.tet, edge.vertices, edge.axis);
  }

  void align_edge(int tet, const EdgeKey& edge, int tangent) {
    for (int axis = 0; axis < 3; ++axis) {
      if (axis == tangent) continue;
      make_integer(coordinate(tet, edge[0], axis));
      make_equal(coordinate(tet, edge[1], axis), coordinate(tet, edge[0], axis));
    }
  }

  // Nodes of the singular graph, corners of the features, and singular vertices on features are grid points.
  void fix_nodes() {
    std::vector<int> feature_degree(mesh_.points.size(), 0);
    for (const auto& [a, b] : mesh_.features) {
      ++at(feature_degree, a);
      ++at(feature_degree, b);
    }
    std::vector<char> node(mesh_.points.size(), 0);
    for (const int vertex : field_.singular.nodes) at(node, vertex) = 1;
    for (int v = 0; v < mesh_.point_count(); ++v) {
      const int degree = at(feature_degree, v);
      if (degree != 0 && (degree != 2 || !at(field_.singular.edges_of_vertex, v).empty())) at(node, v) = 1;
    }
    for (int c = 0; c < field_.classes.count(); ++c) {
      for (int axis = 0; axis < 3 && at(node, at(field_.classes.vertex, c)); ++axis)
        make_integer(3 * c + axis);
    }
  }

  // The map of a connected component may move by any integer vector in all of its (combed) charts at once:
  // per axis one coordinate is set to zero, an integer one where there is any.
  void pin_translations() {
    const std::vector<int> component = components(mesh_);
    const int component_count = *std::max_element(component.begin(), component.end()) + 1;
    std::vector<int> of_class(field_.classes.vertex.size());
    for (int t = 0; t < mesh_.tet_count(); ++t) {
      for (const int c : at(field_.classes.of_corner, t)) at(of_class, c) = at(component, t);
    }
    std::vector<int> pin(static_cast<std::size_t>(3 * component_count), -1);
    std::vector<char> integral(pin.size(), 0);
    for (int unknown = 0; unknown < 3 * field_.classes.count(); ++unknown) {
      const int slot = 3 * at(of_class, unknown / 3) + unknown % 3;
      if (at(integral, slot)) continue;
      at(integral, slot) = is_integral(elimination_.resolve(unknown));
      if (at(integral, slot) || at(pin, slot) < 0) at(pin, slot) = unknown;
    }
    for (const int unknown : pin) elimination_.require_zero(unknown_of(unknown));
  }

  const CombedField& field_;
  const FieldMesh& mesh_;
  Elimination elimination_;
};

}  // namespace

Elimination constrain(const CombedField& field) {
  return Constraints(field).build();
}

}  // namespace neurframe
