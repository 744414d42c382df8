// The symmetries of the integer grid in the plane that keep orientation: quarter turns and their
// combination with integer translations, the transition functions between charts of a quad map.
#pragma once

#include <array>
#include <cstdint>

namespace neurframe {

template <class Scalar>
using Vector2 = std::array<Scalar, 2>;

// A rotation by `turns` times 90 degrees counter-clockwise, turns in Z/4.
class QuarterTurn {
 public:
  constexpr QuarterTurn() = default;
  constexpr explicit QuarterTurn(int turns) : turns_(static_cast<std::uint8_t>(((turns % 4) + 4) % 4)) {}

  constexpr int turns() const { return turns_; }
  constexpr QuarterTurn inverse() const { return QuarterTurn(-turns_); }
  constexpr bool operator==(const QuarterTurn&) const = default;

  template <class Scalar>
  constexpr Vector2<Scalar> operator()(const Vector2<Scalar>& x) const {
    switch (turns_) {
      case 0:
        return x;
      case 1:
        return {-x[1], x[0]};
      case 2:
        return {-x[0], -x[1]};
      default:
        return {x[1], -x[0]};
    }
  }

 private:
  std::uint8_t turns_ = 0;
};

// (a * b)(x) = a(b(x))
constexpr QuarterTurn operator*(QuarterTurn a, QuarterTurn b) {
  return QuarterTurn(a.turns() + b.turns());
}

// x -> R x + t with integer t: an automorphism of the grid Z^2.
struct GridTransition2 {
  QuarterTurn rotation;
  Vector2<std::int64_t> translation{0, 0};  // in cells

  constexpr bool operator==(const GridTransition2&) const = default;

  // `one` is the length of a cell in the unit of x: 1.0 for real parameters, 2^F for fixed-point ones.
  template <class Scalar>
  constexpr Vector2<Scalar> operator()(const Vector2<Scalar>& x, Scalar one) const {
    const Vector2<Scalar> turned = rotation(x);
    return {turned[0] + static_cast<Scalar>(translation[0]) * one,
            turned[1] + static_cast<Scalar>(translation[1]) * one};
  }

  constexpr GridTransition2 inverse() const {
    const QuarterTurn back = rotation.inverse();
    const Vector2<std::int64_t> moved = back(translation);
    return {back, {-moved[0], -moved[1]}};
  }
};

// (a * b)(x) = a(b(x))
constexpr GridTransition2 operator*(const GridTransition2& a, const GridTransition2& b) {
  return {a.rotation * b.rotation, a(b.translation, std::int64_t{1})};
}

}  // namespace neurframe
