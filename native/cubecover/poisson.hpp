// The quadratic energy of the map, sum over tets of w |S - S_target|^2 (Nieser et al. 2011, equation 5).
#pragma once

#include "cubecover/spd_solver.hpp"
#include "cubecover/targets.hpp"

namespace neurframe {

struct QuadraticEnergy {
  SparseMatrix hessian;  // over all columns of the map, both triangles, halved: energy = y^T H y - 2 y^T b
  Eigen::VectorXd right_side;
};

// relative_gradient_targets: per tet the S that the map should have; empty for the identity.
QuadraticEnergy quadratic_energy(const TetTargets& targets, const ReducedMap& map,
                                 const std::vector<Eigen::Matrix3d>& relative_gradient_targets);

// The columns that minimise the energy.  Columns from `active` on keep their value in `columns`.
Eigen::VectorXd minimise(const QuadraticEnergy& energy, const Eigen::VectorXd& columns, int active);

}  // namespace neurframe
