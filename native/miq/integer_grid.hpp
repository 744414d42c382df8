// From a seamless map to an integer-grid map: integers, injectivity, fixed-point lattice, verification.
#pragma once

#include <Eigen/Core>

#include "core/json.hpp"
#include "miq/critical_triangulation.hpp"
#include "miq/fixed_point_map.hpp"
#include "miq/map_system.hpp"
#include "miq/quantization.hpp"
#include "miq/seamless_map.hpp"
#include "miq/trial_extraction.hpp"

namespace neurframe {

struct IntegerGridOptions {
  int target_faces = 0;           // if positive, the edge length is corrected until there are as many cells
  double separation_reach = 1.5;  // cells up to which rows keep critical vertices apart from the start
  int most_row_rounds = 30;
  // Factor on the edge length where no integers, or no injective map, are found.  The first steps are small:
  // a slightly different size rounds differently, and often that is enough.
  double first_refinement = 0.96;
  double refinement = 0.8;  // the smallest factor
  int most_refinements = 8;
  int threads = 1;
};

// The integers and the map on the lattice that they lead to.
struct IntegerGrid {
  Eigen::VectorXd integer, real;
  FixedPointMap fixed;
  MapCheck check;
  LostQuads lost;
  double edge_length_factor = 1;  // on the edge length asked for
  bool complete() const { return check.valid() && lost.count == 0; }
};

// Rounds at the edge length asked for and verifies; refines where that fails.  A valid seamless map has
// integers at some edge length, because rounding moves less and less of it.  Changes the scale of `seamless`.
IntegerGrid solve_integer_grid(const MapProblem& problem, SeamlessMap& seamless,
                               const IntegerGridOptions& options, Json& statistics);

}  // namespace neurframe
