// The whole way from crosses on triangles to a checked integer-grid map.
#pragma once

#include <string>
#include <vector>

#include "core/json.hpp"
#include "core/quad_map_io.hpp"
#include "core/triangle_mesh.hpp"
#include "miq/fixed_point_map.hpp"
#include "miq/integer_grid.hpp"
#include "miq/map_problem.hpp"
#include "miq/seamless_map.hpp"

namespace neurframe {

struct ParametrizeOptions {
  double edge_length = 0;  // target, in input units; not used with a number of faces
  PreparationOptions preparation;
  SeamlessOptions seamless;
  IntegerGridOptions integer_grid;
};

// A vertex whose quarter turns are not those of a regular one, or a feature sector with other than two.
struct SingularPoint {
  Point3 position;
  int quarter_turns;
  bool on_feature;
};

struct Parametrization {
  QuadMap map;
  std::vector<int> source;  // input triangle of each triangle of the map
  std::vector<SingularPoint> singular;
  MapCheck check;
  bool complete = false;  // valid, and the extraction finds every quad
};

// crosses: per triangle two tangent vectors (6 numbers); sizing: per vertex a factor on the edge length, or
// empty. Raises InputError for input that cannot be used and StageError where a step fails; statistics are
// filled as the steps go.
Parametrization parametrize(const TriangleMesh& mesh, const std::vector<std::array<double, 6>>& crosses,
                            const std::vector<double>& sizing, const ParametrizeOptions& options,
                            Json& statistics);

}  // namespace neurframe
