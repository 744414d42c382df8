// Foldover-free optimisation of the map over the reduced variables.
#pragma once

#include <Eigen/Core>
#include <functional>

#include "miq/map_system.hpp"

namespace neurframe {

struct UntangleOptions {
  int most_iterations = 60;
  int patience = 15;  // iterations without fewer folds before giving up
  int polish = 4;     // iterations after the last fold is gone
  int threads = 1;
  double determinant_weight = 1;  // of the area term against the shape term
  double alignment_weight = 0.1;  // of |J - I|^2, which keeps the map near the field
};

struct UntangleResult {
  int iterations = 0;
  int folds_before = 0;
  int folds_after = 0;
  double energy = 0;
};

// Minimises sum of weight * ( |J|^2 / chi(det J) + w (det J^2 + 1) / chi(det J) + a |J - I|^2 ) with
// chi(D) = (D + sqrt(eps^2 + D^2)) / 2, eps -> 0 as the folds go (Garanzha et al. 2021, "Foldover-free maps
// in 50 lines of code"), by Newton's method with the triangle Hessians projected to positive semidefinite and
// a line search.  Changes `real`, and `integer` where the system frees the integers.
UntangleResult untangle(MapSystem& system, const TriangleShapes& shapes, const UntangleOptions& options,
                        Eigen::VectorXd& real, Eigen::VectorXd& integer);

}  // namespace neurframe
