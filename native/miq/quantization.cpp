#include "miq/quantization.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

namespace neurframe {
namespace {

constexpr double kUnbounded = std::numeric_limits<double>::infinity();

// rows * values >= least
struct RowSystem {
  Eigen::MatrixXd rows;
  Eigen::VectorXd least;
};

// Successive conditioning of a quadratic programme with rows on integer values of its variables.
class ConditionalProgramme {
 public:
  ConditionalProgramme(const Eigen::MatrixXd& schur, const Eigen::VectorXd& target, const RowSystem& system)
      : covariance_(schur.llt().solve(Eigen::MatrixXd::Identity(schur.rows(), schur.cols()))),
        rows_(system.rows),
        least_(system.least),
        pull_(covariance_ * rows_.transpose()),
        stiffness_(rows_ * pull_),
        unconstrained_(target),
        optimum_(target),
        multipliers_(Eigen::VectorXd::Zero(rows_.rows())),
        fixed_(static_cast<size_t>(target.size()), 0) {}

  void solve_rows();
  int cheapest(double& value) const;
  void fix(int k, double value);
  const Eigen::VectorXd& optimum() const { return optimum_; }

 private:
  void bounds(int k, double& low, double& high) const;

  Eigen::MatrixXd covariance_;
  const Eigen::MatrixXd& rows_;
  const Eigen::VectorXd& least_;
  Eigen::MatrixXd pull_;       // covariance times rows^T: how each row's multiplier moves the optimum
  Eigen::MatrixXd stiffness_;  // and how it moves the rows
  Eigen::VectorXd unconstrained_;
  Eigen::VectorXd optimum_;
  Eigen::VectorXd multipliers_;
  std::vector<char> fixed_;
};

// Hildreth's method: one multiplier after the other, warm from the last call.
void ConditionalProgramme::solve_rows() {
  constexpr int kMostSweeps = 100;
  Eigen::VectorXd lacking = least_ - rows_ * unconstrained_ - stiffness_ * multipliers_;
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    double change = 0;
    for (Eigen::Index j = 0; j < rows_.rows(); ++j) {
      const double stiffness = stiffness_(j, j);
      if (stiffness < 1e-9) continue;
      const double step = std::max(-multipliers_[j], lacking[j] / stiffness);
      if (step == 0) continue;
      multipliers_[j] += step;
      lacking -= step * stiffness_.col(j);
      change = std::max(change, std::abs(step) * stiffness);
    }
    if (change < 1e-4) break;
  }
  optimum_ = unconstrained_ + pull_ * multipliers_;
}

// Rows whose only variable left is k bound it.
void ConditionalProgramme::bounds(int k, double& low, double& high) const {
  low = -kUnbounded;
  high = kUnbounded;
  for (Eigen::Index j = 0; j < rows_.rows(); ++j) {
    const double factor = rows_(j, k);
    if (factor == 0) continue;
    double rest = 0;
    bool alone = true;
    for (Eigen::Index i = 0; i < rows_.cols() && alone; ++i) {
      if (i == k || rows_(j, i) == 0) continue;
      alone = fixed_[static_cast<size_t>(i)] != 0;
      rest += rows_(j, i) * optimum_[i];
    }
    if (!alone) continue;
    const double bound = (least_[j] - rest) / factor;
    if (factor > 0) low = std::max(low, std::ceil(bound - 1e-6));
    if (factor < 0) high = std::min(high, std::floor(bound + 1e-6));
  }
}

int ConditionalProgramme::cheapest(double& value) const {
  int best = -1;
  double least = kUnbounded;
  for (Eigen::Index k = 0; k < optimum_.size(); ++k) {
    if (fixed_[static_cast<size_t>(k)]) continue;
    const double distance = optimum_[k] - std::round(optimum_[k]);
    const double cost = distance * distance / covariance_(k, k);
    if (cost >= least) continue;
    least = cost;
    best = static_cast<int>(k);
  }
  if (best < 0) return best;
  double low = 0;
  double high = 0;
  bounds(best, low, high);
  value = std::round(optimum_[best]);
  if (low <= high) value = std::clamp(value, low, high);
  return best;
}

void ConditionalProgramme::fix(int k, double value) {
  const Eigen::VectorXd column = covariance_.col(k) / covariance_(k, k);
  unconstrained_ += column * (value - unconstrained_[k]);
  covariance_ -= column * covariance_.row(k).eval();
  const Eigen::VectorXd row_column = rows_ * column;
  stiffness_ -= row_column * pull_.row(k);
  pull_ -= column * pull_.row(k).eval();
  pull_.row(k).setZero();
  covariance_.col(k).setZero();
  covariance_.row(k).setZero();
  unconstrained_[k] = value;
  optimum_[k] = value;
  fixed_[static_cast<size_t>(k)] = 1;
}

// Descent by moves of one variable, or of two at once, in energy plus a price per unit of violated row.
class LocalSearch {
 public:
  LocalSearch(const Eigen::MatrixXd& schur, const Eigen::VectorXd& target, const RowSystem& system,
              Eigen::VectorXd& values)
      : schur_(schur),
        rows_(system.rows),
        values_(values),
        force_(schur * (values - target)),
        slack_(rows_ * values - system.least),
        // dearer than the energy of any move of a few cells
        price_(100 * (1 + schur.diagonal().maxCoeff())) {}

