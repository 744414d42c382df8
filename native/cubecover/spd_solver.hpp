// Sparse symmetric positive definite systems.
#pragma once

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <memory>

namespace neurframe {

using SparseMatrix = Eigen::SparseMatrix<double>;

// Solves with a Cholesky factorisation while that is cheap for so many right sides, with conjugate gradients
// otherwise, and where rounding makes the matrix indefinite, as flat tets do whose weights differ by the
// precision of a double.  Only the lower triangle of the matrix is read.
class SpdSolver {
 public:
  SpdSolver(SparseMatrix lower, Eigen::Index systems);
  ~SpdSolver();

  Eigen::VectorXd solve(const Eigen::VectorXd& right_side) const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

// An approximate solution with relative residual `tolerance`, by conjugate gradients with a diagonal
// preconditioner. For the Newton steps on 12,000 tets: 0.02 s, against 0.1 s of a factorisation and 0.3 s of
// an incomplete one.
Eigen::VectorXd solve_loosely(const SparseMatrix& lower, const Eigen::VectorXd& right_side, double tolerance);

}  // namespace neurframe
