// The barrier energy against finite differences, and its Hessian against the sign that Newton needs.
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

void test_hessian_is_positive() {
  std::mt19937_64 random(4);
  for (int trial = 0; trial < 200; ++trial) {
    const BarrierTerm term = barrier_term(random_matrix(random), 0.1);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> eigen(term.hessian);
    CHECK(eigen.eigenvalues()(0) >= -1e-9 * eigen.eigenvalues()(8));
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
  neurframe::test_identity_is_the_minimum();
  neurframe::test_integers_of_an_indefinite_energy();
  return neurframe::test_result();
}
