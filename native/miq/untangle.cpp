#include "miq/untangle.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel.hpp"

namespace neurframe {
namespace {

using Matrix66 = Eigen::Matrix<double, 6, 6>;

double determinant(const Eigen::Vector4d& jacobian) {
  return jacobian[0] * jacobian[3] - jacobian[1] * jacobian[2];
}

Eigen::Vector4d cofactors(const Eigen::Vector4d& j) {
  return {j[3], -j[2], -j[1], j[0]};
}

// Energy density as shape(|J|^2) / chi(D) + w (D^2 + 1) / chi(D), with derivatives in D.
struct Barrier {
  double p, p1, p2;  // 1 / chi and its derivatives
  double q, q1, q2;  // (D^2 + 1) / chi and its derivatives
};

Barrier barrier_at(double d, double epsilon) {
  const double root = std::sqrt(epsilon * epsilon + d * d);
  // for D < 0 the sum cancels: use eps^2 / (root - D)
  const double chi = d > 0 ? (d + root) / 2 : epsilon * epsilon / (2 * (root - d));
  const double chi1 = chi / root;
  const double chi2 = epsilon * epsilon / (2 * root * root * root);
  Barrier out{};
  out.p = 1 / chi;
  out.p1 = -chi1 / (chi * chi);
  out.p2 = -chi2 / (chi * chi) + 2 * chi1 * chi1 / (chi * chi * chi);
  const double n = d * d + 1;
  out.q = n * out.p;
  out.q1 = 2 * d * out.p + n * out.p1;
  out.q2 = 2 * out.p + 4 * d * out.p1 + n * out.p2;
  return out;
}

class FoldoverEnergy {
 public:
  FoldoverEnergy(MapSystem& system, const TriangleShapes& shapes, const UntangleOptions& options)
      : system_(system),
        shapes_(shapes),
        options_(options),
        hessians_(shapes.weight.size()),
        gradients_(shapes.weight.size()) {}

  // total energy; the least determinant and the number of folds are kept beside it
  double value(const Eigen::VectorXd& real, const Eigen::VectorXd& integer, double epsilon) {
    const auto count = static_cast<int64_t>(shapes_.weight.size());
    std::vector<Part> parts(static_cast<size_t>(chunk_count(count)));
    parallel_chunks(count, options_.threads, [&](int64_t begin, int64_t end, int64_t chunk) {
      parts[static_cast<size_t>(chunk)] = part_of_value(begin, end, real, integer, epsilon);
    });
    Part whole;
    for (const Part& part : parts) {
      whole.energy += part.energy;
      whole.least_determinant = std::min(whole.least_determinant, part.least_determinant);
      whole.folds += part.folds;
    }
    least_determinant_ = whole.least_determinant;
    folds_ = whole.folds;
    return whole.energy;
  }

  // assembles gradient and projected Hessian in the system
  void linearise(const Eigen::VectorXd& real, const Eigen::VectorXd& integer, double epsilon) {
    parallel_for(static_cast<int64_t>(shapes_.weight.size()), options_.threads,
                 [&](int64_t f) { linearise_triangle(static_cast<size_t>(f), real, integer, epsilon); });
    system_.assemble(hessians_, gradients_);
  }

  double least_determinant() const { return least_determinant_; }
  int folds() const { return folds_; }

 private:
  struct Part {
    double energy = 0;
    double least_determinant = std::numeric_limits<double>::infinity();
    int folds = 0;
  };

  Part part_of_value(int64_t begin, int64_t end, const Eigen::VectorXd& real, const Eigen::VectorXd& integer,
                     double epsilon) const {
    Part part;
    for (auto f = static_cast<size_t>(begin); f < static_cast<size_t>(end); ++f) {
      const Eigen::Vector4d jacobian = jacobian_at(f, real, integer);
      const double d = determinant(jacobian);
      part.least_determinant = std::min(part.least_determinant, d);
      part.folds += d <= 0;
      const Barrier barrier = barrier_at(d, epsilon);
      part.energy +=
          weight(f) * (jacobian.squaredNorm() * barrier.p + options_.determinant_weight * barrier.q +
                       options_.alignment_weight * (jacobian - identity_).squaredNorm());
    }
    return part;
  }

