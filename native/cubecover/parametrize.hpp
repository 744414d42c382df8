// From a tet mesh with one frame per tet to an integer-grid map: the whole method, step by step.
#pragma once

#include "cubecover/exact_map.hpp"
#include "cubecover/preparation.hpp"
#include "cubecover/steps.hpp"

namespace neurframe {

enum class Polycubes { never, where_needed, only };  // where_needed: where no field of frames carries a map

struct ParametrizeOptions {
  double cell_length = 0;  // target edge length of the hexes, in units of the mesh
  int retries = 2;         // more tries, on a mesh that is refined where the map is not valid
  int threads = 1;         // for the energies; the result does not depend on it
  Polycubes polycubes = Polycubes::where_needed;
  int alternative = 1;  // which of the valid maps is wanted, the best one being the first
};

struct FlipCounts {  // tets without positive determinant after each step
  int poisson = 0;
  int seamless = 0;
  int rounded = 0;
  int untangled = 0;
  int exact = 0;
};

struct Attempt {  // one map that was solved for
  Preparation preparation;
  std::size_t features;  // edges that the map had to follow
  std::size_t failures;  // folded tets, wrongly wound edges, open seams and faces off their plane
  double distortion;
};

struct Parametrization {
  CombedField field;
  std::vector<Defect> defects;
  Preparation preparation;
  std::vector<PreparationScore> preparations_judged;
  ExactMap map;
  Verification verification;
  FlipCounts flips;
  int input_tets = 0;
  std::vector<Attempt> attempts;
  int valid_maps = 0;  // that differ from each other
  int real_unknowns = 0;
  int integer_unknowns = 0;
  int basis_changes = 0;
  int separation_rows = 0;
  int violated_rows = 0;
  int seamless_iterations = 0;
  int final_iterations = 0;
  double parametric_volume = 0;  // cells
  double distortion = 0;         // mean over the volume of the foldover-free energy; 5 for cubes
  std::vector<StepTime> times;
};

// The map of one prepared field (solve_map.cpp).
Parametrization solve_map(PreparedField prepared, const ParametrizeOptions& options, Steps& steps);

// The same on its own.
Parametrization solve_prepared(PreparedField prepared, const ParametrizeOptions& options,
                               const ProgressCallback& progress);

// The best of the tries: the first valid map, or the one with the fewest folded tets and wrongly wound edges;
// or another one of the valid maps, for hexes may fail where their map does not.  Raises InputError if there
// are not so many.
Parametrization parametrize(const FieldMesh& mesh, const ParametrizeOptions& options,
                            const ProgressCallback& progress);

}  // namespace neurframe
