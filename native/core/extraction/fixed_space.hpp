// The points of one chart that a set of grid symmetries and integer planes leaves in place, and the exact
// projection onto them: where a vertex of an integer-grid map may lie.
//
// Every condition is of the form u_i = +-u_k + c or u_i = c, so a signed union-find over the three
// coordinates solves it without division (other than by two) and without rounding.
#pragma once

#include <array>
#include <optional>

#include "core/extraction/grid_map.hpp"

namespace neurframe {

template <int N>
class FixedSpace {
 public:
  explicit FixedSpace(Fixed one) : one_(one) {
    for (std::size_t i = 0; i < N; ++i) terms_[i].root = i;
  }

  // Requires h(u) = u.  False when no point satisfies this and what was required before.
  bool require_fixed_by(const GridTransition<N>& h) {
    bool consistent = true;
    for (std::size_t k = 0; k < N; ++k) {
      FixedPoint<N> axis{};
      axis[k] = 1;
      const FixedPoint<N> image = h.rotation(axis);  // coordinate k goes to the one entry that is not zero
      std::size_t i = 0;
      while (image[i] == 0) ++i;
      consistent = relate(i, k, static_cast<int>(image[i]), h.translation[i] * one_) && consistent;
    }
    return consistent;
  }

  // Requires u[axis] = value.
  bool require_value(std::size_t axis, Fixed value) {
    const Term& term = terms_[axis];
    return pin(term.root, term.sign * (value - term.offset));
  }

  // The nearest point, except that coordinates which are bound to each other follow the first of them.
  FixedPoint<N> project(const FixedPoint<N>& u) const {
    FixedPoint<N> projected{};
    for (std::size_t i = 0; i < N; ++i) {
      const Term& term = terms_[i];
      const Term& first = terms_[term.root];
      const Fixed root =
          values_[term.root] ? *values_[term.root] : first.sign * (u[term.root] - first.offset);
      projected[i] = term.sign * root + term.offset;
    }
    return projected;
  }

 private:
  struct Term {  // u_i = sign x_root + offset
    std::size_t root = 0;
    int sign = 1;
    Fixed offset = 0;
  };

  // Requires u_i = sign u_k + constant.
  bool relate(std::size_t i, std::size_t k, int sign, Fixed constant) {
    const Term a = terms_[i];
    const Term b = terms_[k];
    // x_a = relative x_b + shift
    const int relative = a.sign * sign * b.sign;
    const Fixed shift = a.sign * (sign * b.offset + constant - a.offset);
    if (a.root == b.root) {
      if (relative == 1) return shift == 0;
      return shift % 2 == 0 && pin(a.root, shift / 2);
    }
    return a.root > b.root ? merge(a.root, b.root, relative, shift)
                           : merge(b.root, a.root, relative, -relative * shift);
  }

  bool merge(std::size_t from, std::size_t into, int sign, Fixed shift) {
    for (Term& term : terms_) {
      if (term.root == from) term = {into, term.sign * sign, term.sign * shift + term.offset};
    }
    return !values_[from] || pin(into, sign * (*values_[from] - shift));
  }

  bool pin(std::size_t root, Fixed value) {
    if (values_[root]) return *values_[root] == value;
    values_[root] = value;
    return true;
  }

  Fixed one_;
  std::array<Term, N> terms_;
  std::array<std::optional<Fixed>, N> values_;
};

}  // namespace neurframe
