#include "miq/integer_combination.hpp"

#include <algorithm>
#include <cstdlib>
#include <numeric>

namespace neurframe {

IntegerCombination symbol(int index) {
  return {{{index, 1}}, 0};
}

IntegerCombination sum(const IntegerCombination& a, const IntegerCombination& b, int64_t factor) {
  IntegerCombination out;
  out.constant = a.constant + factor * b.constant;
  out.terms.reserve(a.terms.size() + b.terms.size());
  auto left = a.terms.begin();
  auto right = b.terms.begin();
  while (left != a.terms.end() || right != b.terms.end()) {
    const bool take_left = right == b.terms.end() || (left != a.terms.end() && left->first <= right->first);
    const bool take_right = left == a.terms.end() || (right != b.terms.end() && right->first <= left->first);
    const int index = take_left ? left->first : right->first;
    int64_t coefficient = 0;
    if (take_left) coefficient += (left++)->second;
    if (take_right) coefficient += factor * (right++)->second;
    if (coefficient != 0) out.terms.emplace_back(index, coefficient);
  }
  return out;
}

IntegerCombination scaled(const IntegerCombination& a, int64_t factor) {
  return sum(IntegerCombination{}, a, factor);
}

int IntegerEquations::add_symbol() {
  return symbol_count_++;
}

IntegerCombination IntegerEquations::resolve(const IntegerCombination& a) const {
  IntegerCombination out{{}, a.constant};
  for (const auto& [index, coefficient] : a.terms) {
    const auto bound = value_.find(index);
    out = sum(out, bound == value_.end() ? symbol(index) : bound->second, coefficient);
  }
  return out;
}

void IntegerEquations::eliminate(int pivot, const IntegerCombination& value) {
  for (const int user : users_of_free_[pivot]) {
    IntegerCombination& expression = value_[user];
    const auto term = std::find_if(expression.terms.begin(), expression.terms.end(),
                                   [&](const auto& entry) { return entry.first == pivot; });
    if (term == expression.terms.end()) continue;
    const int64_t coefficient = term->second;
    expression.terms.erase(term);
    expression = sum(expression, value, coefficient);
    for (const auto& entry : value.terms) users_of_free_[entry.first].push_back(user);
  }
  users_of_free_.erase(pivot);
  value_[pivot] = value;
  for (const auto& entry : value.terms) users_of_free_[entry.first].push_back(pivot);
}

bool IntegerEquations::impose(const IntegerCombination& unresolved) {
  IntegerCombination row = resolve(unresolved);
  if (row.terms.empty()) return row.constant == 0;
  int64_t divisor = 0;
  for (const auto& entry : row.terms) divisor = std::gcd(divisor, entry.second);
  if (row.constant % divisor != 0) return false;
  for (auto& entry : row.terms) entry.second /= divisor;
  row.constant /= divisor;
  const auto unit =
      std::find_if(row.terms.begin(), row.terms.end(), [](const auto& e) { return std::abs(e.second) == 1; });
  if (unit == row.terms.end()) return impose_by_euclid(std::move(row));
  const auto [pivot, coefficient] = *unit;
  eliminate(pivot, sum(symbol(pivot), row, -coefficient));
  return true;
}

// c a + sum of d_j k_j = 0 with |c| the least: a = a' - sum of (d_j div c) k_j leaves c a' + sum of (d_j mod
// c) k_j
bool IntegerEquations::impose_by_euclid(IntegerCombination row) {
  const auto least = std::min_element(row.terms.begin(), row.terms.end(), [](const auto& a, const auto& b) {
    return std::abs(a.second) < std::abs(b.second);
  });
  const auto [pivot, coefficient] = *least;
  IntegerCombination value = symbol(add_symbol());
  for (const auto& [index, other] : row.terms) {
    if (index != pivot) value = sum(value, symbol(index), -(other / coefficient));
  }
  eliminate(pivot, value);
  return impose(row);
}

}  // namespace neurframe
