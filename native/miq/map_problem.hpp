// The combinatorial half of the way: from the crosses of the input to refined mesh, matchings, cut and
// unknowns.
#pragma once

#include <array>
#include <vector>

#include "core/json.hpp"
#include "core/triangle_mesh.hpp"
#include "miq/cross_surface.hpp"
#include "miq/cut_graph.hpp"
#include "miq/feature_lines.hpp"
#include "miq/matching.hpp"
#include "miq/prepare.hpp"
#include "miq/reduced_variables.hpp"

namespace neurframe {

struct MapProblem {
  CrossSurface surface;
  std::vector<Sector> sectors;
  std::vector<char> singular;  // per vertex: must be an integer point
  CutGraph graph;
  ReducedVariables variables;
};

struct PreparationOptions {
  double longest_edge = 3;  // triangles with longer edges (in target edge lengths) are split
  double dipole_reach = 3;  // target edge lengths up to which opposite singularities cancel
  // target edge lengths up to which quarter turns are traded; farther ones make the field smoother still, but
  // the sizes of the cells less equal
  double trade_reach = 15;
  // energy that a singular vertex less may cost; a quarter turn has pi/8 of it per factor e in radius
  double singularity_penalty = 0.3;
  double feature_clearance = 1;  // target edge lengths that singularities keep from features
  int closed_minimum = 3;        // least quarter turns around an interior vertex
  FeatureOptions features;
};

// Raises InputError for a surface or crosses that cannot be used.
CrossSurface build_cross_surface(const TriangleMesh& mesh, const std::vector<std::array<double, 6>>& crosses,
                                 const std::vector<double>& sizing, Json& statistics);

// Marks features, refines, matches, mends and combs, cuts and substitutes.  A feature edge whose two ends
// would be one point of the map whatever the unknowns is released and the work done again.  Raises StageError
// where the singularities contradict the Euler characteristic, or no integers fit.
MapProblem prepare_map_problem(CrossSurface surface, const PreparationOptions& options, double edge_length,
                               Json& statistics);

}  // namespace neurframe
