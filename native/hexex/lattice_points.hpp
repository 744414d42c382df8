// The lattice points of a tet: integer points (shift 0) or cell centres (shift one half), column by column.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "hexex/tet_planes.hpp"

namespace neurframe {

// Lattice index i stands for the coordinate i + shift, in cells.
struct LatticeBox {
  std::array<std::int64_t, 3> low;
  std::array<std::int64_t, 3> high;  // inclusive
  bool empty() const { return low[0] > high[0] || low[1] > high[1] || low[2] > high[2]; }
};

// The lattice indices whose points lie in the bounding box of tet t; shift in fixed point (0 or one half).
inline LatticeBox lattice_box(const GridMap& map, int t, Fixed shift) {
  LatticeBox box{};
  const auto& P = map.P[static_cast<std::size_t>(t)];
  for (std::size_t k = 0; k < 3; ++k) {
    const Fixed low = std::min({P[0][k], P[1][k], P[2][k], P[3][k]}) - shift;
    const Fixed high = std::max({P[0][k], P[1][k], P[2][k], P[3][k]}) - shift;
    box.low[k] = (low + map.one() - 1) >> map.fraction_bits;  // arithmetic shift: floor division
    box.high[k] = high >> map.fraction_bits;
  }
  return box;
}

struct Interval {
  std::int64_t begin;
  std::int64_t end;  // exclusive
};

// A superset of the indices along the third axis whose points lie in the closed tet, for one column.  `base`
// is the point of index 0 in that column.
inline Interval column_candidates(const TetPlanes& planes, const FixedPoint3& base, double one,
                                  Interval range) {
  for (std::size_t face = 0; face < 4; ++face) {
    const double slope = planes.normal(face)[2] * one;
    const double slack = 2.0 * planes.error() / std::abs(slope);
    if (!(slack < 0.25)) continue;  // nearly parallel to the column: bounds nothing reliably
    const FixedPoint3 middle{base[0], base[1], base[2] + static_cast<Fixed>(one) * range.begin};
    const double root = static_cast<double>(range.begin) - planes.value(face, middle) / slope;
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

// Calls visit(index_x, index_y, column) for every column of the box that may meet the closed tet.
template <class Visit>
void for_each_column(const TetPlanes& planes, const LatticeBox& box, Fixed one, Fixed shift,
                     const Visit& visit) {
  const auto at = [&](std::int64_t index) { return index * one + shift; };
  for (std::int64_t x = box.low[0]; x <= box.high[0]; ++x) {
    for (std::int64_t y = box.low[1]; y <= box.high[1]; ++y) {
      const Interval column = column_candidates(planes, {at(x), at(y), shift}, static_cast<double>(one),
                                                {box.low[2], box.high[2] + 1});
      visit(x, y, column);
    }
  }
}

}  // namespace neurframe
