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
constexpr int block_size = 8192;  // elements whose derivatives are held at once, 10 MB

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
  Untangler(const TetTargets& targets, const std::vector<FaceTarget>& faces, const ReducedMap& map,
            int active, int threads)
      : targets_(targets),
        faces_(faces),
        map_(map),
        active_(active),
        threads_(threads),
        stencils_(map, active) {}

  UntangleResult run(const Eigen::VectorXd& start) {
    UntangleResult result{start, foldover(start), {}, 0};
    result.after = result.before;
    Eigen::VectorXd columns = start;
    double epsilon = first_epsilon;
    int fewest = all_foldover(columns, result.before).count;
    int fewest_kept = fewest;
    for (int waited = 0; result.iterations < most_iterations && waited < patience;) {
      const double ratio = newton_step(columns, epsilon);
      ++result.iterations;
      const Foldover now = foldover(columns);
      const auto [wrong, smallest] = all_foldover(columns, now);
      if (wrong <= fewest_kept) {
        fewest_kept = wrong;
        result.after = now;
        result.columns = columns;
      }
      if (wrong == 0 && ratio > 1 - settled) break;
      epsilon = next_epsilon(epsilon, ratio, smallest);
      const bool progressed = wrong == 0 || wrong <= 0.9 * fewest;
      waited = progressed ? 0 : waited + 1;
      if (progressed) fewest = wrong;
    }
    return result;
  }

 private:
  int tet_count() const { return static_cast<int>(targets_.weight.size()); }
  int element_count() const { return tet_count() + static_cast<int>(faces_.size()); }

  Foldover foldover(const Eigen::VectorXd& columns) const {
    return measure_foldover(targets_, map_, evaluate(map_, columns));
  }

  // Of tets and boundary faces.
  Foldover all_foldover(const Eigen::VectorXd& columns, const Foldover& of_tets) const {
    const Foldover of_faces = measure_turned_faces(faces_, map_, evaluate(map_, columns));
    return {of_tets.count + of_faces.count, std::min(of_tets.smallest, of_faces.smallest)};
  }

  // Summed by chunks, so that the value does not depend on the number of threads.
  double energy(const Eigen::VectorXd& columns, double epsilon) const {
    const Eigen::VectorXd rows = evaluate(map_, columns);
    std::vector<double> sums(static_cast<std::size_t>(chunk_count(element_count())), 0);
    parallel_chunks(element_count(), threads_, [&](std::int64_t begin, std::int64_t end, std::int64_t chunk) {
      for (int e = static_cast<int>(begin); e < end; ++e)
        sums[static_cast<std::size_t>(chunk)] += value_of(rows, e, epsilon);
    });
    double sum = 0;
    for (const double part : sums) sum += part;
    return sum;
  }

  // Elements are the tets and then the boundary faces.
  double value_of(const Eigen::VectorXd& rows, int element, double epsilon) const {
    if (element < tet_count()) {
      return at(targets_.weight, element) *
             barrier_value(relative_gradient(targets_, map_, rows, element), epsilon);
    }
    const FaceTarget& face = at(faces_, element - tet_count());
    return face.weight * barrier_value(relative_gradient(face, map_, rows), epsilon);
  }

  struct TetDerivatives {
    int tet;
    TetGradient gradient;
    TetHessian hessian;
  };

  // S = U B with B = relative: the derivative by coordinate i of corner c is entry (i, c) of (dS) B^T.
  TetDerivatives derivatives(const Eigen::VectorXd& rows, int element, double epsilon) const {
    if (element < tet_count()) {
      return derivatives(element, relative_gradient(targets_, map_, rows, element),
                         at(targets_.relative, element), at(targets_.weight, element), epsilon);
    }
    const FaceTarget& face = at(faces_, element - tet_count());
    return derivatives(face.tet, relative_gradient(face, map_, rows), face.relative, face.weight, epsilon);
  }

  static TetDerivatives derivatives(int tet, const Eigen::Matrix3d& S,
                                    const Eigen::Matrix<double, 4, 3>& relative, double weight,
                                    double epsilon) {
    const BarrierTerm term = barrier_term(S, epsilon);
    TetDerivatives found;
    found.tet = tet;
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
    for (int first = 0; first < element_count(); first += block_size) {
      const int count = std::min(block_size, element_count() - first);
      block.resize(static_cast<std::size_t>(count));
      parallel_for(count, threads_, [&](std::int64_t i) {
        block[static_cast<std::size_t>(i)] = derivatives(rows, first + static_cast<int>(i), epsilon);
      });
      for (int i = 0; i < count; ++i)
        stencils_.add(at(block, i).tet, at(block, i).gradient, at(block, i).hessian);
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
  const std::vector<FaceTarget>& faces_;
  const ReducedMap& map_;
  int active_;
  int threads_;
  Stencils stencils_;
};

}  // namespace

UntangleResult untangle(const TetTargets& targets, const std::vector<FaceTarget>& faces,
                        const ReducedMap& map, const Eigen::VectorXd& columns, int active, int threads) {
  if (active == 0) {
    const Foldover foldover = measure_foldover(targets, map, evaluate(map, columns));
    return {columns, foldover, foldover, 0};
  }
  return Untangler(targets, faces, map, active, threads).run(columns);
}

}  // namespace neurframe
