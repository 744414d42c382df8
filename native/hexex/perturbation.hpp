// Symbolic perturbation of a point: x + e with e = Q (e1, e2, e3), e1 >> e2 >> e3 > 0 infinitesimal, and the
// exact signs that it decides (Edelsbrunner & Muecke 1990, simulation of simplicity, for translations only).
//
// Q is one of the 24 grid rotations.  It turns with the chart, so that a point and its perturbation mean the
// same in every chart they are carried to; all signs below are linear in e, so the first non-zero term
// decides exactly.
#pragma once

#include <array>

#include "hexex/grid_map.hpp"

namespace neurframe {

// The sign of gradient . e, for e = Q (e1, e2, e3).
template <class Scalar>
int perturbed_sign(const std::array<Scalar, 3>& gradient, OctahedralRotation Q) {
  const OctahedralRotation inverse = Q.inverse();
  for (int k = 0; k < 3; ++k) {
    const Scalar slope = gradient[static_cast<std::size_t>(inverse.axis(k))];
    if (slope != 0) return (slope > 0 ? 1 : -1) * inverse.sign(k);
  }
  return 0;
}

// The side of plane abc on which p lies: 1 where the normal (b-a)x(c-a) points to, -1 behind, 0 on it.
inline int plane_side(const FixedPoint3& a, const FixedPoint3& b, const FixedPoint3& c,
                      const FixedPoint3& p) {
  return sign_of(orient3d(a, b, c, p));
}

// The same for p + e; 0 only when a, b, c are collinear.
inline int plane_side(const FixedPoint3& a, const FixedPoint3& b, const FixedPoint3& c, const FixedPoint3& p,
                      OctahedralRotation Q) {
  const int side = plane_side(a, b, c, p);
  return side != 0 ? side : perturbed_sign(cross_product(difference(b, a), difference(c, a)), Q);
}

// Lines of direction s = (+-1, +-1, +-1) through p + e, seen along s: the plane after projection.
class DiagonalView {
 public:
  struct Projected {
    Fixed a;
    Fixed b;
  };

  DiagonalView(const FixedPoint3& p, const std::array<int, 3>& s, OctahedralRotation Q)
      : p_(p), s_(s), parity_(s[0] * s[1] * s[2]), Q_(Q) {}

  Projected operator()(const FixedPoint3& x) const {
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
  FixedPoint3 p_;
  std::array<int, 3> s_;
  int parity_;
  OctahedralRotation Q_;
};

}  // namespace neurframe
