// The barrier energy against finite differences, and its Hessian against the sign that Newton needs.
#include <cmath>
#include <random>

#include "core/testing.hpp"
#include "cubecover/barrier_energy.hpp"
#include "cubecover/quantize.hpp"

namespace neurframe {
namespace {

Eigen::Matrix3d random_matrix(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  return Eigen::Matrix3d::NullaryExpr([&] { return normal(random); });
}

void test_gradient_is_the_derivative() {
  std::mt19937_64 random(3);
  for (int trial = 0; trial < 200; ++trial) {
    const Eigen::Matrix3d S = random_matrix(random);
    const Eigen::Matrix3d direction = random_matrix(random);
    const double step = 1e-6;
    const double slope =
        (barrier_value(S + step * direction, 0.3) - barrier_value(S - step * direction, 0.3)) / (2 * step);
    const double predicted = barrier_term(S, 0.3).gradient.cwiseProduct(direction).sum();
    CHECK_NEAR(slope, predicted, 1e-5 * (1 + std::abs(predicted)));
  }
}

double curvature(const BarrierTerm& term, const Eigen::Matrix3d& S, const Eigen::Matrix3d& direction) {
  const double by_s = S.cwiseProduct(direction).sum();
  const double by_d = term.cofactors.cwiseProduct(direction).sum();
  return term.identity * direction.squaredNorm() + 2 * term.mixed * by_s * by_d + term.square * by_d * by_d;
}

void test_hessian_is_positive() {
  std::mt19937_64 random(4);
  for (int trial = 0; trial < 2000; ++trial) {
    const Eigen::Matrix3d S = random_matrix(random);
    CHECK(curvature(barrier_term(S, 0.1), S, random_matrix(random)) >= 0);
  }
}

// Along matrices of rank one the determinant is linear, and no term of the Hessian is left out; where it is
// one none is clamped.
void test_hessian_is_the_second_derivative() {
  std::mt19937_64 random(6);
  for (int trial = 0; trial < 200; ++trial) {
    Eigen::Matrix3d S = random_matrix(random);
    S /= std::cbrt(S.determinant());
    const Eigen::Matrix3d direction = random_matrix(random).col(0) * random_matrix(random).row(0);
    const double step = 1e-4 / direction.norm();
    const auto value = [&](double t) { return barrier_value(S + t * step * direction, 0.3); };
    const double measured = (value(1) - 2 * value(0) + value(-1)) / (step * step);
    const double predicted = curvature(barrier_term(S, 0.3), S, direction);
    CHECK_NEAR(measured, predicted, 1e-3 * (1 + std::abs(predicted)));
  }
}

// At S = identity the dropped term is g'(d) times the second derivative of d; along multiples of S the second
// derivative of d is 6 t, so what is left must still predict the energy to within that.
void test_identity_is_the_minimum() {
  std::mt19937_64 random(5);
  const double lowest = barrier_value(Eigen::Matrix3d::Identity(), 1e-12);
  CHECK_NEAR(lowest, 5, 1e-9);
  CHECK_NEAR(barrier_term(Eigen::Matrix3d::Identity(), 1e-12).gradient.norm(), 0, 1e-9);
  for (int trial = 0; trial < 200; ++trial) {
    CHECK(barrier_value(Eigen::Matrix3d::Identity() + 0.2 * random_matrix(random), 1e-12) >= lowest - 1e-12);
  }
}

// A chain of springs held at one end, stretched by one at each joint: too long to be factored for one system.
void test_large_systems_have_the_same_solution() {
  const Eigen::Index length = 20001;
  std::vector<Eigen::Triplet<double>> springs;
  for (Eigen::Index i = 0; i < length; ++i) {
    springs.emplace_back(i, i, i + 1 < length ? 2 : 1);
    if (i > 0) springs.emplace_back(i, i - 1, -1);
  }
  SparseMatrix chain(length, length);
  chain.setFromTriplets(springs.begin(), springs.end());
  const Eigen::VectorXd pull = Eigen::VectorXd::Unit(length, length - 1);
  for (const Eigen::Index systems : {1, 1000}) {
    const Eigen::VectorXd moved = SpdSolver(chain, systems).solve(pull);
    CHECK_NEAR(moved(0), 1, 1e-6);
    CHECK_NEAR(moved(length - 1), static_cast<double>(length), 1e-3);
  }
}

// A ring of springs that nothing holds: its matrix has no factorisation with positive pivots, rounding apart.
void test_systems_on_the_edge_of_definite() {
  const Eigen::Index length = 50;
  SparseMatrix ring(length, length);
  std::vector<Eigen::Triplet<double>> springs;
  for (Eigen::Index i = 0; i < length; ++i) {
    springs.emplace_back(i, i, 2 - 1e-15);
    if (i > 0) springs.emplace_back(i, i - 1, -1);
  }
  springs.emplace_back(length - 1, 0, -1);
  ring.setFromTriplets(springs.begin(), springs.end());
  Eigen::VectorXd pull = Eigen::VectorXd::Unit(length, 25) - Eigen::VectorXd::Unit(length, 0);
  const Eigen::VectorXd moved = SpdSolver(ring, 1).solve(pull);
  CHECK_NEAR(moved(25) - moved(0), 12.5, 1e-3);
}

// Rounding errors may leave a Schur complement that is not positive: the search for integers ends all the
// same.
void test_integers_of_an_indefinite_energy() {
  const Eigen::Matrix2d schur = Eigen::Vector2d(-1, 1).asDiagonal();
  const Quantization found = quantize(schur, Eigen::Vector2d(57.8, 3.2), {});
  CHECK((found.integers - Eigen::Vector2d(58, 3)).norm() < 3);
  const Eigen::Matrix2d nothing = Eigen::Matrix2d::Constant(NAN);
  CHECK(quantize(nothing, Eigen::Vector2d(57.8, 3.2), {}).violated_rows == 0);
}

}  // namespace
}  // namespace neurframe

int main() {
  neurframe::test_gradient_is_the_derivative();
  neurframe::test_hessian_is_positive();
  neurframe::test_hessian_is_the_second_derivative();
  neurframe::test_identity_is_the_minimum();
  neurframe::test_large_systems_have_the_same_solution();
  neurframe::test_systems_on_the_edge_of_definite();
  neurframe::test_integers_of_an_indefinite_energy();
  return neurframe::test_result();
}
