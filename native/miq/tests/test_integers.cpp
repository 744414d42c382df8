// Exact integer equations and signed relations between variables.
#include "core/testing.hpp"
#include "miq/fixed_point_map.hpp"
#include "miq/integer_combination.hpp"
#include "miq/signed_relations.hpp"

namespace neurframe {
namespace {

IntegerCombination terms(std::vector<std::pair<int, int64_t>> list, int64_t constant = 0) {
  return {std::move(list), constant};
}

void test_combination_arithmetic() {
  const IntegerCombination a = terms({{0, 2}, {3, -1}}, 5);
  const IntegerCombination b = terms({{0, 1}, {2, 4}}, -1);
  CHECK(sum(a, b, -2).terms == (std::vector<std::pair<int, int64_t>>{{2, -8}, {3, -1}}));
  CHECK(sum(a, b, -2).constant == 7);
  CHECK(sum(a, a, -1).is_zero());
}

void test_unit_pivots() {
  IntegerEquations equations;
  for (int i = 0; i < 3; ++i) equations.add_symbol();
  CHECK(equations.impose(terms({{0, 1}, {1, -2}}, -3)));  // x = 2 y + 3
  CHECK(equations.impose(terms({{1, 1}, {2, 1}})));       // y = -z
  const IntegerCombination x = equations.resolve(symbol(0));
  const IntegerCombination y = equations.resolve(symbol(1));
  CHECK(sum(sum(x, y, -2), terms({}, 3), -1).is_zero());
}

// 6 a = 10 b has the solutions a = 5 k, b = 3 k; the equation has no unit coefficient
void test_euclid() {
  IntegerEquations equations;
  const int a = equations.add_symbol();
  const int b = equations.add_symbol();
  CHECK(equations.impose(terms({{a, 6}, {b, -10}})));
  const IntegerCombination va = equations.resolve(symbol(a));
  const IntegerCombination vb = equations.resolve(symbol(b));
  CHECK(va.terms.size() == 1 && vb.terms.size() == 1 && va.terms[0].first == vb.terms[0].first);
  CHECK(va.terms[0].second * 3 == vb.terms[0].second * 5 && std::abs(va.terms[0].second) == 5);
}

void test_contradictions() {
  IntegerEquations equations;
  const int a = equations.add_symbol();
  const int b = equations.add_symbol();
  CHECK(!equations.impose(terms({{a, 2}, {b, 4}}, 1)));  // parity
  CHECK(equations.impose(terms({{a, 1}}, -3)));
  CHECK(!equations.impose(terms({{a, 1}}, -4)));
}

void test_relations_carry_sign_and_offset() {
  IntegerEquations equations;
  const int t = equations.add_symbol();
  SignedRelations relations(4, equations);
  CHECK(relations.relate(0, 1, -1, symbol(t)));    // x0 = -x1 + t
  CHECK(relations.relate(2, 1, 1, terms({}, 2)));  // x2 = x1 + 2
  const SignedAffine x0 = relations.find(0);
  const SignedAffine x2 = relations.find(2);
  CHECK(x0.root == x2.root && x0.sign == -x2.sign);
  CHECK(sum(sum(x0.offset, x2.offset), terms({{t, 1}}, 2), -1).is_zero());  // x0 + x2 = t + 2
  CHECK(relations.find(3).root == 3);
}

// a rotation centre: u = -u + t makes u an integer and t even, as a singular vertex must be
void test_opposite_signs_make_integers() {
  IntegerEquations equations;
  const int t = equations.add_symbol();
  SignedRelations relations(1, equations);
  CHECK(relations.relate(0, 0, -1, symbol(t)));
  const SignedAffine u = relations.find(0);
  CHECK(u.sign == 0);
  CHECK(equations.resolve(sum(scaled(u.offset, 2), symbol(t), -1)).is_zero());
}

void test_fixed_variables_bind_integers() {
  IntegerEquations equations;
  const int t = equations.add_symbol();
  SignedRelations relations(2, equations);
  CHECK(relations.fix(0, terms({}, 7)));
  CHECK(relations.relate(1, 0, 1, symbol(t)));
  CHECK(relations.fix(1, terms({}, 9)));
  CHECK(equations.resolve(symbol(t)).constant == 2 && equations.resolve(symbol(t)).terms.empty());
  CHECK(!relations.fix(1, terms({}, 10)));
}

// Terms that would overflow one by one, though their sum is small, and what is no number.
void test_variables_beyond_the_lattice() {
  ReducedVariables variables;
  variables.sector = {0};
  variables.coordinates = {{0, 1, {{0, -1}}}, {0, 1, {}}};
  const auto map_of = [&](double real, double integer) {
    return fixed_point_map(variables, Eigen::VectorXd::Constant(1, real),
                           Eigen::VectorXd::Constant(1, integer));
  };
  CHECK(map_of(3.5, 2).corners[0][0] == Fixed{3} << (map_of(3.5, 2).fraction_bits - 1));
  for (const double x : {1e19, -1e300, static_cast<double>(NAN)}) {
    CHECK_THROWS(map_of(x, x), StageError, "too many cells");
    CHECK_THROWS(map_of(x, 0), StageError, "too many cells");
  }
}

}  // namespace
}  // namespace neurframe

int main() {
  neurframe::test_combination_arithmetic();
  neurframe::test_unit_pivots();
  neurframe::test_euclid();
  neurframe::test_contradictions();
  neurframe::test_relations_carry_sign_and_offset();
  neurframe::test_opposite_signs_make_integers();
  neurframe::test_fixed_variables_bind_integers();
  neurframe::test_variables_beyond_the_lattice();
  return neurframe::test_result();
}
