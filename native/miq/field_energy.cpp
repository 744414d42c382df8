#include "miq/field_energy.hpp"

#include "core/errors.hpp"

namespace neurframe {
namespace {

bool beside_feature(const CrossSurface& surface, int f) {
  return surface.is_feature(3 * f) || surface.is_feature(3 * f + 1) || surface.is_feature(3 * f + 2);
}

}  // namespace

FieldEnergy::FieldEnergy(const CrossSurface& surface)
    : surface_(surface),
      number_(surface.triangles.size(), -1),
      weight_(static_cast<size_t>(surface.half_edge_count()), 0),
      residual_(weight_) {
  int count = 0;
  for (int f = 0; f < surface.triangle_count(); ++f) {
    if (!beside_feature(surface, f)) number_[static_cast<size_t>(f)] = count++;
  }
  std::vector<Eigen::Triplet<double>> triplets;
  // a component without features may turn as a whole: the tiny diagonal keeps its common turn at zero
  for (int i = 0; i < count; ++i) triplets.emplace_back(i, i, 1e-9);
  for (int h = 0; h < surface.half_edge_count(); ++h) {
    if (surface.twin(h) < 0 || surface.is_feature(h)) continue;
    const auto k = static_cast<size_t>(h);
    weight_[k] = dual_weight(surface, h);
    residual_[k] = rotation_residual(surface, h);
    const int i = number_[k / 3], j = number_[static_cast<size_t>(surface.twin(h) / 3)];
    if (i >= 0) triplets.emplace_back(i, i, weight_[k]);
    if (i >= 0 && j >= 0) triplets.emplace_back(i, j, -weight_[k]);
  }
  Eigen::SparseMatrix<double> matrix(count, count);
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  factor_.compute(matrix);
  if (factor_.info() != Eigen::Success) {
    throw StageError("the smoothness system of the crosses is singular");
  }
  relax();
}

void FieldEnergy::relax() {
  Eigen::VectorXd right = Eigen::VectorXd::Zero(factor_.rows());
  for (size_t h = 0; h < weight_.size(); ++h) {
    const int i = number_[h / 3];
    if (i >= 0) right[i] -= weight_[h] * residual_[h];
  }
  const Eigen::VectorXd turn = factor_.solve(right);
  for (size_t h = 0; h < weight_.size(); ++h) {
    if (weight_[h] == 0) continue;
    const int i = number_[h / 3];
    const int j = number_[static_cast<size_t>(surface_.twin(static_cast<int>(h)) / 3)];
    // turning both by d changes the residual from this triangle to the other by d_this - d_other
    residual_[h] += (i >= 0 ? turn[i] : 0) - (j >= 0 ? turn[j] : 0);
  }
}

Eigen::VectorXd FieldEnergy::jump(const ShiftPath& path, int turns) const {
  Eigen::VectorXd right = Eigen::VectorXd::Zero(factor_.rows());
  for (const int h : path) {
    const double force = weight_[static_cast<size_t>(h)] * turns * kQuarterTurn;
    const int i = number_[static_cast<size_t>(h / 3)];
    const int j = number_[static_cast<size_t>(surface_.twin(h) / 3)];
    if (i >= 0) right[i] -= force;
    if (j >= 0) right[j] += force;
  }
  return right;
}

double FieldEnergy::own_energy(const ShiftPath& path) const {
  double energy = 0;
  for (const int h : path) energy += weight_[static_cast<size_t>(h)] * kQuarterTurn * kQuarterTurn;
  const Eigen::VectorXd right = jump(path, 1);
  return energy - right.dot(factor_.solve(right));
}

double FieldEnergy::change(const ShiftPath& path, int turns, double own_energy) const {
  // the residuals of a relaxed field are orthogonal to all turns of crosses, so that only the path itself
  // counts
  double along = 0;
  for (const int h : path) along += weight_[static_cast<size_t>(h)] * residual_[static_cast<size_t>(h)];
  return 2 * turns * kQuarterTurn * along + own_energy;
}

void FieldEnergy::shift(const ShiftPath& path, int turns) {
  for (const int h : path) {
    residual_[static_cast<size_t>(h)] += turns * kQuarterTurn;
    residual_[static_cast<size_t>(surface_.twin(h))] -= turns * kQuarterTurn;
  }
  relax();
}

}  // namespace neurframe
