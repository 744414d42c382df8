// The whole way from crosses on triangles to a checked integer-grid map.
#pragma once

#include <string>
#include <vector>

#include "core/json.hpp"
#include "core/quad_map_io.hpp"
#include "core/triangle_mesh.hpp"
#include "miq/fixed_point_map.hpp"
#include "miq/map_problem.hpp"

namespace neurframe {

struct ParametrizeOptions {
  double edge_length = 0;         // target, in input units
  int target_faces = 0;           // if positive, overrides edge_length
  double separation_reach = 1.5;  // cells around critical vertices in which they are kept apart
  int stiffening_rounds = 10;
  int seamless_polish = 4;  // Newton steps on a seamless map that had to be stiffened
  PreparationOptions preparation;
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
};

// crosses: per triangle two tangent vectors (6 numbers); sizing: per vertex a factor on the edge length, or
// empty. Raises InputError for input that cannot be used and StageError where a step fails; statistics are
// filled as the steps go.
Parametrization parametrize(const TriangleMesh& mesh, const std::vector<std::array<double, 6>>& crosses,
                            const std::vector<double>& sizing, const ParametrizeOptions& options,
                            Json& statistics);

}  // namespace neurframe
