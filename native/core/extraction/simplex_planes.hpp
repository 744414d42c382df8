// Where a point lies with respect to the facets of a simplex: fast in doubles, exact where doubles cannot
// tell.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "core/extraction/perturbation.hpp"

namespace neurframe {

// Signs per facet: 1 inside of its plane, 0 on it, -1 outside.
template <int N>
using FacetSigns = std::type_identity_t<std::array<int, N + 1>>;

template <std::size_t Facets>
bool all_positive(const std::array<int, Facets>& signs) {
  return std::all_of(signs.begin(), signs.end(), [](int sign) { return sign > 0; });
}
template <std::size_t Facets>
bool none_negative(const std::array<int, Facets>& signs) {
  return std::all_of(signs.begin(), signs.end(), [](int sign) { return sign >= 0; });
}

// Exact sign of a point in the chart of simplex t, which must not be flat.
template <int N>
int exact_facet_sign(const GridMap<N>& map, int t, int facet, const FixedPoint<N>& p) {
  return -outer_side(facet_points(map, (N + 1) * t + facet), p) *
         map.orientation[static_cast<std::size_t>(t)];
}

template <int N>
FacetSigns<N> exact_facet_signs(const GridMap<N>& map, int t, const FixedPoint<N>& p) {
  FacetSigns<N> signs{};
  for (int facet = 0; facet <= N; ++facet)
    signs[static_cast<std::size_t>(facet)] = exact_facet_sign(map, t, facet, p);
  return signs;
}

// True when p + Q(e) is inside simplex t, for a point p of the closed simplex with these facet signs.
template <int N>
bool perturbed_inside(const GridMap<N>& map, int t, const FixedPoint<N>& p, const FacetSigns<N>& signs,
                      Rotation<N> Q) {
  for (int facet = 0; facet <= N; ++facet) {
    if (signs[static_cast<std::size_t>(facet)] != 0) continue;
    const int side = outer_side<N>(facet_points(map, (N + 1) * t + facet), p, Q);
    if (side * map.orientation[static_cast<std::size_t>(t)] >= 0) return false;
  }
  return true;
}

template <int N>
class SimplexPlanes {
 public:
  SimplexPlanes(const GridMap<N>& map, int t)
      : map_(&map), t_(t), origin_(map.P[static_cast<std::size_t>(t)][0]) {
    double extent = static_cast<double>(map.one());
    for (const FixedPoint<N>& corner : map.P[static_cast<std::size_t>(t)]) {
      for (const double x : local(corner)) extent = std::max(extent, std::abs(x));
    }
    // For points within 2M of the origin (M the extent, u = 2^-53) all differences are exact.
    // N = 3: an entry of the normal is below 8 M^2 with error 16 u M^2; the value is below 72 M^3 with error
    //        (144 + 72 + 144) u M^3 < 2^-44 M^3.
    // N = 2: the normal is exact and below 2 M; the value has error (12 + 12) u M^2 < 2^-48 M^2.
    error_ = N == 3 ? std::ldexp(extent * extent * extent, -43) : std::ldexp(extent * extent, -47);
    for (int facet = 0; facet <= N; ++facet) set_plane(facet);
  }

  double error() const { return error_; }
  const RealPoint<N>& normal(std::size_t facet) const { return normals_[facet]; }

  // Proportional to the distance inside of a facet's plane, with absolute error at most error().
  double value(std::size_t facet, const FixedPoint<N>& p) const {
    const RealPoint<N> x = difference(local(p), bases_[facet]);
    double sum = 0.0;
    for (std::size_t k = 0; k < N; ++k) sum += normals_[facet][k] * x[k];
    return sum;
  }

  int sign(std::size_t facet, const FixedPoint<N>& p) const {
    const double v = value(facet, p);
    if (std::abs(v) > error_) return v > 0 ? 1 : -1;
    return exact_facet_sign(*map_, t_, static_cast<int>(facet), p);
  }

  // Stops at the first facet that p is outside of.
  FacetSigns<N> signs(const FixedPoint<N>& p) const {
    FacetSigns<N> all;
    all.fill(-1);
    for (std::size_t facet = 0; facet <= N; ++facet) {
      all[facet] = sign(facet, p);
      if (all[facet] < 0) break;
    }
    return all;
  }

 private:
  RealPoint<N> local(const FixedPoint<N>& p) const {
    RealPoint<N> x{};
    for (std::size_t k = 0; k < N; ++k) x[k] = static_cast<double>(p[k] - origin_[k]);
    return x;
  }

  void set_plane(int facet) {
    const auto place = static_cast<std::size_t>(facet);
    const std::array<FixedPoint<N>, N> points = facet_points(*map_, (N + 1) * t_ + facet);
    const double inward = -map_->orientation[static_cast<std::size_t>(t_)];
    bases_[place] = local(points[0]);
    if constexpr (N == 3) {
      const RealPoint<3> b = difference(local(points[1]), bases_[place]);
      const RealPoint<3> c = difference(local(points[2]), bases_[place]);
      normals_[place] = {inward * (b[1] * c[2] - b[2] * c[1]), inward * (b[2] * c[0] - b[0] * c[2]),
                         inward * (b[0] * c[1] - b[1] * c[0])};
    } else {
      const std::array<Fixed, 2> normal = outward_normal(points);
      normals_[place] = {inward * static_cast<double>(normal[0]), inward * static_cast<double>(normal[1])};
    }
  }

  const GridMap<N>* map_;
  int t_;
  FixedPoint<N> origin_;
  double error_ = 0.0;
  std::array<RealPoint<N>, N + 1> bases_;
  std::array<RealPoint<N>, N + 1> normals_;
};

}  // namespace neurframe
