// The map on the fixed-point lattice, and its exact check.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/fixed_point.hpp"
#include "core/quad_map_io.hpp"
#include "miq/cross_surface.hpp"
#include "miq/matching.hpp"
#include "miq/reduced_variables.hpp"

namespace neurframe {

struct FixedPointMap {
  int fraction_bits = 0;
  std::vector<Vector2<Fixed>> corners;  // per corner
};

// Rounds the variables to the lattice and substitutes: seams, features and singular vertices hold exactly,
// because the substitution only adds and negates.  Integer variables that are not whole yet give the exact
// seamless map.  Raises StageError if the map has too many cells for the lattice.
FixedPointMap fixed_point_map(const ReducedVariables& variables, const Eigen::VectorXd& real,
                              const Eigen::VectorXd& integer);

struct MapCheck {
  std::vector<int> folded;     // triangles with exact determinant <= 0
  std::vector<int> overwound;  // vertices whose sectors have not the expected quarter turns in the map
  double cells = 0;            // parametric area
  bool valid() const { return folded.empty() && overwound.empty(); }
  size_t defects() const { return folded.size() + overwound.size(); }
};

// Exact: the determinant of every triangle, and per sector the sum over its corners of quadrants passed.
MapCheck check_map(const CrossSurface& surface, const std::vector<Sector>& sectors, const FixedPointMap& map);

QuadMap quad_map(const CrossSurface& surface, const ReducedVariables& variables, const CutGraph& graph,
                 const FixedPointMap& map, const Eigen::VectorXd& integer);

}  // namespace neurframe
