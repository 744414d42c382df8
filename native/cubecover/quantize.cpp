#include "cubecover/quantize.hpp"

#include <algorithm>
#include <cmath>

namespace neurframe {

Eigen::MatrixXd schur_complement(const QuadraticEnergy& energy, int real_count) {
  const Eigen::Index integers = energy.right_side.size() - real_count;
  const SparseMatrix coupling = energy.hessian.topRightCorner(real_count, integers);
  Eigen::MatrixXd schur = energy.hessian.bottomRightCorner(integers, integers);
  const SpdSolver solver(energy.hessian.topLeftCorner(real_count, real_count), integers);
  for (Eigen::Index i = 0; i < integers; ++i) {
    const Eigen::VectorXd response = solver.solve(coupling.col(i));
    schur.col(i) -= coupling.transpose() * response;
  }
  return (schur + schur.transpose()) / 2;
}

namespace {

constexpr double in_doubt = 0.2;  // further than this from an integer, both neighbours are tried
constexpr int most_active_set_steps = 30;

class LatticeSearch {
 public:
  LatticeSearch(const Eigen::MatrixXd& schur, const Eigen::VectorXd& relaxed,
                const std::vector<SeparationRow>& rows)
      : schur_(schur), relaxed_(relaxed), rows_(static_cast<Eigen::Index>(rows.size()), relaxed.size()) {
    for (Eigen::Index r = 0; r < rows_.rows(); ++r) {
      const SeparationRow& row = rows[static_cast<std::size_t>(r)];
      for (Eigen::Index c = 0; c < rows_.cols(); ++c) rows_(r, c) = row[static_cast<std::size_t>(c)];
    }
    // a violated row must cost more than any deformation that could satisfy it
    penalty_ = 1e4 * std::max(1e-12, schur.diagonal().maxCoeff());
  }

  Quantization search() {
    round_greedily();
    while (may_gain() && improve_by_moves()) {
    }
    Quantization result{integers_, deformation(integers_), 0};
    for (Eigen::Index r = 0; r < rows_.rows(); ++r)
      result.violated_rows += rows_.row(r).dot(integers_) < 0.5 ? 1 : 0;
    return result;
  }

 private:
  double deformation(const Eigen::VectorXd& m) const { return (m - relaxed_).dot(schur_ * (m - relaxed_)); }

  // A deformation below zero, or none that is a number, is rounding error (of tets whose edges differ by a
  // factor of 1e6, say): then the moves would go on for ever, each gaining more than the one before.
  bool may_gain() const { return deformation(integers_) >= 0; }

  double cost(const Eigen::VectorXd& m) const {
    const Eigen::VectorXd lacking = (1 - (rows_ * m).array()).max(0.0);
    return deformation(m) + penalty_ * lacking.squaredNorm();
  }

  // The minimum over the integers that are not fixed yet, as reals; violated rows pull as springs.
  Eigen::VectorXd relax(const std::vector<char>& fixed, Eigen::VectorXd m) const {
    std::vector<Eigen::Index> open;
    for (Eigen::Index i = 0; i < m.size(); ++i) {
      if (!fixed[static_cast<std::size_t>(i)]) open.push_back(i);
    }
    if (open.empty()) return m;
    std::vector<char> active(static_cast<std::size_t>(rows_.rows()), 0);
    for (int step = 0; step < most_active_set_steps; ++step) {
      Eigen::MatrixXd matrix = schur_;
      Eigen::VectorXd gradient = schur_ * (m - relaxed_);
      std::vector<Eigen::Index> violated_rows;
      bool changed = step == 0;
      for (Eigen::Index r = 0; r < rows_.rows(); ++r) {
        const bool violated = rows_.row(r).dot(m) < 1;
        changed |= violated != static_cast<bool>(active[static_cast<std::size_t>(r)]);
        active[static_cast<std::size_t>(r)] = violated;
        if (!violated) continue;
        gradient -= penalty_ * (1 - rows_.row(r).dot(m)) * rows_.row(r).transpose();
        violated_rows.push_back(r);
      }
      if (!changed) break;
      const Eigen::MatrixXd springs = rows_(violated_rows, Eigen::all);
      matrix += penalty_ * springs.transpose() * springs;
      m(open) -= Eigen::MatrixXd(matrix(open, open)).ldlt().solve(Eigen::VectorXd(gradient(open)));
    }
    return m;
  }

