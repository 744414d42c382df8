// Local stiffening: where the least-squares map folds or winds twice, the weights of the triangles around are
// raised and the map is solved again (Bommes et al. 2009, section 5.3).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "miq/fixed_point_map.hpp"
#include "miq/map_problem.hpp"
#include "miq/map_system.hpp"

namespace neurframe {

struct StiffeningResult {
  int rounds = 0;
  int defects_before = 0;  // folded triangles and overwound vertices
  int defects_after = 0;
};

// Solves the map for its free variables and stiffens until nothing folds or winds twice, at most
// `most_rounds` times; keeps the solution with the fewest defects.  `stiffness` holds the weight factors of
// that solution, one per triangle.  A fold is a topological error of the map near a singularity more often
// than a geometric one: the stiffened map follows the field there, which has the right number of quarter
// turns, where an untangler alone might wind twice.
StiffeningResult solve_with_stiffening(MapSystem& system, const MapProblem& problem,
                                       const TriangleShapes& shapes, int most_rounds,
                                       std::vector<double>& stiffness, Eigen::VectorXd& real,
                                       Eigen::VectorXd& integer);

// the folded triangles and those around overwound vertices
std::vector<int> defective_triangles(const MapProblem& problem, const MapCheck& check);

// raises the stiffness around these triangles, threefold on them and less on the rings around
void stiffen(const CrossSurface& surface, const std::vector<int>& triangles, std::vector<double>& stiffness);

}  // namespace neurframe
