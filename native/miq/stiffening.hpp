// Local stiffening: where the least-squares map folds, the weights of the triangles around are raised and the
// map is solved again (Bommes et al. 2009, section 5.3).
#pragma once

#include <Eigen/Core>

#include "miq/map_system.hpp"

namespace neurframe {

struct StiffeningResult {
  int rounds = 0;
  int folds_before = 0;
  int folds_after = 0;
};

// Solves the map for its free variables and stiffens until nothing folds, at most `most_rounds` times; keeps
// the solution with the fewest folds.  `stiffness` holds the weight factors of that solution, one per
// triangle.  A fold is a topological error of the map near a singularity more often than a geometric one: the
// stiffened map follows the field there, which has the right number of quarter turns, where an untangler
// alone might wind twice.
StiffeningResult solve_with_stiffening(MapSystem& system, const CrossSurface& surface,
                                       const TriangleShapes& shapes, int most_rounds,
                                       std::vector<double>& stiffness, Eigen::VectorXd& real,
                                       Eigen::VectorXd& integer);

}  // namespace neurframe
