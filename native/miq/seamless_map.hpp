// The real-valued seamless map that follows the crosses: what the quantisation starts from.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/json.hpp"
#include "miq/fixed_point_map.hpp"
#include "miq/map_problem.hpp"
#include "miq/map_system.hpp"
#include "miq/untangle.hpp"

namespace neurframe {

struct SeamlessOptions {
  int rounds = 2;  // of stiffening and untangling, while something is folded or wound twice
  int stiffening_rounds = 10;
  int threads = 1;
};

// The map and what the quantisation needs of it; all of it scales with the edge length.
struct SeamlessMap {
  TriangleShapes shapes;
  std::vector<double> stiffness;  // per triangle: factor on its weight
  Eigen::VectorXd real, integer;  // integers are not whole yet
  MapCheck check;

  // to edge length times factor
  void rescale(double factor);
};

// Least squares against the crosses, stiffened where it folds or winds twice (Bommes et al. 2009), then
// untangled; the result need not be valid.  Statistics get the folds of each step.
SeamlessMap solve_seamless_map(const MapProblem& problem, MapSystem& free_system, double edge_length,
                               const SeamlessOptions& options, Json& statistics);

Json untangle_json(const UntangleResult& result);

}  // namespace neurframe
