// From a tet mesh with one frame per tet to an integer-grid map: the whole method, step by step.
#pragma once

#include <functional>
#include <string>

#include "cubecover/defects.hpp"
#include "cubecover/exact_map.hpp"
#include "cubecover/targets.hpp"

namespace neurframe {

struct ParametrizeOptions {
  double cell_length = 0;  // target edge length of the hexes, in units of the mesh
};

struct StepTime {
  std::string step;
  double cpu_seconds;
};

struct FlipCounts {  // tets without positive determinant after each step
  int poisson = 0;
  int seamless = 0;
  int rounded = 0;
  int untangled = 0;
  int exact = 0;
};

struct Parametrization {
  CombedField field;
  std::vector<Defect> defects;
  ExactMap map;
  Verification verification;
  FlipCounts flips;
  int input_tets = 0;
  int real_unknowns = 0;
  int integer_unknowns = 0;
  int basis_changes = 0;
  int separation_rows = 0;
  int violated_rows = 0;
  int seamless_iterations = 0;
  int final_iterations = 0;
  double parametric_volume = 0;  // cells
  std::vector<StepTime> times;
};

using ProgressCallback = std::function<void(double fraction, const std::string& step)>;

Parametrization parametrize(FieldMesh mesh, const ParametrizeOptions& options,
                            const ProgressCallback& progress);

}  // namespace neurframe
