// The lattice points of a simplex: integer points (shift 0) or cell centres (shift one half), column by
// column along the last axis.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "core/extraction/certain_sides.hpp"
#include "core/extraction/lattice_columns.hpp"
#include "core/extraction/simplex_planes.hpp"

namespace neurframe {

// The lattice indices whose points lie in the bounding box of simplex t; shift in fixed point (0 or one
// half).
template <int N>
LatticeBox<N> lattice_box(const GridMap<N>& map, int t, Fixed shift) {
  const auto& P = map.P[static_cast<std::size_t>(t)];
  FixedPoint<N> low = P[0];
  FixedPoint<N> high = P[0];
  for (std::size_t i = 1; i <= N; ++i) {
    for (std::size_t k = 0; k < N; ++k) {
      low[k] = std::min(low[k], P[i][k]);
      high[k] = std::max(high[k], P[i][k]);
    }
  }
  LatticeBox<N> box;
  for (std::size_t k = 0; k < N; ++k) {
    box.low[k] = (low[k] - shift + map.one() - 1) >> map.fraction_bits;  // arithmetic shift: floor division
    box.high[k] = (high[k] - shift) >> map.fraction_bits;
  }
  return box;
}

// True for a box without lattice points, or with few, all certainly outside of simplex t (not flat).  Where
// tets are smaller than cells that is the common case, and much cheaper to see than planes are to set up.
template <int N>
bool certainly_outside(const GridMap<N>& map, int t, const LatticeBox<N>& box, Fixed shift) {
  if (box.empty()) return true;
  constexpr std::int64_t few = 4;
  std::int64_t points = 1;
  for (std::size_t k = 0; k < N && points <= few; ++k) points *= box.high[k] - box.low[k] + 1;
  if (points > few) return false;
  for (std::int64_t i = 0; i < points; ++i) {
    LatticeIndex<N> index{};
    std::int64_t rest = i;
    for (std::size_t k = 0; k < N; ++k) {
      const std::int64_t size = box.high[k] - box.low[k] + 1;
      index[k] = box.low[k] + rest % size;
      rest /= size;
    }
    if (certain_sides(map, t, lattice_point<N>(index, map.one(), shift)).outside == 0) return false;
  }
  return true;
}

// The number of columns over the boxes of all simplices that are not flat; a double, because it may be huge.
template <int N>
double column_count(const GridMap<N>& map, Fixed shift) {
  double columns = 0.0;
  for (std::size_t t = 0; t < map.P.size(); ++t) {
    const LatticeBox<N> box = lattice_box(map, static_cast<int>(t), shift);
    if (box.empty() || map.orientation[t] == 0) continue;
    double base = 1.0;
    for (std::size_t k = 0; k + 1 < N; ++k) base *= static_cast<double>(box.high[k] - box.low[k] + 1);
    columns += base;
  }
  return columns;
}

// Calls visit(index, range) for every column of the box; the last entry of index is free.
template <int N, class Visit>
void for_each_column(const SimplexPlanes<N>& planes, const LatticeBox<N>& box, Fixed one, Fixed shift,
                     const Visit& visit) {
  if (box.empty()) return;
  const ColumnCutter<N> cut(planes, box, one, shift);
  LatticeIndex<N> index = box.low;
  while (true) {
    visit(index, cut(index));
    std::size_t axis = N - 1;  // odometer over all axes but the last
    while (axis > 0 && index[axis - 1] == box.high[axis - 1]) {
      index[axis - 1] = box.low[axis - 1];
      --axis;
    }
    if (axis == 0) return;
    ++index[axis - 1];
  }
}

// Calls visit(p, signs) for every lattice point of the closed simplex t, which must not be flat.
template <int N, class Visit>
void for_each_lattice_point(const GridMap<N>& map, const SimplexPlanes<N>& planes, const LatticeBox<N>& box,
                            Fixed shift, const Visit& visit) {
  FacetSigns<N> inside;
  inside.fill(1);
  for_each_column<N>(planes, box, map.one(), shift, [&](LatticeIndex<N> index, const ColumnRange& range) {
    for (index[N - 1] = range.begin; index[N - 1] < range.end; ++index[N - 1]) {
      const FixedPoint<N> p = lattice_point<N>(index, map.one(), shift);
      const FacetSigns<N> signs = range.certainly_inside(index[N - 1]) ? inside : planes.signs(p);
      if (none_negative(signs)) visit(p, signs);
    }
  });
}

}  // namespace neurframe
