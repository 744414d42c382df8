#include "cubecover/spd_solver.hpp"

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCholesky>
#include <utility>

namespace neurframe {

namespace {

// The fill-in of a 3D mesh grows faster than the iterations: at 83,000 tets a factorisation takes 11 CPU s.
constexpr Eigen::Index always_factored = 20000;  // rows
constexpr Eigen::Index most_factored = 60000;    // ... for a matrix that many systems have
constexpr int many_systems = 10;

using ConjugateGradient =
    Eigen::ConjugateGradient<SparseMatrix, Eigen::Lower, Eigen::IncompleteCholesky<double>>;

}  // namespace

struct SpdSolver::Implementation {
  SparseMatrix matrix;
  Eigen::SimplicialLDLT<SparseMatrix> factorisation;
  ConjugateGradient iteration;
  bool factored = false;
};

SpdSolver::SpdSolver(SparseMatrix lower, Eigen::Index systems)
    : implementation_(std::make_unique<Implementation>()) {
  Implementation& self = *implementation_;
  self.matrix = std::move(lower);
  self.factored = self.matrix.rows() <= (systems < many_systems ? always_factored : most_factored);
  if (self.matrix.rows() == 0) return;
  if (self.factored) {
    self.factorisation.compute(self.matrix);
    self.factored =
        self.factorisation.info() == Eigen::Success && self.factorisation.vectorD().minCoeff() > 0;
  }
  if (self.factored) return;
  self.iteration.setTolerance(1e-10);
  self.iteration.compute(self.matrix);
}

SpdSolver::~SpdSolver() = default;

Eigen::VectorXd SpdSolver::solve(const Eigen::VectorXd& right_side) const {
  if (right_side.size() == 0) return right_side;
  if (implementation_->factored) return implementation_->factorisation.solve(right_side);
  return implementation_->iteration.solve(right_side);
}

Eigen::VectorXd solve_loosely(const SparseMatrix& lower, const Eigen::VectorXd& right_side,
                              double tolerance) {
  const SparseMatrix full = lower.selfadjointView<Eigen::Lower>();
  Eigen::ConjugateGradient<SparseMatrix, Eigen::Lower | Eigen::Upper> iteration;
  iteration.setTolerance(tolerance);
  iteration.compute(full);
  return iteration.solve(right_side);
}

}  // namespace neurframe
