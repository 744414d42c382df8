// Integers for the integer variables: near the real optimum in the energy, subject to separation.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "miq/critical_triangulation.hpp"

namespace neurframe {

struct Quantization {
  Eigen::VectorXd values;  // whole numbers
  double energy = 0;       // (values - target)^T S (values - target)
  int violated_rows = 0;
  int local_moves = 0;
};

// Minimises (m - target)^T S (m - target) over integers m with every row at least 1
// (a row's constant counts): the quadratic programme
// with rows is solved by Hildreth's method, the variable whose rounding costs least energy is fixed, and so
// on, each time with the others at their conditional optimum (a rank-1 update of S^-1); then moves of one and
// of two variables descend further.  S must be positive definite.
Quantization quantize(const Eigen::MatrixXd& schur, const Eigen::VectorXd& target,
                      const std::vector<SeparationRow>& rows);

// Pairwise (Seysen-like) reduction: a unimodular basis B of the integers, near to orthogonal in S, so that
// single moves are local changes of the map.  Columns are basis vectors.
Eigen::MatrixXd reduced_basis(const Eigen::MatrixXd& schur);

}  // namespace neurframe
