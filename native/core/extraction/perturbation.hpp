// Symbolic perturbation of a point: x + e with e = Q (e1, e2, ...), e1 >> e2 >> ... > 0 infinitesimal, and
// the exact signs that it decides (Edelsbrunner & Muecke 1990, simulation of simplicity, for translations
// only).
//
// Q is one of the rotations of the grid.  It turns with the chart, so that a point and its perturbation mean
// the same in every chart they are carried to; all signs below are linear in e, so the first non-zero term
// decides exactly.
#pragma once

#include <array>

#include "core/extraction/grid_map.hpp"

namespace neurframe {

// The sign of gradient . e, for e = Q (e1, e2, ...).
template <class Scalar, std::size_t N, class Turn>
int perturbed_sign(const std::array<Scalar, N>& gradient, Turn Q) {
  for (const Scalar slope : Q.inverse()(gradient)) {
    if (slope != 0) return slope > 0 ? 1 : -1;
  }
  return 0;
}

// Normal to a facet, outward in a positively oriented simplex.
inline std::array<Int128, 3> outward_normal(const std::array<FixedPoint<3>, 3>& x) {
  return cross_product(difference(x[1], x[0]), difference(x[2], x[0]));
}
inline std::array<Fixed, 2> outward_normal(const std::array<FixedPoint<2>, 2>& x) {
  return {x[1][1] - x[0][1], x[0][0] - x[1][0]};
}

// The side of a facet's plane (line) on which p lies: 1 where the outward normal points to, -1 behind, 0 on
// it.
inline int outer_side(const std::array<FixedPoint<3>, 3>& x, const FixedPoint<3>& p) {
  return sign_of(orient3d(x[0], x[1], x[2], p));
}
inline int outer_side(const std::array<FixedPoint<2>, 2>& x, const FixedPoint<2>& p) {
  return -sign_of(orient2d(x[0], x[1], p));
}

// The same for p + e; 0 only when the facet spans no plane (line).
template <int N>
int outer_side(const std::array<FixedPoint<N>, N>& x, const FixedPoint<N>& p, Rotation<N> Q) {
  const int side = outer_side(x, p);
  return side != 0 ? side : perturbed_sign(outward_normal(x), Q);
}

// A line of direction s = (+-1, ...) through p + e, seen along s: what is left of it after projection.
template <int N>
class DiagonalView;

template <>
class DiagonalView<3> {
 public:
  struct Projected {
    Fixed a;
    Fixed b;
  };

  DiagonalView(const FixedPoint<3>& p, const std::array<int, 3>& s, OctahedralRotation Q)
      : p_(p), s_(s), parity_(s[0] * s[1] * s[2]), Q_(Q) {}

  Projected operator()(const FixedPoint<3>& x) const {
    const Fixed along = s_[2] * (x[2] - p_[2]);
    return {s_[0] * (x[0] - p_[0]) - along, s_[1] * (x[1] - p_[1]) - along};
  }

  // The sign of det(s, x - p - e, y - p - e): 1 where x -> y turns counter-clockwise round the line, seen
  // against its direction.  0 only when x -> y is parallel to s.
  int turn(const Projected& x, const Projected& y) const {
    const int sign = sign_of(Int128{x.a} * y.b - Int128{x.b} * y.a);
    if (sign != 0) return parity_ * sign;
    const Fixed by_first = x.b - y.b;
    const Fixed by_second = y.a - x.a;
    const std::array<Fixed, 3> gradient{s_[0] * by_first, s_[1] * by_second, -s_[2] * (by_first + by_second)};
    return parity_ * perturbed_sign(gradient, Q_);
  }

 private:
  FixedPoint<3> p_;
  std::array<int, 3> s_;
  int parity_;
  OctahedralRotation Q_;
};

template <>
class DiagonalView<2> {
 public:
  DiagonalView(const FixedPoint<2>& p, const std::array<int, 2>& s, QuarterTurn Q) : p_(p), s_(s), Q_(Q) {}

  // The sign of det(s, x - p - e): 1 to the left of the line, -1 to the right; never 0.
  int operator()(const FixedPoint<2>& x) const {
    const Fixed left = s_[0] * (x[1] - p_[1]) - s_[1] * (x[0] - p_[0]);
    if (left != 0) return left > 0 ? 1 : -1;
    return perturbed_sign(std::array<int, 2>{s_[1], -s_[0]}, Q_);
  }

 private:
  FixedPoint<2> p_;
  std::array<int, 2> s_;
  QuarterTurn Q_;
};

}  // namespace neurframe
