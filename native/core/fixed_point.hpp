// Fixed-point parameters and exact orientation determinants.
//
// A parameter x (in cells) is stored as the integer round(x 2^F).  With |x| < 2^I and I + F <= 40:
//   differences            |a - b|        < 2^(I+F+1)          <= 2^41
//   2x2 determinants       |ad - bc|      < 2 * 2^(2*41)        = 2^83
//   3x3 determinants       sum of 6 terms < 6 * 2^(3*41)        < 2^126
// so every sum fits a signed 128-bit integer and its sign is exact.  Transition functions are signed
// permutations plus integer translations: they map the lattice 2^-F Z onto itself without rounding.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "core/octahedral_rotation.hpp"
#include "core/quarter_turn.hpp"

namespace neurframe {

__extension__ typedef __int128 Int128;
using Fixed = std::int64_t;

inline constexpr int fixed_total_bits = 40;             // I + F
inline constexpr int fixed_default_fraction_bits = 24;  // F: 6e-8 of a cell
inline constexpr int fixed_least_fraction_bits = 16;    // below this, refuse: the map spans too many cells

// The number F of fractional bits for a map whose largest |parameter| is `largest` cells: the default where
// it fits, fewer for large maps, 0 when even fixed_least_fraction_bits do not fit (or largest is not finite).
inline int fraction_bits_for(double largest) {
  for (int bits = fixed_default_fraction_bits; bits >= fixed_least_fraction_bits; --bits) {
    // one cell of slack, because a neighbouring lattice point is tested too
    if (largest + 1.0 < std::ldexp(1.0, fixed_total_bits - bits)) return bits;
  }
  return 0;
}

// Nearest lattice value; |x| must be below 2^(40 - fraction_bits).
inline Fixed to_fixed(double x, int fraction_bits) {
  return std::llround(std::ldexp(x, fraction_bits));
}
inline double from_fixed(Fixed x, int fraction_bits) {
  return std::ldexp(static_cast<double>(x), -fraction_bits);
}

template <class Scalar, std::size_t N>
constexpr std::array<Scalar, N> difference(const std::array<Scalar, N>& a, const std::array<Scalar, N>& b) {
  std::array<Scalar, N> c{};
  for (std::size_t i = 0; i < N; ++i) c[i] = a[i] - b[i];
  return c;
}

constexpr Int128 determinant(const Vector2<Fixed>& a, const Vector2<Fixed>& b) {
  return Int128{a[0]} * b[1] - Int128{a[1]} * b[0];
}

constexpr std::array<Int128, 3> cross_product(const Vector3<Fixed>& a, const Vector3<Fixed>& b) {
  return {Int128{a[1]} * b[2] - Int128{a[2]} * b[1], Int128{a[2]} * b[0] - Int128{a[0]} * b[2],
          Int128{a[0]} * b[1] - Int128{a[1]} * b[0]};
}

constexpr Int128 determinant(const Vector3<Fixed>& a, const Vector3<Fixed>& b, const Vector3<Fixed>& c) {
  const std::array<Int128, 3> n = cross_product(a, b);
  return n[0] * c[0] + n[1] * c[1] + n[2] * c[2];
}

constexpr int sign_of(Int128 x) {
  return (x > 0) - (x < 0);
}

// Twice the signed area of the triangle abc: positive when counter-clockwise.
constexpr Int128 orient2d(const Vector2<Fixed>& a, const Vector2<Fixed>& b, const Vector2<Fixed>& c) {
  return determinant(difference(b, a), difference(c, a));
}

// Six times the signed volume of the tet abcd: positive when (b-a, c-a, d-a) is right-handed.
constexpr Int128 orient3d(const Vector3<Fixed>& a, const Vector3<Fixed>& b, const Vector3<Fixed>& c,
                          const Vector3<Fixed>& d) {
  return determinant(difference(b, a), difference(c, a), difference(d, a));
}

}  // namespace neurframe
