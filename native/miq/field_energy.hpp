// The Dirichlet energy that the smoothest field with given matchings has, and what moving a turn changes in
// it.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <vector>

#include "miq/field_topology.hpp"

namespace neurframe {

// Energy sum over edges off the features of (edge length / dual edge length) * (residual rotation)^2, least
// over all crosses with these matchings; those beside features are held (Bommes et al. 2009, equation 3,
// integers fixed).  The matrix does not depend on the matchings: one factorisation serves all of them, and
// the change by a shift is exact without solving for the field.
class FieldEnergy {
 public:
  // relaxes a copy of the crosses; the surface itself stays as it is.  Raises StageError where the matrix is
  // singular.
  explicit FieldEnergy(const CrossSurface& surface);

  // The part of the change that depends on the path alone: the energy of a shift in a field without
  // residuals.
  double own_energy(const ShiftPath& path) const;

  // Energy after shifting the matchings along the path by `turns` (1 or -1) minus energy before.
  double change(const ShiftPath& path, int turns, double own_energy) const;

  // Shifts the matchings and relaxes the field.
  void shift(const ShiftPath& path, int turns);

 private:
  void relax();
  // what the shift adds to the right side of the smoothness system
  Eigen::VectorXd jump(const ShiftPath& path, int turns) const;

  const CrossSurface& surface_;
  std::vector<int> number_;     // per triangle: its unknown, -1 where the cross is held
  std::vector<double> weight_;  // per half-edge, 0 where there is no residual
  std::vector<double>
      residual_;  // per half-edge: rotation left in the relaxed field, not reduced to (-pi, pi]
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor_;
};

}  // namespace neurframe
