// Integers for the map: the point of the lattice that deforms the seamless map least and keeps things apart.
#pragma once

#include "cubecover/poisson.hpp"
#include "cubecover/separation.hpp"

namespace neurframe {

struct Quantization {
  Eigen::VectorXd integers;
  double deformation = 0;  // (m - m0)^T S (m - m0)
  int violated_rows = 0;   // separation rows that no tried integers could satisfy
};

// What is left of the energy when the reals follow the integers: S = H_mm - H_mr H_rr^-1 H_rm.
Eigen::MatrixXd schur_complement(const QuadraticEnergy& energy, int real_count);

// Minimises (m - m0)^T S (m - m0) over integers with row . m >= 1 for all rows: greedy rounding of the
// relaxed solution, most certain first and both ways where it is in doubt, then single and paired moves by
// one.
Quantization quantize(const Eigen::MatrixXd& schur, const Eigen::VectorXd& relaxed,
                      const std::vector<SeparationRow>& rows);

}  // namespace neurframe
