#include "cubecover/exact_map.hpp"

#include <cmath>

#include "core/errors.hpp"

namespace neurframe {

namespace {

// sum of coefficient * value; exact whenever every value is a multiple of the coefficients' denominators
Fixed exact_sum(const ReducedMap& map, int row, const std::vector<Fixed>& columns) {
  Fixed sum = 0;
  for (int k = at(map.begin, row); k < at(map.begin, row + 1); ++k) {
    const Rational& coefficient = at(map.coefficient, k);
    sum += coefficient.numerator * (at(columns, at(map.column, k)) / coefficient.denominator);
  }
  return sum;
}

}  // namespace

ExactMap round_to_grid(const ReducedMap& map, const Eigen::VectorXd& columns) {
  const double largest = evaluate(map, columns).cwiseAbs().maxCoeff();
  ExactMap exact;
  exact.fraction_bits = fraction_bits_for(largest);
  if (exact.fraction_bits == 0) {
    throw StageError("the map spans more cells than fixed-point coordinates hold; ask for larger cells");
  }
  std::vector<Fixed> grid(static_cast<std::size_t>(map.column_count()));
  for (int c = 0; c < map.column_count(); ++c) {
    const Fixed step = c < map.real_count ? map.denominator : 1;
    const double value = c < map.real_count ? columns(c) / static_cast<double>(step) : std::round(columns(c));
    at(grid, c) = to_fixed(value, exact.fraction_bits) * step;
  }
  std::vector<Fixed> rows(static_cast<std::size_t>(map.row_count()));
  for (int row = 0; row < map.row_count(); ++row) at(rows, row) = exact_sum(map, row, grid);
  for (const std::array<int, 4>& classes : map.class_of_corner) {
    auto& corners = exact.parameters.emplace_back();
    for (int corner = 0; corner < 4; ++corner) {
      for (int axis = 0; axis < 3; ++axis)
        at(at(corners, corner), axis) = at(rows, 3 * at(classes, corner) + axis);
    }
  }
  return exact;
}

namespace {

class Verifier {
 public:
  Verifier(const CombedField& field, const ExactMap& map)
      : field_(field), mesh_(field.mesh), map_(map), one_(Fixed{1} << map.fraction_bits) {}

  Verification verify() {
    for (int t = 0; t < mesh_.tet_count(); ++t) {
      const auto& u = at(map_.parameters, t);
      if (orient3d(u[0], u[1], u[2], u[3]) <= 0) result_.folded_tets.push_back(t);
    }
    for (int h = 0; h < mesh_.half_face_count(); ++h) {
      if (at(mesh_.twin, h) < 0) {
        if (!lies_on_plane(h)) result_.unaligned_faces.push_back(h);
      } else if (at(mesh_.twin, h) > h && !is_closed_seam(h)) {
        result_.open_seams.push_back(h);
      }
    }
    check_interior_edges();
    check_boundary_edges();
    return result_;
  }

 private:
  const Vector3<Fixed>& parameter(int tet, int vertex) const {
    return at(at(map_.parameters, tet), corner_of(at(mesh_.tets, tet), vertex));
  }

  bool is_integer(Fixed value) const { return value % one_ == 0; }

  bool lies_on_plane(int half_face) const {
    const auto [a, b, c] = half_face_vertices(mesh_.tets, half_face);
    const int axis = at(field_.boundary_axis, half_face).axis;
    const Fixed height = at(parameter(half_face / 4, a), axis);
    return is_integer(height) && at(parameter(half_face / 4, b), axis) == height &&
           at(parameter(half_face / 4, c), axis) == height;
  }

  bool is_closed_seam(int half_face) const {
    const int twin = at(mesh_.twin, half_face);
    const auto translation = [&](int vertex) {
      return difference(parameter(twin / 4, vertex),
                        at(mesh_.matchings, half_face)(parameter(half_face / 4, vertex)));
    };
    const auto [a, b, c] = half_face_vertices(mesh_.tets, half_face);
    const Vector3<Fixed> first = translation(a);
    return is_integer(first[0]) && is_integer(first[1]) && is_integer(first[2]) && translation(b) == first &&
           translation(c) == first;
  }

  // How often the image of the tet at the edge sweeps over the direction, from its entering face up to but
  // not including its leaving face; counter-clockwise about the edge.
  bool sweeps(int half_face, const EdgeKey& edge, const Vector3<Fixed>& direction) const {
    const int tet = half_face / 4;
    const Vector3<Fixed>& origin = parameter(tet, edge[0]);
    const Vector3<Fixed> along = difference(parameter(tet, edge[1]), origin);
    const int leaving = half_face % 4;  // opposite corner of the leaving face: the entering face has it
    const int a = corner_of(at(mesh_.tets, tet), edge[0]);
    const int b = corner_of(at(mesh_.tets, tet), edge[1]);
    const Vector3<Fixed> enter = difference(at(at(map_.parameters, tet), leaving), origin);
    const Vector3<Fixed> leave = difference(at(at(map_.parameters, tet), 6 - a - b - leaving), origin);
    return determinant(along, enter, direction) >= 0 && determinant(along, direction, leave) > 0;
  }