  void round_greedily() {
    std::vector<char> fixed(static_cast<std::size_t>(relaxed_.size()), 0);
    integers_ = relax(fixed, relaxed_);
    for (Eigen::Index count = 0; count < integers_.size(); ++count) {
      Eigen::Index surest = -1;
      const auto doubt = [&](Eigen::Index i) { return std::abs(integers_(i) - std::round(integers_(i))); };
      for (Eigen::Index i = 0; i < integers_.size(); ++i) {
        if (!fixed[static_cast<std::size_t>(i)] && (surest < 0 || doubt(i) < doubt(surest))) surest = i;
      }
      fixed[static_cast<std::size_t>(surest)] = 1;
      const double value = integers_(surest);
      const double nearest = std::round(value);
      Eigen::VectorXd best = relax_with(fixed, surest, nearest);
      if (std::abs(value - nearest) > in_doubt) {
        const Eigen::VectorXd other = relax_with(fixed, surest, nearest + (value > nearest ? 1 : -1));
        if (cost(other) < cost(best)) best = other;
      }
      integers_ = best;
    }
  }

  Eigen::VectorXd relax_with(const std::vector<char>& fixed, Eigen::Index index, double value) const {
    Eigen::VectorXd m = integers_;
    m(index) = value;
    return relax(fixed, m);
  }

  struct Move {
    Eigen::Index first = -1;
    Eigen::Index second = -1;  // -1 for none
    double by_first = 0;
    double by_second = 0;
  };

  // What the move adds to the cost, from the gradient of the deformation and what the rows lack already.
  double change_of_cost(const Move& move, const Eigen::VectorXd& gradient, const Eigen::VectorXd& lacking,
                        double penalised) const {
    double change = 2 * move.by_first * gradient(move.first) + schur_(move.first, move.first);
    Eigen::ArrayXd next = lacking.array() - move.by_first * rows_.col(move.first).array();
    if (move.second >= 0) {
      change += 2 * move.by_second * gradient(move.second) + schur_(move.second, move.second) +
                2 * move.by_first * move.by_second * schur_(move.first, move.second);
      next -= move.by_second * rows_.col(move.second).array();
    }
    return change + penalty_ * (next.max(0.0).square().sum() - penalised);
  }

  // The best move of one integer, or two together, by one; returns whether there was one that lowers the
  // cost.
  bool improve_by_moves() {
    const Eigen::VectorXd gradient = schur_ * (integers_ - relaxed_);
    const Eigen::VectorXd lacking = 1 - (rows_ * integers_).array();
    const double penalised = lacking.array().max(0.0).square().sum();
    double best_change = -1e-9 * cost(integers_) - 1e-12;
    Move best;
    const auto consider = [&](const Move& move) {
      const double change = change_of_cost(move, gradient, lacking, penalised);
      if (change >= best_change) return;
      best_change = change;
      best = move;
    };
    for (Eigen::Index i = 0; i < integers_.size(); ++i) {
      for (const double by_i : {1.0, -1.0}) {
        consider({i, -1, by_i, 0});
        for (Eigen::Index j = 0; j < i; ++j) {
          for (const double by_j : {1.0, -1.0}) consider({i, j, by_i, by_j});
        }
      }
    }
    if (best.first < 0) return false;
    integers_(best.first) += best.by_first;
    if (best.second >= 0) integers_(best.second) += best.by_second;
    return true;
  }

  const Eigen::MatrixXd& schur_;
  const Eigen::VectorXd& relaxed_;
  Eigen::MatrixXd rows_;
  double penalty_ = 0;
  Eigen::VectorXd integers_;
};

}  // namespace

Quantization quantize(const Eigen::MatrixXd& schur, const Eigen::VectorXd& relaxed,
                      const std::vector<SeparationRow>& rows) {
  if (relaxed.size() == 0) return {relaxed, 0, 0};
  return LatticeSearch(schur, relaxed, rows).search();
}

}  // namespace neurframe
