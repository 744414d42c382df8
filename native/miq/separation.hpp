// Inequalities between the integer variables that keep singular vertices and features apart.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "miq/cross_surface.hpp"
#include "miq/integer_combination.hpp"
#include "miq/map_system.hpp"
#include "miq/reduced_variables.hpp"

namespace neurframe {

// combination of integer variables that must be at least 1
using SeparationRow = IntegerCombination;

// What stands within `reach` cells of each singular vertex and each feature vertex, in straight sight in the
// given seamless map, must keep its side: the larger of the two parameter differences to another singular
// vertex, and the distance to a feature line that is met more across than along, are at least 1; so is every
// feature line between singular vertices.  Sight ends at features.  Without these rows rounding lets them
// collapse.
std::vector<SeparationRow> separation_rows(const CrossSurface& surface, const ReducedVariables& variables,
                                           const std::vector<char>& singular, const MapSystem& system,
                                           const Eigen::VectorXd& real, const Eigen::VectorXd& integer,
                                           double reach);

}  // namespace neurframe
