#include "cubecover/untangle.hpp"

#include <algorithm>
#include <cmath>

#include "core/parallel.hpp"
#include "cubecover/barrier_energy.hpp"
#include "cubecover/stencils.hpp"

namespace neurframe {

namespace {

constexpr double first_epsilon = 0.2;  // 1 let whole maps shrink to a point where nothing fixes their size
constexpr double least_epsilon = 1e-9;
constexpr double least_fall = 0.3;   // of epsilon in one iteration
constexpr int most_iterations = 50;  // sound maps took at most 10
constexpr int patience = 6;          // iterations without a tenth fewer folded tets
constexpr double settled = 1e-3;     // relative decrease of the energy at which an unfolded map is done
constexpr double direction_tolerance = 1e-3;
constexpr int block_size = 8192;  // tets whose derivatives are held at once, 10 MB

// Garanzha et al. 2021, section 4: epsilon falls faster the more the energy fell.  Their least share
// is a tenth; with three tenths as many tets unfold, in as many iterations or fewer.
double next_epsilon(double epsilon, double energy_ratio, double smallest_determinant) {
  const double sigma = std::max(least_fall, 1 - energy_ratio);
  if (smallest_determinant >= 0) return std::max(least_epsilon, (1 - sigma) * epsilon);
  const double root = std::sqrt(smallest_determinant * smallest_determinant + epsilon * epsilon);
  return std::max(least_epsilon, (1 - sigma * root / (std::abs(smallest_determinant) + root)) * epsilon);
}

class Untangler {
 public:
  Untangler(const TetTargets& targets, const ReducedMap& map, int active, int threads)
      : targets_(targets), map_(map), active_(active), threads_(threads), stencils_(map, active) {}

  UntangleResult run(const Eigen::VectorXd& start) {
    UntangleResult result{start, foldover(start), {}, 0};
    result.after = result.before;
    Eigen::VectorXd columns = start;
    double epsilon = first_epsilon;
    int fewest = result.before.count;
    for (int waited = 0; result.iterations < most_iterations && waited < patience;) {
      const double ratio = newton_step(columns, epsilon);
      ++result.iterations;
      const Foldover now = foldover(columns);
      if (now.count <= result.after.count) {
        result.after = now;
        result.columns = columns;
      }
      if (now.count == 0 && ratio > 1 - settled) break;
      epsilon = next_epsilon(epsilon, ratio, now.smallest);
      const bool progressed = now.count == 0 || now.count <= 0.9 * fewest;
      waited = progressed ? 0 : waited + 1;
      if (progressed) fewest = now.count;
    }
    return result;
  }

 private:
  int tet_count() const { return static_cast<int>(targets_.weight.size()); }

  Foldover foldover(const Eigen::VectorXd& columns) const {
    return measure_foldover(targets_, map_, evaluate(map_, columns));
  }

  // Summed by chunks, so that the value does not depend on the number of threads.
  double energy(const Eigen::VectorXd& columns, double epsilon) const {
    const Eigen::VectorXd rows = evaluate(map_, columns);
    std::vector<double> sums(static_cast<std::size_t>(chunk_count(tet_count())), 0);
    parallel_chunks(tet_count(), threads_, [&](std::int64_t begin, std::int64_t end, std::int64_t chunk) {
      for (int t = static_cast<int>(begin); t < end; ++t) {
        sums[static_cast<std::size_t>(chunk)] +=
            at(targets_.weight, t) * barrier_value(relative_gradient(targets_, map_, rows, t), epsilon);
      }
    });
    double sum = 0;
    for (const double part : sums) sum += part;
    return sum;
  }

  struct TetDerivatives {
    TetGradient gradient;
    TetHessian hessian;
  };

  // S = U B with B = relative: the derivative by coordinate i of corner c is entry (i, c) of (dS) B^T.
  TetDerivatives derivatives(const Eigen::VectorXd& rows, int tet, double epsilon) const {
    const Eigen::Matrix3d S = relative_gradient(targets_, map_, rows, tet);
    const BarrierTerm term = barrier_term(S, epsilon);
    const Eigen::Matrix<double, 4, 3>& relative = at(targets_.relative, tet);
    const double weight = at(targets_.weight, tet);
    TetDerivatives found;
    const Eigen::Matrix<double, 3, 4> by_corner = weight * term.gradient * relative.transpose();
    found.gradient = by_corner.reshaped();
    const TetGradient along_s = (S * relative.transpose()).eval().reshaped();
    const TetGradient along_d = (term.cofactors * relative.transpose()).eval().reshaped();
    const TetGradient mixed = weight * (term.mixed * along_s + term.square / 2 * along_d);
    found.hessian = mixed * along_d.transpose();
    found.hessian += along_d * mixed.transpose();
    const Eigen::Matrix4d stiffness = weight * term.identity * relative * relative.transpose();
    for (int a = 0; a < 4; ++a) {
      for (int b = 0; b < 4; ++b)
        found.hessian.block<3, 3>(3 * a, 3 * b).diagonal().array() += stiffness(a, b);
    }
    return found;
  }

  void assemble(const Eigen::VectorXd& columns, double epsilon) {
    const Eigen::VectorXd rows = evaluate(map_, columns);
    stencils_.clear();
    std::vector<TetDerivatives> block;
    for (int first = 0; first < tet_count(); first += block_size) {
      const int count = std::min(block_size, tet_count() - first);
      block.resize(static_cast<std::size_t>(count));
      parallel_for(count, threads_, [&](std::int64_t i) {
        block[static_cast<std::size_t>(i)] = derivatives(rows, first + static_cast<int>(i), epsilon);
      });
      for (int i = 0; i < count; ++i) stencils_.add(first + i, at(block, i).gradient, at(block, i).hessian);
    }
  }

  // One step; returns the new energy over the old one.
  double newton_step(Eigen::VectorXd& columns, double epsilon) {
    assemble(columns, epsilon);
    const double start = energy(columns, epsilon);
    Eigen::VectorXd direction = Eigen::VectorXd::Zero(columns.size());
    direction.head(active_) = solve_loosely(stencils_.hessian(), -stencils_.gradient(), direction_tolerance);
    const double slope = direction.head(active_).dot(stencils_.gradient());
    // halved until the energy falls enough (Armijo)
    for (double step = 1; step > 1e-8; step /= 2) {
      const Eigen::VectorXd moved = columns + step * direction;
      const double value = energy(moved, epsilon);
      if (!std::isfinite(value) || value > start + 1e-4 * step * slope) continue;
      columns = moved;
      return value / start;
    }
    return 1;
  }

  const TetTargets& targets_;
  const ReducedMap& map_;
  int active_;
  int threads_;
  Stencils stencils_;
};

}  // namespace

UntangleResult untangle(const TetTargets& targets, const ReducedMap& map, const Eigen::VectorXd& columns,
                        int active, int threads) {
  if (active == 0) {
    const Foldover foldover = measure_foldover(targets, map, evaluate(map, columns));
    return {columns, foldover, foldover, 0};
  }
  return Untangler(targets, map, active, threads).run(columns);
}

}  // namespace neurframe
