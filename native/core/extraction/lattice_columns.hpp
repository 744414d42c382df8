// The columns of the lattice over a simplex, cut down in doubles to what may lie in it.
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

// Indices along the last axis, for one column.
struct ColumnRange {
  std::int64_t begin = 0;         // all whose points may lie in the closed simplex
  std::int64_t end = 0;           // exclusive
  std::int64_t inside_begin = 0;  // those of them whose points certainly lie strictly inside
  std::int64_t inside_end = 0;

  bool certainly_inside(std::int64_t index) const { return inside_begin <= index && index < inside_end; }
};

// Every facet bounds the columns at a height that is linear over them: one division a facet and simplex.
//
// Heights count from the bottom of the box, in cells, and times |slope| they are values of SimplexPlanes.
// With M the extent of the simplex and u = 2^-53, a value at a corner of the box has error 360 u M^3 and the
// two steps along the box 96 u M^3; rounding a sum of at most 104 M^3 five times adds 520 u M^3.  The slack
// is 2048 u M^3 (N = 2: 2^-46 M^2, for less than half of it).
template <int N>
class ColumnCutter {
 public:
  ColumnCutter(const SimplexPlanes<N>& planes, const LatticeBox<N>& box, Fixed one, Fixed shift)
      : low_(box.low), top_(static_cast<double>(box.high[N - 1] - box.low[N - 1])) {
    const FixedPoint<N> corner = lattice_point<N>(box.low, one, shift);
    for (std::size_t facet = 0; facet <= N; ++facet)
      add_facet(planes, facet, corner, static_cast<double>(one));
  }

  ColumnRange operator()(const LatticeIndex<N>& index) const {
    Reach possible{0.0, top_};
    Reach certain = possible;
    for (std::size_t i = 0; i < floors_.count; ++i) {
      const double height = floors_.items[i].at(index, low_);
      possible.low = std::max(possible.low, height - floors_.items[i].slack);
      certain.low = std::max(certain.low, height + floors_.items[i].slack);
    }
    for (std::size_t i = 0; i < ceilings_.count; ++i) {
      const double height = ceilings_.items[i].at(index, low_);
      possible.high = std::min(possible.high, height + ceilings_.items[i].slack);
      certain.high = std::min(certain.high, height - ceilings_.items[i].slack);
    }
    for (std::size_t i = 0; i < walls_.count; ++i) {
      const double value = walls_.items[i].at(index, low_);
      if (value < -walls_.items[i].slack) return {};
      if (!(value > walls_.items[i].slack)) certain.high = -1.0;
    }
    return range(possible, certain);
  }

 private:
  struct Reach {
    double low;
    double high;
  };

  // The height of a facet over the columns; for walls, which are nearly parallel to them, the value.
  struct Bound {
    double start = 0.0;
    std::array<double, N - 1> gradient{};
    double slack = 0.0;

    double at(const LatticeIndex<N>& index, const LatticeIndex<N>& low) const {
      double sum = start;
      for (std::size_t k = 0; k + 1 < N; ++k) sum += gradient[k] * static_cast<double>(index[k] - low[k]);
      return sum;
    }
  };
  struct Bounds {
    std::array<Bound, N + 1> items;
    std::size_t count = 0;
  };

  void add_facet(const SimplexPlanes<N>& planes, std::size_t facet, const FixedPoint<N>& corner, double one) {
    const RealPoint<N>& normal = planes.normal(facet);
    const double slope = normal[N - 1] * one;
    const double slack = 2.0 * planes.error();
    const bool wall = !(slack < 0.25 * std::abs(slope));
    const double scale = wall ? 1.0 : -1.0 / slope;
    Bounds& bounds = wall ? walls_ : (slope > 0.0 ? floors_ : ceilings_);
    Bound& bound = bounds.items[bounds.count++];
    bound.start = scale * planes.value(facet, corner);
    for (std::size_t k = 0; k + 1 < N; ++k) bound.gradient[k] = scale * normal[k] * one;
    bound.slack = wall ? slack + std::abs(slope) * top_ : slack / std::abs(slope);
  }

  ColumnRange range(const Reach& possible, const Reach& certain) const {
    if (!(possible.low <= possible.high)) return {};
    const std::int64_t bottom = low_[N - 1];
    ColumnRange found{bottom + rounded_up(possible.low), bottom + rounded_down(possible.high) + 1, 0, 0};
    if (certain.low <= certain.high) {
      found.inside_begin = bottom + rounded_up(certain.low);
      found.inside_end = bottom + rounded_down(certain.high) + 1;
    }
    return found;
  }

  // Of heights, which are not negative; faster than std::ceil and std::floor where those are calls.
  static std::int64_t rounded_down(double height) { return static_cast<std::int64_t>(height); }
  static std::int64_t rounded_up(double height) {
    const std::int64_t below = rounded_down(height);
    return below + (static_cast<double>(below) < height ? 1 : 0);
  }

  LatticeIndex<N> low_;
  double top_;
  Bounds floors_;
  Bounds ceilings_;
  Bounds walls_;
};

}  // namespace neurframe
