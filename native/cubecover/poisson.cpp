#include "cubecover/poisson.hpp"

namespace neurframe {

QuadraticEnergy quadratic_energy(const TetTargets& targets, const ReducedMap& map,
                                 const std::vector<Eigen::Matrix3d>& relative_gradient_targets) {
  std::vector<Eigen::Triplet<double>> triplets;
  QuadraticEnergy energy{SparseMatrix(map.column_count(), map.column_count()),
                         Eigen::VectorXd::Zero(map.column_count())};
  const auto each_term = [&](int row, const auto& visit) {
    for (int k = at(map.begin, row); k < at(map.begin, row + 1); ++k)
      visit(at(map.column, k), at(map.factor, k));
  };
  for (int t = 0; t < static_cast<int>(targets.weight.size()); ++t) {
    const Eigen::Matrix<double, 4, 3>& relative = at(targets.relative, t);
    const Eigen::Matrix4d stiffness = at(targets.weight, t) * relative * relative.transpose();
    const Eigen::Matrix3d wanted =
        relative_gradient_targets.empty() ? Eigen::Matrix3d::Identity() : at(relative_gradient_targets, t);
    const Eigen::Matrix<double, 3, 4> load = at(targets.weight, t) * wanted * relative.transpose();
    for (int corner = 0; corner < 4; ++corner) {
      for (int axis = 0; axis < 3; ++axis) {
        each_term(3 * at(at(map.class_of_corner, t), corner) + axis, [&](int column, double factor) {
          energy.right_side(column) += factor * load(axis, corner);
          for (int other = 0; other < 4; ++other) {
            each_term(
                3 * at(at(map.class_of_corner, t), other) + axis, [&](int second, double second_factor) {
                  triplets.emplace_back(column, second, factor * second_factor * stiffness(corner, other));
                });
          }
        });
      }
    }
  }
  energy.hessian.setFromTriplets(triplets.begin(), triplets.end());
  return energy;
}

Eigen::VectorXd minimise(const QuadraticEnergy& energy, const Eigen::VectorXd& columns, int active) {
  const Eigen::Index rest = columns.size() - active;
  const Eigen::VectorXd right_side =
      energy.right_side.head(active) - energy.hessian.topRightCorner(active, rest) * columns.tail(rest);
  Eigen::VectorXd minimum = columns;
  minimum.head(active) = SpdSolver(energy.hessian.topLeftCorner(active, active), 1).solve(right_side);
  return minimum;
}

}  // namespace neurframe