  void linearise_triangle(size_t f, const Eigen::VectorXd& real, const Eigen::VectorXd& integer,
                          double epsilon) {
    const Eigen::Vector4d jacobian = jacobian_at(f, real, integer);
    const Eigen::Vector4d cofactor = cofactors(jacobian);
    const Barrier b = barrier_at(determinant(jacobian), epsilon);
    const double norm2 = jacobian.squaredNorm();
    const double slope = norm2 * b.p1 + options_.determinant_weight * b.q1;
    const double curvature = norm2 * b.p2 + options_.determinant_weight * b.q2;
    const Eigen::Vector4d gradient =
        2 * b.p * jacobian + slope * cofactor + 2 * options_.alignment_weight * (jacobian - identity_);
    Eigen::Matrix4d hessian = (2 * b.p + 2 * options_.alignment_weight) * Eigen::Matrix4d::Identity();
    hessian += 2 * b.p1 * (jacobian * cofactor.transpose() + cofactor * jacobian.transpose());
    hessian += curvature * cofactor * cofactor.transpose();
    hessian(0, 3) += slope;
    hessian(3, 0) += slope;
    hessian(1, 2) -= slope;
    hessian(2, 1) -= slope;
    project(hessian);
    hessians_[f] = weight(f) * shapes_.jacobian[f].transpose() * hessian * shapes_.jacobian[f];
    gradients_[f] = weight(f) * shapes_.jacobian[f].transpose() * gradient;
  }

  // a triangle much smaller than the mean would be free to fold for next to nothing
  double weight(size_t f) const { return std::max(shapes_.weight[f], floor_); }
  Eigen::Vector4d jacobian_at(size_t f, const Eigen::VectorXd& real, const Eigen::VectorXd& integer) const {
    return shapes_.jacobian[f] * system_.corner_parameters(static_cast<int>(f), real, integer);
  }
  static void project(Eigen::Matrix4d& hessian) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> eigen(hessian);
    if (eigen.eigenvalues()[0] > 0) return;
    const Eigen::Vector4d clamped = eigen.eigenvalues().cwiseMax(1e-9 * eigen.eigenvalues()[3]);
    hessian = eigen.eigenvectors() * clamped.asDiagonal() * eigen.eigenvectors().transpose();
  }

  MapSystem& system_;
  const TriangleShapes& shapes_;
  const UntangleOptions& options_;
  std::vector<Matrix66> hessians_;
  std::vector<Vector6> gradients_;
  const Eigen::Vector4d identity_{1, 0, 0, 1};
  double floor_ = 0.05 * Eigen::Map<const Eigen::VectorXd>(shapes_.weight.data(),
                                                           static_cast<Eigen::Index>(shapes_.weight.size()))
                             .mean();
  double least_determinant_ = 0;
  int folds_ = 0;
};

// Garanzha et al. 2021, equation for the next epsilon: faster when the energy falls fast
double next_epsilon(double epsilon, double before, double after, double least) {
  const double rate = std::max(0.1, 1 - after / before);
  if (least >= 0) return std::max(1e-9, epsilon * (1 - rate));
  const double root = std::sqrt(least * least + epsilon * epsilon);
  return std::max(1e-9, epsilon * (1 - rate * root / (std::abs(least) + root)));
}

}  // namespace

UntangleResult untangle(MapSystem& system, const TriangleShapes& shapes, const UntangleOptions& options,
                        Eigen::VectorXd& real, Eigen::VectorXd& integer) {
  FoldoverEnergy energy(system, shapes, options);
  SparseFactor factor;
  UntangleResult result;
  double epsilon = 0.2;
  double current = energy.value(real, integer, epsilon);
  result.folds_before = result.folds_after = energy.folds();
  int best = energy.folds();
  int since_best = 0;
  int clean = energy.folds() == 0 ? 1 : 0;
  if (clean) epsilon = 1e-9;
  const Eigen::Index n = real.size();
  for (; result.iterations < options.most_iterations; ++result.iterations) {
    if (since_best > options.patience || clean > options.polish || system.size() == 0) break;
    current = energy.value(real, integer, epsilon);
    energy.linearise(real, integer, epsilon);
    if (result.iterations == 0) factor.analyzePattern(system.matrix());
    factor.factorize(system.matrix());
    if (factor.info() != Eigen::Success) break;
    const Eigen::VectorXd step = -factor.solve(system.gradient());
    const double slope = step.dot(system.gradient());
    double length = 1;
    double trial = 0;
    Eigen::VectorXd trial_real;
    Eigen::VectorXd trial_integer = integer;
    for (; length > 1e-8; length /= 2) {
      trial_real = real + length * step.head(n);
      if (system.size() > n) trial_integer = integer + length * step.tail(system.size() - n);
      trial = energy.value(trial_real, trial_integer, epsilon);
      if (trial <= current + 1e-4 * length * slope) break;
    }
    if (!(length > 1e-8) || !std::isfinite(trial)) {
      if (energy.least_determinant() > 0 || epsilon <= 1e-9) break;
      ++since_best;
      epsilon = next_epsilon(epsilon, current, current, energy.least_determinant());
      continue;
    }
    real = std::move(trial_real);
    integer = std::move(trial_integer);
    ++since_best;
    if (energy.folds() < best) {
      best = energy.folds();
      since_best = 0;
    }
    if (energy.folds() == 0) ++clean;
    result.folds_after = energy.folds();
    result.energy = trial;
    epsilon = energy.folds() == 0 ? std::min(epsilon, 1e-9)
                                  : next_epsilon(epsilon, current, trial, energy.least_determinant());
  }
  return result;
}

}  // namespace neurframe
