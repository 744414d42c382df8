// Exact elimination of homogeneous linear constraints over real and integer unknowns by signed substitution
// (Bommes et al. 2009, section 4; Brueckler et al. 2022).  What is left are free unknowns; every other
// unknown is an exact rational combination of them, so that seams stay closed whatever values the free ones
// take.
#pragma once

#include <optional>
#include <vector>

#include "cubecover/rational.hpp"

namespace neurframe {

struct Term {
  int unknown;
  Rational coefficient;
};

// Sum of terms, sorted by unknown, without zero coefficients.
using Combination = std::vector<Term>;

// first + factor * second
Combination add_scaled(const Combination& first, const Rational& factor, const Combination& second);

class Elimination {
 public:
  int add_real() { return add(false); }
  int add_integer() { return add(true); }
  int size() const { return static_cast<int>(integer_.size()); }
  bool is_integer(int unknown) const { return integer_[static_cast<std::size_t>(unknown)]; }

  // Constrains the combination to be zero.
  void require_zero(const Combination& combination);

  // The combination in free unknowns only.
  Combination resolve(const Combination& combination);
  Combination resolve(int unknown);
  bool is_free(int unknown) const { return !substitution_[static_cast<std::size_t>(unknown)].has_value(); }

  // How often an equation between integers had no coefficient +-1 and needed a change of lattice basis.
  int basis_changes() const { return basis_changes_; }

 private:
  int add(bool integer);
  void substitute(const Combination& equation, std::size_t pivot);
  void eliminate_integer(Combination equation);

  std::vector<bool> integer_;
  std::vector<std::optional<Combination>> substitution_;
  int basis_changes_ = 0;
};

}  // namespace neurframe