  // makes the best single or double move; false at a local minimum
  bool step() {
    best_gain_ = -1e-9;
    const Eigen::Index n = values_.size();
    for (Eigen::Index i = 0; i < n; ++i) {
      for (const double a : {-1.0, 1.0}) {
        consider(i, a, -1, 0);
        for (Eigen::Index j = i + 1; j < n; ++j) {
          consider(i, a, j, -1);
          consider(i, a, j, 1);
        }
      }
    }
    if (best_gain_ >= -1e-9) return false;
    apply(best_i_, best_a_);
    if (best_j_ >= 0) apply(best_j_, best_b_);
    return true;
  }

 private:
  void consider(Eigen::Index i, double a, Eigen::Index j, double b) {
    double gain = 2 * a * force_[i] + schur_(i, i);
    if (j >= 0) gain += 2 * b * force_[j] + schur_(j, j) + 2 * a * b * schur_(i, j);
    if (gain >= best_gain_ && !violated_) return;
    if (gain - price_ * violation_ >= best_gain_) return;
    gain += price_ * (violation_after(i, a, j, b) - violation_);
    if (gain >= best_gain_) return;
    best_gain_ = gain;
    best_i_ = i;
    best_a_ = a;
    best_j_ = j;
    best_b_ = b;
  }
  double violation_after(Eigen::Index i, double a, Eigen::Index j, double b) const {
    double sum = 0;
    for (Eigen::Index r = 0; r < rows_.rows(); ++r) {
      const double moved = slack_[r] + a * rows_(r, i) + (j >= 0 ? b * rows_(r, j) : 0.0);
      sum += std::max(0.0, -moved);
    }
    return sum;
  }
  void apply(Eigen::Index i, double a) {
    values_[i] += a;
    force_ += a * schur_.col(i);
    slack_ += a * rows_.col(i);
    violation_ = (-slack_).cwiseMax(0.0).sum();
    violated_ = violation_ > 0.5;
  }

  const Eigen::MatrixXd& schur_;
  const Eigen::MatrixXd& rows_;
  Eigen::VectorXd& values_;
  Eigen::VectorXd force_;
  Eigen::VectorXd slack_;
  const double price_;
  double violation_ = (-slack_).cwiseMax(0.0).sum();
  bool violated_ = violation_ > 0.5;
  double best_gain_ = 0;
  Eigen::Index best_i_ = -1, best_j_ = -1;
  double best_a_ = 0, best_b_ = 0;
};

// over the coefficients of the basis
RowSystem row_system(const std::vector<SeparationRow>& rows, const Eigen::MatrixXd& basis) {
  const auto count = static_cast<Eigen::Index>(rows.size());
  RowSystem out{Eigen::MatrixXd::Zero(count, basis.rows()), Eigen::VectorXd(count)};
  for (Eigen::Index j = 0; j < count; ++j) {
    const SeparationRow& row = rows[static_cast<size_t>(j)];
    for (const auto& [index, factor] : row.terms) out.rows(j, index) = static_cast<double>(factor);
    out.least[j] = 1 - static_cast<double>(row.constant);
  }
  out.rows = out.rows * basis;
  return out;
}

}  // namespace

Eigen::MatrixXd reduced_basis(const Eigen::MatrixXd& schur) {
  constexpr int kMostSweeps = 20;
  const Eigen::Index n = schur.rows();
  Eigen::MatrixXd basis = Eigen::MatrixXd::Identity(n, n);
  Eigen::MatrixXd gram = schur;
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    bool changed = false;
    for (Eigen::Index i = 0; i < n; ++i) {
      for (Eigen::Index j = 0; j < n; ++j) {
        if (i == j) continue;
        const double factor = std::round(gram(i, j) / gram(i, i));
        if (factor == 0 || std::abs(gram(i, j)) <= 0.501 * gram(i, i)) continue;
        basis.col(j) -= factor * basis.col(i);
        gram.col(j) -= factor * gram.col(i);
        gram.row(j) -= factor * gram.row(i);
        changed = true;
      }
    }
    if (!changed) break;
  }
  return basis;
}

Quantization quantize(const Eigen::MatrixXd& schur, const Eigen::VectorXd& target,
                      const std::vector<SeparationRow>& rows) {
  Quantization out;
  out.values = target;
  if (target.size() == 0) return out;
  const Eigen::MatrixXd basis = reduced_basis(schur);
  const RowSystem system = row_system(rows, basis);
  const Eigen::MatrixXd local = basis.transpose() * schur * basis;
  const Eigen::VectorXd local_target = basis.partialPivLu().solve(target);
  ConditionalProgramme programme(local, local_target, system);
  double value = 0;
  programme.solve_rows();
  for (int k = programme.cheapest(value); k >= 0; k = programme.cheapest(value)) {
    programme.fix(k, value);
    programme.solve_rows();
  }
  Eigen::VectorXd values = programme.optimum().array().round();
  LocalSearch search(local, local_target, system, values);
  const int most_moves = 20 * static_cast<int>(target.size());
  while (out.local_moves < most_moves && search.step()) ++out.local_moves;
  out.values = (basis * values).array().round();
  const Eigen::VectorXd shift = out.values - target;
  out.energy = shift.dot(schur * shift);
  out.violated_rows = static_cast<int>(((system.rows * values - system.least).array() < -0.5).count());
  return out;
}

}  // namespace neurframe