  bool has_folded_tet(std::span<const int> ring) const {
    for (const int h : ring) {
      const auto& u = at(map_.parameters, h / 4);
      if (orient3d(u[0], u[1], u[2], u[3]) <= 0) return true;
    }
    return false;
  }

  // Turns of the image round an edge: of one direction that is carried along.
  int full_turns(std::span<const int> ring, const EdgeKey& edge, Vector3<Fixed> direction) const {
    int count = 0;
    for (const int h : ring) {
      count += sweeps(h, edge, direction) ? 1 : 0;
      if (at(mesh_.twin, h) >= 0) direction = at(mesh_.matchings, h)(direction);
    }
    return count;
  }

  // Quarter turns round an edge along a chart axis: sweeps over the four transverse axis directions.
  int quarter_turns(std::span<const int> ring, const EdgeKey& edge) const {
    int count = 0;
    for (const int h : ring) {
      const Vector3<Fixed> along = difference(parameter(h / 4, edge[1]), parameter(h / 4, edge[0]));
      const int axis = axis_of(along);
      if (axis < 0) return -1;
      for (const int transverse : {(axis + 1) % 3, (axis + 2) % 3}) {
        for (const Fixed sign : {1, -1}) {
          Vector3<Fixed> direction{0, 0, 0};
          at(direction, transverse) = sign;
          count += sweeps(h, edge, direction) ? 1 : 0;
        }
      }
    }
    return count;
  }

  static int axis_of(const Vector3<Fixed>& vector) {
    for (int axis = 0; axis < 3; ++axis) {
      if (at(vector, axis) != 0 && at(vector, (axis + 1) % 3) == 0 && at(vector, (axis + 2) % 3) == 0)
        return axis;
    }
    return -1;
  }

  void record(int ring, int counted, int expected) {
    if (counted < 0 || counted != expected) result_.wound_edges.push_back({ring, counted, expected});
  }

  void check_interior_edges() {
    std::vector<int> expected(field_.rings.vertices.size(), 4);
    for (const SingularEdge& edge : field_.singular.edges) at(expected, edge.ring) = edge.valence;
    for (int e = 0; e < static_cast<int>(expected.size()); ++e) {
      if (at(field_.rings.on_boundary, e)) continue;
      const std::span<const int> ring = field_.rings.ring(static_cast<std::size_t>(e));
      const EdgeKey& edge = at(field_.rings.vertices, e);
      if (has_folded_tet(ring)) continue;  // reported as folded
      const bool singular = at(expected, e) != 4;
      const int start = ring.front();
      const Vector3<Fixed> entering =
          difference(at(at(map_.parameters, start / 4), start % 4), parameter(start / 4, edge[0]));
      record(e, singular ? quarter_turns(ring, edge) : 4 * full_turns(ring, edge, entering), at(expected, e));
    }
  }

  bool has_two_axes(const BoundaryEdge& edge) const {
    return carried(edge.across, at(field_.boundary_axis, edge.begin_face)).axis !=
           at(field_.boundary_axis, edge.end_face).axis;
  }

  void check_boundary_edges() {
    for (const BoundaryEdge& edge : field_.boundary_edges) {
      const std::span<const int> ring = field_.rings.ring(static_cast<std::size_t>(edge.ring));
      if (has_folded_tet(ring)) continue;
      const int expected = sector_quarter_turns(mesh_, edge, field_.boundary_axis);
      if (expected != 2) {
        const int counted = quarter_turns(ring, edge.vertices);
        // either way round is injective between faces of two axes
        const bool fits = has_two_axes(edge) && (counted == 1 || counted == 3);
        if (!fits) record(edge.ring, counted, expected);
        continue;
      }
      record(edge.ring, 2 * half_turns(ring, edge), 2);
    }
  }

  // Half turns between two faces of one plane: what the image sweeps of the two directions normal to it.  One
  // is injective on whichever side of the plane it lies; which one follows from the map, not from the field.
  int half_turns(std::span<const int> ring, const BoundaryEdge& edge) const {
    const int axis = at(field_.boundary_axis, edge.begin_face).axis;
    int count = 0;
    for (const Fixed side : {1, -1}) {
      Vector3<Fixed> direction{0, 0, 0};
      at(direction, axis) = side;
      count += full_turns(ring, edge.vertices, direction);
    }
    return count;
  }

  const CombedField& field_;
  const FieldMesh& mesh_;
  const ExactMap& map_;
  Fixed one_;
  Verification result_;
};

}  // namespace

Verification verify(const CombedField& field, const ExactMap& map) {
  return Verifier(field, map).verify();
}

}  // namespace neurframe
