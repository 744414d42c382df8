#include "miq/signed_relations.hpp"

#include <cstddef>
#include <utility>

namespace neurframe {

SignedRelations::SignedRelations(int variable_count, IntegerEquations& integers)
    : integers_(integers),
      parent_(static_cast<size_t>(variable_count)),
      size_(static_cast<size_t>(variable_count), 1) {
  for (int i = 0; i < variable_count; ++i) parent_[static_cast<size_t>(i)].root = i;
}

SignedAffine SignedRelations::find(int i) {
  SignedAffine& own = parent_[static_cast<size_t>(i)];
  if (own.sign == 0 || own.root == i) return own;
  const SignedAffine above = find(own.root);
  own.offset = sum(own.offset, above.offset, own.sign);
  own.sign *= above.sign;
  own.root = above.root;
  return own;
}

bool SignedRelations::fix(int i, const IntegerCombination& value) {
  const SignedAffine x = find(i);
  if (x.sign == 0) return integers_.impose(sum(x.offset, value, -1));
  SignedAffine& root = parent_[static_cast<size_t>(x.root)];
  root.offset = scaled(sum(value, x.offset, -1), x.sign);
  root.sign = 0;
  return true;
}

bool SignedRelations::make_integer(int i) {
  return find(i).sign == 0 || fix(i, symbol(integers_.add_symbol()));
}

bool SignedRelations::relate(int i, int j, int sign, const IntegerCombination& offset) {
  const SignedAffine left = find(i);
  const SignedAffine right = find(j);
  if (left.sign == 0) return fix(j, scaled(sum(left.offset, offset, -1), sign));
  if (right.sign == 0) return fix(i, sum(offset, right.offset, sign));
  // left.sign X + left.offset = sign (right.sign Y + right.offset) + offset
  const IntegerCombination difference = sum(sum(offset, right.offset, sign), left.offset, -1);
  if (left.root != right.root) return attach(left, right, sign, difference);
  if (left.sign == sign * right.sign) return integers_.impose(difference);
  // 2 left.sign X = difference: X itself is taken for an integer, never for a half
  const IntegerCombination value = symbol(integers_.add_symbol());
  parent_[static_cast<size_t>(left.root)].sign = 0;
  parent_[static_cast<size_t>(left.root)].offset = value;
  return integers_.impose(sum(difference, value, -2 * left.sign));
}

bool SignedRelations::attach(const SignedAffine& left, const SignedAffine& right, int sign,
                             const IntegerCombination& difference) {
  const int product = left.sign * sign * right.sign;
  auto child = static_cast<size_t>(left.root);
  auto parent = static_cast<size_t>(right.root);
  // X = product Y + left.sign difference, or the other way round: Y = product (X - left.sign difference)
  IntegerCombination shift = scaled(difference, left.sign);
  if (size_[child] > size_[parent]) {
    std::swap(child, parent);
    shift = scaled(shift, -product);
  }
  parent_[child] = {static_cast<int>(parent), product, std::move(shift)};
  size_[parent] += size_[child];
  return true;
}

}  // namespace neurframe
