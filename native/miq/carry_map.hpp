// A valid seamless map taken to other integers, injective all the way.
#pragma once

#include <Eigen/Core>

#include "miq/map_system.hpp"
#include "miq/untangle.hpp"

namespace neurframe {

// Moves `real` and `integer`, a map without folds, to the integers `goal`: each step goes half of the way on
// which the first triangle collapses, then the map is relaxed with the integers held.  As no triangle ever
// turns over, no vertex is wound twice at the end if none was at the start, which untangling a map that
// jumped to its integers cannot promise.  `held_system` frees the real variables only.  False, and a map in
// between, where the steps become too small or their number too large.
bool carry_map(MapSystem& held_system, const TriangleShapes& shapes, const PoissonSystem& poisson,
               const UntangleOptions& relaxation, const Eigen::VectorXd& goal, Eigen::VectorXd& real,
               Eigen::VectorXd& integer);

}  // namespace neurframe
