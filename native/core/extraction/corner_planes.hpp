// On which sides of the facets of a simplex the corners of its cells lie.
#pragma once

#include <array>

#include "core/extraction/certain_sides.hpp"
#include "core/extraction/diagonal_walk.hpp"
#include "core/extraction/simplex_planes.hpp"

namespace neurframe {

// Values at the corners of a cell are those at its centre plus a step that is the same for all cells of the
// simplex.
template <int N>
class CornerPlanes {
 public:
  // half: one half of a cell.  With the bounds of SimplexPlanes a step has error 60 u M^3 for N = 3, and the
  // sum adds 84 u M^3 to the 360 u M^3 of the centre: 504 u M^3 < 2^-44 M^3, as at any other point (N = 2
  // likewise: 24 u M^2 and 14 u M^2 < 2^-47 M^2).
  CornerPlanes(const SimplexPlanes<N>& planes, Fixed half) : planes_(planes) {
    for (int corner = 0; corner < cell_corners<N>; ++corner) {
      const std::array<int, N> s = diagonal<N>(corner);
      for (std::size_t facet = 0; facet <= N; ++facet) {
        double step = 0.0;
        for (std::size_t k = 0; k < N; ++k) step += planes.normal(facet)[k] * s[k];
        steps_[static_cast<std::size_t>(corner)][facet] = step * static_cast<double>(half);
      }
    }
  }

  RealPoint<N + 1> values(const FixedPoint<N>& centre) const {
    RealPoint<N + 1> values;
    for (std::size_t facet = 0; facet <= N; ++facet) values[facet] = planes_.value(facet, centre);
    return values;
  }

  CertainSides<N> sides(RealPoint<N + 1> values, int corner) const {
    for (std::size_t facet = 0; facet <= N; ++facet)
      values[facet] += steps_[static_cast<std::size_t>(corner)][facet];
    return certain_sides_of<N>(values, planes_.error());
  }

 private:
  const SimplexPlanes<N>& planes_;
  std::array<RealPoint<N + 1>, cell_corners<N>> steps_;
};

}  // namespace neurframe
