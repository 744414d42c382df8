#include "cubecover/elimination.hpp"

#include <algorithm>
#include <cstdlib>

namespace neurframe {

Combination add_scaled(const Combination& first, const Rational& factor, const Combination& second) {
  Combination sum;
  sum.reserve(first.size() + second.size());
  auto a = first.begin();
  auto b = second.begin();
  while (a != first.end() || b != second.end()) {
    if (b == second.end() || (a != first.end() && a->unknown < b->unknown)) {
      sum.push_back(*a++);
    } else if (a == first.end() || b->unknown < a->unknown) {
      sum.push_back({b->unknown, factor * b->coefficient});
      ++b;
    } else {
      const Rational coefficient = a->coefficient + factor * b->coefficient;
      if (!coefficient.is_zero()) sum.push_back({a->unknown, coefficient});
      ++a;
      ++b;
    }
  }
  return sum;
}

int Elimination::add(bool integer) {
  integer_.push_back(integer);
  substitution_.emplace_back();
  return size() - 1;
}

Combination Elimination::resolve(int unknown) {
  auto& stored = substitution_[static_cast<std::size_t>(unknown)];
  if (!stored) return {{unknown, Rational(1)}};
  const bool flat =
      std::all_of(stored->begin(), stored->end(), [&](const Term& t) { return is_free(t.unknown); });
  if (!flat) *stored = resolve(Combination(*stored));
  return *stored;
}

Combination Elimination::resolve(const Combination& combination) {
  Combination resolved;
  for (const Term& term : combination) {
    resolved = add_scaled(resolved, term.coefficient, resolve(term.unknown));
  }
  return resolved;
}

// equation = 0 solved for the unknown of its pivot term
void Elimination::substitute(const Combination& equation, std::size_t pivot) {
  const Term chosen = equation[pivot];
  Combination rest = equation;
  rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(pivot));
  substitution_[static_cast<std::size_t>(chosen.unknown)] =
      add_scaled({}, -(Rational(1) / chosen.coefficient), rest);
}

void Elimination::require_zero(const Combination& combination) {
  const Combination equation = resolve(combination);
  if (equation.empty()) return;
  std::optional<std::size_t> real;
  for (std::size_t i = 0; i < equation.size(); ++i) {
    if (is_integer(equation[i].unknown)) continue;
    if (!real || (equation[i].coefficient.is_unit() && !equation[*real].coefficient.is_unit())) real = i;
  }
  if (real) {
    substitute(equation, *real);
  } else {
    eliminate_integer(equation);
  }
}

namespace {

// The same equation with coprime integer coefficients.
Combination primitive(const Combination& equation) {
  std::int64_t denominator = 1;
  for (const Term& term : equation) denominator = std::lcm(denominator, term.coefficient.denominator);
  std::int64_t divisor = 0;
  for (const Term& term : equation) {
    divisor = std::gcd(
        divisor, checked_product(term.coefficient.numerator, denominator / term.coefficient.denominator));
  }
  return add_scaled({}, Rational(denominator, divisor), equation);
}

std::size_t smallest_coefficient(const Combination& equation) {
  std::size_t smallest = 0;
  for (std::size_t i = 1; i < equation.size(); ++i) {
    if (std::abs(equation[i].coefficient.numerator) < std::abs(equation[smallest].coefficient.numerator))
      smallest = i;
  }
  return smallest;
}

}  // namespace

// Euclid's algorithm on the coefficients: while no coefficient is +-1, the unknown x with the smallest one,
// a, is replaced by x = z - sum round(b_i / a) y_i, which leaves a z + sum (b_i mod a) y_i = 0.
void Elimination::eliminate_integer(Combination equation) {
  equation = primitive(equation);
  while (true) {
    const std::size_t pivot = smallest_coefficient(equation);
    const Term smallest = equation[pivot];
    if (smallest.coefficient.is_unit()) return substitute(equation, pivot);
    ++basis_changes_;
    Combination replacement = {{add_integer(), Rational(1)}};
    for (std::size_t i = 0; i < equation.size(); ++i) {
      if (i == pivot) continue;
      const std::int64_t quotient = equation[i].coefficient.numerator / smallest.coefficient.numerator;
      replacement = add_scaled(replacement, Rational(-quotient), {{equation[i].unknown, Rational(1)}});
    }
    substitution_[static_cast<std::size_t>(smallest.unknown)] = replacement;
    equation = primitive(resolve(equation));
  }
}

}  // namespace neurframe
