// The lattice points of a simplex: integer points (shift 0) or cell centres (shift one half), column by
// column along the last axis.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "core/extraction/simplex_planes.hpp"

namespace neurframe {

// Lattice index i stands for the coordinate i + shift, in cells.
template <int N>
using LatticeIndex = std::type_identity_t<std::array<std::int64_t, N>>;

template <int N>
struct LatticeBox {
  LatticeIndex<N> low{};
  LatticeIndex<N> high{};  // inclusive

  bool empty() const {
    for (std::size_t k = 0; k < N; ++k) {
      if (low[k] > high[k]) return true;
    }
    return false;
  }
};

template <int N>
FixedPoint<N> lattice_point(const LatticeIndex<N>& index, Fixed one, Fixed shift) {
  FixedPoint<N> p{};
  for (std::size_t k = 0; k < N; ++k) p[k] = index[k] * one + shift;
  return p;
}

// The lattice indices whose points lie in the bounding box of simplex t; shift in fixed point (0 or one
// half).
template <int N>
LatticeBox<N> lattice_box(const GridMap<N>& map, int t, Fixed shift) {
  LatticeBox<N> box;
  const auto& P = map.P[static_cast<std::size_t>(t)];
  for (std::size_t k = 0; k < N; ++k) {
    const auto [low, high] =
        std::minmax_element(P.begin(), P.end(), [k](const auto& a, const auto& b) { return a[k] < b[k]; });
    box.low[k] =
        ((*low)[k] - shift + map.one() - 1) >> map.fraction_bits;  // arithmetic shift: floor division
    box.high[k] = ((*high)[k] - shift) >> map.fraction_bits;
  }
  return box;
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

struct Interval {
  std::int64_t begin;
  std::int64_t end;  // exclusive
};

// A superset of the indices along the last axis whose points lie in the closed simplex, for the column of
// `index`.
template <int N>
Interval column_candidates(const SimplexPlanes<N>& planes, LatticeIndex<N> index, Fixed one, Fixed shift,
                           Interval range) {
  for (std::size_t facet = 0; facet <= N; ++facet) {
    const double slope = planes.normal(facet)[N - 1] * static_cast<double>(one);
    const double slack = 2.0 * planes.error() / std::abs(slope);
    if (!(slack < 0.25)) continue;  // nearly parallel to the column: bounds nothing reliably
    index[N - 1] = range.begin;
    const double root =
        static_cast<double>(range.begin) - planes.value(facet, lattice_point<N>(index, one, shift)) / slope;
    const auto below = static_cast<std::int64_t>(std::floor(root - slack));
    const auto above = static_cast<std::int64_t>(std::ceil(root + slack));
    if (slope > 0) {
      range.begin = std::max(range.begin, below);
    } else {
      range.end = std::min(range.end, above + 1);
    }
    if (range.begin >= range.end) break;
  }
  return range;
}

// Calls visit(index, candidates) for every column of the box; the last entry of index is free.
template <int N, class Visit>
void for_each_column(const SimplexPlanes<N>& planes, const LatticeBox<N>& box, Fixed one, Fixed shift,
                     const Visit& visit) {
  if (box.empty()) return;
  LatticeIndex<N> index = box.low;
  while (true) {
    visit(index, column_candidates<N>(planes, index, one, shift, {box.low[N - 1], box.high[N - 1] + 1}));
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
  for_each_column<N>(planes, box, map.one(), shift, [&](LatticeIndex<N> index, Interval column) {
    for (index[N - 1] = column.begin; index[N - 1] < column.end; ++index[N - 1]) {
      const FixedPoint<N> p = lattice_point<N>(index, map.one(), shift);
      const FacetSigns<N> signs = planes.signs(p);
      if (none_negative(signs)) visit(p, signs);
    }
  });
}

}  // namespace neurframe
