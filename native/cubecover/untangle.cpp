#include "cubecover/untangle.hpp"

#include <algorithm>
#include <cmath>

#include "cubecover/barrier_energy.hpp"
#include "cubecover/stencils.hpp"

namespace neurframe {

namespace {

constexpr double first_epsilon = 0.2;  // 1 let whole maps shrink to a point where nothing fixes their size
constexpr double least_epsilon = 1e-9;
constexpr int most_iterations = 100;
constexpr int patience = 10;      // iterations without fewer folded tets
constexpr double settled = 1e-3;  // relative decrease of the energy at which an unfolded map is done
constexpr double direction_tolerance = 1e-3;

double energy(const TetTargets& targets, const ReducedMap& map, const Eigen::VectorXd& columns,
              double epsilon) {
  const Eigen::VectorXd rows = evaluate(map, columns);
  double sum = 0;
  for (int t = 0; t < static_cast<int>(targets.weight.size()); ++t) {
    sum += at(targets.weight, t) * barrier_value(relative_gradient(targets, map, rows, t), epsilon);
  }
  return sum;
}

// S = U B, entry (i, k) = sum over corners c of U(i, c) B(c, k); vec is column by column.
Eigen::Matrix<double, 9, 12> gradient_operator(const Eigen::Matrix<double, 4, 3>& relative) {
  Eigen::Matrix<double, 9, 12> by_parameters = Eigen::Matrix<double, 9, 12>::Zero();
  for (int corner = 0; corner < 4; ++corner) {
    for (int k = 0; k < 3; ++k) {
      for (int i = 0; i < 3; ++i) by_parameters(3 * k + i, 3 * corner + i) = relative(corner, k);
    }
  }
  return by_parameters;
}

void assemble(const TetTargets& targets, const ReducedMap& map, const Eigen::VectorXd& columns,
              double epsilon, Stencils& stencils) {
  const Eigen::VectorXd rows = evaluate(map, columns);
  stencils.clear();
  for (int t = 0; t < static_cast<int>(targets.weight.size()); ++t) {
    const BarrierTerm term = barrier_term(relative_gradient(targets, map, rows, t), epsilon);
    const Eigen::Matrix<double, 9, 12> operator_t = gradient_operator(at(targets.relative, t));
    const Eigen::Map<const Eigen::Matrix<double, 9, 1>> gradient(term.gradient.data());
    const double weight = at(targets.weight, t);
    stencils.add(t, weight * operator_t.transpose() * gradient,
                 weight * operator_t.transpose() * term.hessian * operator_t);
  }
}

// Halves the step until the energy falls; 0 when no step does.
double line_search(const TetTargets& targets, const ReducedMap& map, const Eigen::VectorXd& columns,
                   const Eigen::VectorXd& direction, double slope, double epsilon, double start_energy) {
  for (double step = 1; step > 1e-8; step /= 2) {
    const double value = energy(targets, map, columns + step * direction, epsilon);
    if (std::isfinite(value) && value <= start_energy + 1e-4 * step * slope) return step;
  }
  return 0;
}

// Garanzha et al. 2021, section 4: epsilon falls faster the more the energy fell.
double next_epsilon(double epsilon, double energy_ratio, double smallest_determinant) {
  const double sigma = std::max(0.1, 1 - energy_ratio);
  if (smallest_determinant >= 0) return std::max(least_epsilon, (1 - sigma) * epsilon);
  const double root = std::sqrt(smallest_determinant * smallest_determinant + epsilon * epsilon);
  return std::max(least_epsilon, (1 - sigma * root / (std::abs(smallest_determinant) + root)) * epsilon);
}

}  // namespace

UntangleResult untangle(const TetTargets& targets, const ReducedMap& map, const Eigen::VectorXd& columns,
                        int active) {
  UntangleResult result{columns, measure_foldover(targets, map, evaluate(map, columns)), {}, 0};
  result.after = result.before;
  if (active == 0) return result;
  Stencils stencils(map, active);
  double epsilon = first_epsilon;
  int fewest = result.before.count;
  int since_fewest = 0;
  for (; result.iterations < most_iterations && since_fewest < patience; ++result.iterations) {
    assemble(targets, map, result.columns, epsilon, stencils);
    const double start = energy(targets, map, result.columns, epsilon);
    Eigen::VectorXd direction = Eigen::VectorXd::Zero(columns.size());
    direction.head(active) = solve_loosely(stencils.hessian(), -stencils.gradient(), direction_tolerance);
    const double slope = direction.head(active).dot(stencils.gradient());
    const double step = line_search(targets, map, result.columns, direction, slope, epsilon, start);
    result.columns += step * direction;
    const double ratio = energy(targets, map, result.columns, epsilon) / start;
    result.after = measure_foldover(targets, map, evaluate(map, result.columns));
    if (result.after.count == 0 && ratio > 1 - settled) break;
    epsilon = next_epsilon(epsilon, ratio, result.after.smallest);
    since_fewest = result.after.count < fewest || result.after.count == 0 ? 0 : since_fewest + 1;
    fewest = std::min(fewest, result.after.count);
  }
  return result;
}

}  // namespace neurframe
