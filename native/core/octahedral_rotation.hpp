// The symmetries of the integer grid in space that keep orientation: the 24 signed permutation matrices of
// determinant +1 (the octahedral group O), and their combination with integer translations, the transition
// functions between charts of a hex map (Nieser, Reitebuch, Polthier 2011, section 3).
#pragma once

#include <array>
#include <cstdint>

namespace neurframe {

template <class Scalar>
using Vector3 = std::array<Scalar, 3>;

enum class RotationKind {
  identity,
  quarter_turn,  // 90 degrees about a coordinate axis (6 of them): edges of valence 3, 5, ...
  half_turn,     // 180 degrees about a coordinate axis (3): edges of valence 2, 6, ...
  compound       // about a diagonal (8 third turns, 6 half turns): no edge of a hex mesh has one
};

namespace detail {

struct SignedPermutation {
  std::array<std::int8_t, 3> axis{0, 1, 2};  // (R x)[i] = sign[i] x[axis[i]]
  std::array<std::int8_t, 3> sign{1, 1, 1};
  constexpr bool operator==(const SignedPermutation&) const = default;
};

constexpr SignedPermutation product(const SignedPermutation& a, const SignedPermutation& b) {
  SignedPermutation c;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(a.axis[i]);
    c.axis[i] = b.axis[k];
    c.sign[i] = static_cast<std::int8_t>(a.sign[i] * b.sign[k]);
  }
  return c;
}

// All 24 rotations; the identity is number 0.
constexpr std::array<SignedPermutation, 24> all_signed_permutations() {
  constexpr std::int8_t axes[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
  std::array<SignedPermutation, 24> all{};
  std::size_t count = 0;
  for (int order = 0; order < 6; ++order) {
    const int parity = order < 3 ? 1 : -1;
    for (int bits = 0; bits < 8; ++bits) {
      const std::array<std::int8_t, 3> sign{static_cast<std::int8_t>((bits & 1) != 0 ? -1 : 1),
                                            static_cast<std::int8_t>((bits & 2) != 0 ? -1 : 1),
                                            static_cast<std::int8_t>((bits & 4) != 0 ? -1 : 1)};
      if (parity * sign[0] * sign[1] * sign[2] == 1) {
        all[count++] = {{axes[order][0], axes[order][1], axes[order][2]}, sign};
      }
    }
  }
  return all;
}

inline constexpr std::array<SignedPermutation, 24> rotations = all_signed_permutations();

constexpr std::uint8_t find_rotation(const SignedPermutation& wanted) {
  for (std::size_t i = 0; i < 24; ++i) {
    if (rotations[i] == wanted) return static_cast<std::uint8_t>(i);
  }
  return 255;  // not a rotation: cannot happen for a product of rotations
}

constexpr std::array<std::array<std::uint8_t, 24>, 24> multiplication_table() {
  std::array<std::array<std::uint8_t, 24>, 24> table{};
  for (std::size_t a = 0; a < 24; ++a) {
    for (std::size_t b = 0; b < 24; ++b) table[a][b] = find_rotation(product(rotations[a], rotations[b]));
  }
  return table;
}

inline constexpr auto products = multiplication_table();

constexpr std::array<std::uint8_t, 24> inverse_table() {
  std::array<std::uint8_t, 24> table{};
  for (std::size_t a = 0; a < 24; ++a) {
    for (std::size_t b = 0; b < 24; ++b) {
      if (products[a][b] == 0) table[a] = static_cast<std::uint8_t>(b);
    }
  }
  return table;
}

inline constexpr auto inverses = inverse_table();

}  // namespace detail

class OctahedralRotation {
 public:
  static constexpr int count = 24;

  constexpr OctahedralRotation() = default;
  // index in [0, 24); 0 is the identity
  constexpr explicit OctahedralRotation(int index) : index_(static_cast<std::uint8_t>(index)) {}

  constexpr int index() const { return index_; }
  constexpr bool is_identity() const { return index_ == 0; }
  constexpr bool operator==(const OctahedralRotation&) const = default;
  constexpr OctahedralRotation inverse() const { return OctahedralRotation(detail::inverses[index_]); }

  // (R x)[row] = sign(row) x[axis(row)]
  constexpr int axis(int row) const { return detail::rotations[index_].axis[static_cast<std::size_t>(row)]; }
  constexpr int sign(int row) const { return detail::rotations[index_].sign[static_cast<std::size_t>(row)]; }
  constexpr int trace() const {
    int sum = 0;
    for (int row = 0; row < 3; ++row) sum += axis(row) == row ? sign(row) : 0;
    return sum;
  }

  template <class Scalar>
  constexpr Vector3<Scalar> operator()(const Vector3<Scalar>& x) const {
    const detail::SignedPermutation& m = detail::rotations[index_];
    const auto entry = [&](std::size_t row) {
      const Scalar value = x[static_cast<std::size_t>(m.axis[row])];
      return m.sign[row] > 0 ? value : -value;
    };
    return {entry(0), entry(1), entry(2)};
  }

  constexpr RotationKind kind() const {
    if (index_ == 0) return RotationKind::identity;
    if (fixed_axis() < 0) return RotationKind::compound;
    return trace() == 1 ? RotationKind::quarter_turn : RotationKind::half_turn;
  }

  // The coordinate axis about which this quarter or half turn rotates; -1 for identity and compound ones.
  constexpr int fixed_axis() const {
    for (int row = 0; row < 3; ++row) {
      if (index_ != 0 && axis(row) == row && sign(row) == 1) return row;
    }
    return -1;
  }

  // +1 for a counter-clockwise quarter turn about +fixed_axis(), -1 for a clockwise one, 0 for all others.
  constexpr int quarter_turn_sign() const {
    if (kind() != RotationKind::quarter_turn) return 0;
    return sign((fixed_axis() + 2) % 3);  // counter-clockwise: e1 -> e2, so row 2 reads +x1
  }

 private:
  std::uint8_t index_ = 0;
};

// (a * b)(x) = a(b(x))
constexpr OctahedralRotation operator*(OctahedralRotation a, OctahedralRotation b) {
  return OctahedralRotation(
      detail::products[static_cast<std::size_t>(a.index())][static_cast<std::size_t>(b.index())]);
}

// x -> R x + t with integer t: an automorphism of the grid Z^3.
struct GridTransition3 {
  OctahedralRotation rotation;
  Vector3<std::int64_t> translation{0, 0, 0};  // in cells

  constexpr bool operator==(const GridTransition3&) const = default;

  // `one` is the length of a cell in the unit of x: 1.0 for real parameters, 2^F for fixed-point ones.
  template <class Scalar>
  constexpr Vector3<Scalar> operator()(const Vector3<Scalar>& x, Scalar one) const {
    Vector3<Scalar> moved = rotation(x);
    for (std::size_t i = 0; i < 3; ++i) moved[i] += static_cast<Scalar>(translation[i]) * one;
    return moved;
  }

  constexpr GridTransition3 inverse() const {
    const OctahedralRotation back = rotation.inverse();
    const Vector3<std::int64_t> moved = back(translation);
    return {back, {-moved[0], -moved[1], -moved[2]}};
  }
};

// (a * b)(x) = a(b(x))
constexpr GridTransition3 operator*(const GridTransition3& a, const GridTransition3& b) {
  return {a.rotation * b.rotation, a(b.translation, std::int64_t{1})};
}

}  // namespace neurframe
