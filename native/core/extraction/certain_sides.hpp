// On which sides of the facets of a simplex a point certainly lies, told from doubles alone.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "core/extraction/grid_map.hpp"

namespace neurframe {

// One bit per facet; a facet with neither bit is too near for doubles to tell.
template <int N>
struct CertainSides {
  static constexpr unsigned all = (1u << (N + 1)) - 1;

  unsigned inside = 0;
  unsigned outside = 0;

  bool all_inside() const { return inside == all; }

  // The one facet that the point lies outside of, with all others certain; -1 where there is none such.  A
  // segment from a point of the simplex leaves through it, whatever the direction.
  int only_exit() const {
    const bool single = outside != 0 && (outside & (outside - 1)) == 0;
    return single && (inside | outside) == all ? std::countr_zero(outside) : -1;
  }
};

// From values that are positive inside of a facet, with this absolute error.
template <int N>
CertainSides<N> certain_sides_of(const RealPoint<N + 1>& values, double error) {
  CertainSides<N> sides;
  for (std::size_t facet = 0; facet <= N; ++facet) {
    sides.inside |= (values[facet] > error ? 1u : 0u) << facet;
    sides.outside |= (values[facet] < -error ? 1u : 0u) << facet;
  }
  return sides;
}

namespace detail {

// Determinants of the corners as seen from p, per facet: positive inside in a positively oriented simplex.
// With M the largest coordinate and u = 2^-53: N = 3: entries of a cross product have error 4 u M^2, the
// value 28 u M^3 < 2^-48 M^3; N = 2: 4 u M^2 = 2^-51 M^2.  Twice that is used.
inline CertainSides<3> certain_sides_from(const std::array<RealPoint<3>, 4>& x, double largest, double sign) {
  const auto cross = [](const RealPoint<3>& a, const RealPoint<3>& b) {
    return RealPoint<3>{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  };
  const auto dot = [](const RealPoint<3>& a, const RealPoint<3>& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  };
  const RealPoint<3> front = cross(x[0], x[1]);
  const RealPoint<3> back = cross(x[2], x[3]);
  return certain_sides_of<3>(
      {sign * dot(x[1], back), -sign * dot(x[0], back), sign * dot(x[3], front), -sign * dot(x[2], front)},
      0x1p-47 * largest * largest * largest);
}

inline CertainSides<2> certain_sides_from(const std::array<RealPoint<2>, 3>& x, double largest, double sign) {
  const auto turn = [&](std::size_t a, std::size_t b) {
    return sign * (x[a][0] * x[b][1] - x[a][1] * x[b][0]);
  };
  return certain_sides_of<2>({turn(0, 1), turn(1, 2), turn(2, 0)}, 0x1p-50 * largest * largest);
}

}  // namespace detail

// For a point in the chart of simplex t, which must not be flat.
template <int N>
CertainSides<N> certain_sides(const GridMap<N>& map, int t, const FixedPoint<N>& p) {
  const auto& P = map.P[static_cast<std::size_t>(t)];
  std::array<RealPoint<N>, N + 1> x;
  double largest = 0.0;
  for (std::size_t i = 0; i <= N; ++i) {
    for (std::size_t k = 0; k < N; ++k) {
      x[i][k] = static_cast<double>(P[i][k] - p[k]);  // exact: below 2^53
      largest = std::max(largest, std::abs(x[i][k]));
    }
  }
  return detail::certain_sides_from(x, largest, map.orientation[static_cast<std::size_t>(t)]);
}

}  // namespace neurframe
