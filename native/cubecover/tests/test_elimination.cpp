// Fractions and the exact elimination over reals and integers.
#include "core/testing.hpp"
#include "cubecover/elimination.hpp"

namespace neurframe {
namespace {

Combination combination(std::initializer_list<Term> terms) {
  Combination sum;
  for (const Term& term : terms) sum = add_scaled(sum, term.coefficient, {{term.unknown, Rational(1)}});
  return sum;
}

bool equal(const Combination& a, const Combination& b) {
  return add_scaled(a, Rational(-1), b).empty();
}

void test_fractions() {
  CHECK(Rational(2, -4) == Rational(-1, 2));
  CHECK(Rational(1, 2) + Rational(1, 3) == Rational(5, 6));
  CHECK(Rational(2, 3) * Rational(-9, 4) == Rational(-3, 2));
  CHECK((Rational(1, 2) + Rational(-1, 2)).is_zero());
  CHECK_THROWS(Rational(INT64_MAX) + Rational(1), std::overflow_error, "64 bits");
}

// u1 = -u0 + j, u2 = u1, u0 = u2 leaves u0 = j / 2: the line of a half turn lies on half-integers.
void test_half_turn() {
  Elimination system;
  const int u0 = system.add_real(), u1 = system.add_real(), u2 = system.add_real(), j = system.add_integer();
  system.require_zero(combination({{u1, 1}, {u0, 1}, {j, -1}}));
  system.require_zero(combination({{u2, 1}, {u1, -1}}));
  system.require_zero(combination({{u0, 1}, {u2, -1}}));
  CHECK(equal(system.resolve(u0), combination({{j, Rational(1, 2)}})));
  // on an integer line j becomes even, without a fraction anywhere
  const int n = system.add_integer();
  system.require_zero(combination({{u0, 1}, {n, -1}}));
  CHECK(equal(system.resolve(j), add_scaled({}, Rational(2), system.resolve(n))));
}

// 6 a + 10 b + 15 c = 0 has no coefficient 1: two free integers remain and reach every solution.
void test_lattice_basis() {
  Elimination system;
  const int a = system.add_integer(), b = system.add_integer(), c = system.add_integer();
  system.require_zero(combination({{a, 6}, {b, 10}, {c, 15}}));
  CHECK(system.basis_changes() > 0);
  Combination sum;
  int free_integers = 0;
  for (int unknown = 0; unknown < system.size(); ++unknown) free_integers += system.is_free(unknown) ? 1 : 0;
  CHECK(free_integers == 2);
  for (const auto& [unknown, factor] : {std::pair{a, 6}, std::pair{b, 10}, std::pair{c, 15}}) {
    for (const Term& term : system.resolve(unknown)) CHECK(term.coefficient.denominator == 1);
    sum = add_scaled(sum, Rational(factor), system.resolve(unknown));
  }
  CHECK(sum.empty());
}

void test_contradiction_makes_zero() {
  Elimination system;
  const int x = system.add_real(), n = system.add_integer();
  system.require_zero(combination({{x, 1}, {n, -1}}));
  system.require_zero(combination({{x, 1}, {n, 1}}));
  CHECK(system.resolve(x).empty());
  CHECK(system.resolve(n).empty());
}

}  // namespace
}  // namespace neurframe

int main() {
  neurframe::test_fractions();
  neurframe::test_half_turn();
  neurframe::test_lattice_basis();
  neurframe::test_contradiction_makes_zero();
  return neurframe::test_result();
}
