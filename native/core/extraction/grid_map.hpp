// An integer-grid map of a triangle mesh (N = 2) or tet mesh (N = 3) in exact fixed-point coordinates, and
// the few facts that differ between the two dimensions.
//
// Facet h = (N + 1) t + i belongs to simplex t; its corners are Dimension<N>::facet_corners[i], in an order
// that turns outward in a positively oriented simplex.  For tets that is half_face_twins' numbering, for
// triangles half_edge_twins'.
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "core/fixed_point.hpp"
#include "core/octahedral_rotation.hpp"
#include "core/quarter_turn.hpp"
#include "core/tet_mesh.hpp"
#include "core/triangle_mesh.hpp"

namespace neurframe {

// The largest result: cells, and also integer points inside simplices, of which a few thin triangles may have
// billions without a single cell.
inline constexpr std::int64_t most_cells = std::int64_t{1} << 29;

// type_identity: N is told by the map that comes with them, not deduced from arrays (whose size is no int)
template <int N>
using FixedPoint = std::type_identity_t<std::array<Fixed, N>>;
template <int N>
using RealPoint = std::type_identity_t<std::array<double, N>>;
template <int N>
using Simplex = std::type_identity_t<std::array<int, N + 1>>;

template <int N>
struct Dimension;

template <>
struct Dimension<2> {
  using Rotation = QuarterTurn;
  using Transition = GridTransition2;
  static constexpr int rotations = 4;
  static constexpr std::array<std::array<int, 2>, 3> facet_corners{{{0, 1}, {1, 2}, {2, 0}}};
  static constexpr std::array<int, 3> opposite_corner{2, 0, 1};  // of each facet
};

template <>
struct Dimension<3> {
  using Rotation = OctahedralRotation;
  using Transition = GridTransition3;
  static constexpr int rotations = 24;
  static constexpr std::array<std::array<int, 3>, 4> facet_corners = face_corners;
  static constexpr std::array<int, 4> opposite_corner{0, 1, 2, 3};
};

template <int N>
using Rotation = typename Dimension<N>::Rotation;
template <int N>
using GridTransition = typename Dimension<N>::Transition;

// The transition function across a facet, from the chart of its simplex to the chart of the one behind it.
template <int N>
struct FacetTransition {
  std::array<std::int32_t, N> translation{};  // in cells
  Rotation<N> rotation;
  bool ambiguous = false;  // the image of the facet is too thin to tell the rotation
  bool exact = false;      // it maps the corners of the facet exactly, so that a walk may cross here
};

template <int N>
struct GridMap {
  static constexpr int corners = N + 1;

  std::vector<Point3> V;                       // positions
  std::vector<Simplex<N>> S;                   // triangles or tets
  std::vector<int> twin;                       // per facet, -1 on the boundary
  std::vector<FacetTransition<N>> transition;  // per facet
  std::vector<std::array<FixedPoint<N>, N + 1>>
      P;                                 // parameters per simplex and corner, in units of 2^-fraction_bits
  std::vector<std::int8_t> orientation;  // sign of the parametric volume: 1, 0 (flat), -1 (flipped)
  std::vector<char> touches_flat;        // per vertex: some simplex around it is flat
  int fraction_bits = 0;

  Fixed one() const { return Fixed{1} << fraction_bits; }
};

template <int N>
FixedPoint<N> carry(const FacetTransition<N>& transition, const FixedPoint<N>& x, int fraction_bits) {
  FixedPoint<N> moved = transition.rotation(x);
  for (std::size_t i = 0; i < N; ++i)
    moved[i] += Fixed{transition.translation[i]} * (Fixed{1} << fraction_bits);
  return moved;
}

template <int N>
GridTransition<N> as_grid_transition(const FacetTransition<N>& transition) {
  GridTransition<N> wide{transition.rotation, {}};
  for (std::size_t i = 0; i < N; ++i) wide.translation[i] = transition.translation[i];
  return wide;
}

template <int N>
std::array<FixedPoint<N>, N> facet_points(const GridMap<N>& map, int facet) {
  const auto& P = map.P[static_cast<std::size_t>(facet / (N + 1))];
  const auto& corners = Dimension<N>::facet_corners[static_cast<std::size_t>(facet % (N + 1))];
  std::array<FixedPoint<N>, N> points{};
  for (std::size_t k = 0; k < N; ++k) points[k] = P[static_cast<std::size_t>(corners[k])];
  return points;
}

template <int N>
std::array<int, N> facet_vertices(const std::vector<Simplex<N>>& S, int facet) {
  const Simplex<N>& simplex = S[static_cast<std::size_t>(facet / (N + 1))];
  const auto& corners = Dimension<N>::facet_corners[static_cast<std::size_t>(facet % (N + 1))];
  std::array<int, N> vertices{};
  for (std::size_t k = 0; k < N; ++k) vertices[k] = simplex[static_cast<std::size_t>(corners[k])];
  return vertices;
}

template <std::size_t Corners>
int corner_at(const std::array<int, Corners>& simplex, int vertex) {
  for (std::size_t i = 0; i < Corners; ++i) {
    if (simplex[i] == vertex) return static_cast<int>(i);
  }
  return -1;
}

}  // namespace neurframe
