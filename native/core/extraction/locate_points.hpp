// Where a parameter point lies in its simplex, and in space: barycentric coordinates from exact determinants.
#pragma once

#include <array>

#include "core/extraction/perturbation.hpp"

namespace neurframe {

// A vertex of the result on the input: simplex and barycentric coordinates.
template <int N>
struct Location {
  int simplex = -1;
  std::array<double, N + 1> weights{};
};

inline Int128 signed_measure(const std::array<FixedPoint<2>, 3>& P) {
  return orient2d(P[0], P[1], P[2]);
}
inline Int128 signed_measure(const std::array<FixedPoint<3>, 4>& P) {
  return orient3d(P[0], P[1], P[2], P[3]);
}

// The barycentric coordinates over one simplex, which must not be flat.  They are linear in the point, so
// that a point costs a few products where a determinant per corner would cost many.
template <int N>
class SimplexLocator {
 public:
  SimplexLocator(const GridMap<N>& map, int simplex)
      : simplex_(simplex), whole_(signed_measure(map.P[static_cast<std::size_t>(simplex)])) {
    for (std::size_t i = 0; i < N; ++i) {
      const auto x = facet_points(map, (N + 1) * simplex + static_cast<int>(i));
      bases_[i] = x[0];
      const auto normal = outward_normal(x);
      for (std::size_t k = 0; k < N; ++k) inward_[i][k] = -Int128{normal[k]};
    }
  }

  // Exact zeros where the point lies on a facet, edge or vertex.
  Location<N> operator()(const FixedPoint<N>& point) const {
    Location<N> location{simplex_, {}};
    Int128 rest = whole_;  // the parts of all corners add up to the whole
    for (std::size_t i = 0; i < N; ++i) {
      Int128 part = 0;
      for (std::size_t k = 0; k < N; ++k) part += inward_[i][k] * (point[k] - bases_[i][k]);
      location.weights[corner_opposite(i)] = share(part);
      rest -= part;
    }
    location.weights[corner_opposite(N)] = share(rest);
    return location;
  }

 private:
  static std::size_t corner_opposite(std::size_t facet) {
    return static_cast<std::size_t>(Dimension<N>::opposite_corner[facet]);
  }
  double share(Int128 part) const { return static_cast<double>(part) / static_cast<double>(whole_); }

  int simplex_;
  Int128 whole_;
  std::array<FixedPoint<N>, N> bases_;
  std::array<std::array<Int128, N>, N> inward_;
};

template <int N>
Location<N> locate(const GridMap<N>& map, int simplex, const FixedPoint<N>& point) {
  return SimplexLocator<N>(map, simplex)(point);
}

template <int N>
Point3 position(const GridMap<N>& map, const Location<N>& location) {
  Point3 p{0, 0, 0};
  for (std::size_t i = 0; i <= N; ++i) {
    const auto v = static_cast<std::size_t>(map.S[static_cast<std::size_t>(location.simplex)][i]);
    for (std::size_t k = 0; k < 3; ++k) p[k] += location.weights[i] * map.V[v][k];
  }
  return p;
}

}  // namespace neurframe
