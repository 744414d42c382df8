// Real variables tied to one another by x_i = +-x_j + integers: union-find with sign and exact integer
// offset.
#pragma once

#include <cstddef>
#include <vector>

#include "miq/integer_combination.hpp"

namespace neurframe {

// x = sign * x[root] + offset; sign 0 where the variable is an integer combination alone
struct SignedAffine {
  int root = 0;
  int sign = 1;
  IntegerCombination offset;
};

// Every relation is a signed permutation plus integers, so the substitution is exact and there is no fill-in
// and no elimination of floats.  Cycles of relations leave equations between integers, which are solved
// exactly.
class SignedRelations {
 public:
  SignedRelations(int variable_count, IntegerEquations& integers);

  // Imposes x_i = sign * x_j + offset.  False if the integers contradict it.
  bool relate(int i, int j, int sign, const IntegerCombination& offset);

  // makes x_i an integer: its class becomes integers alone, with a fresh symbol if it was not so already
  bool make_integer(int i);

  // imposes x_i = value
  bool fix(int i, const IntegerCombination& value);

  // current expression of x_i; offsets are not yet resolved by the integer equations
  SignedAffine find(int i);

 private:
  bool attach(const SignedAffine& child, const SignedAffine& parent, int sign,
              const IntegerCombination& offset);

  IntegerEquations& integers_;
  std::vector<SignedAffine> parent_;
  std::vector<int> size_;
};

}  // namespace neurframe
