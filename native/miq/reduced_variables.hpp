// The unknowns of a seamless integer-grid map, with every seam, feature and singularity condition
// substituted.
#pragma once

#include <utility>
#include <vector>

#include "miq/cross_surface.hpp"
#include "miq/cut_graph.hpp"

namespace neurframe {

// One parameter of one vertex sector: sign * real[index] + sum of coefficient * integer[index], exactly.
struct ReducedCoordinate {
  int real = -1;  // -1: integers alone
  int sign = 1;
  std::vector<std::pair<int, int>> integers;  // (integer variable, coefficient)
};

// uv on the right of a seam half-edge = quarter turns of uv on its left + translation (in integer variables)
struct SeamTransition {
  int turns = 0;
  std::vector<std::pair<int, int>> translation[2];
};

struct ReducedVariables {
  std::vector<int> sector;                     // per corner
  std::vector<ReducedCoordinate> coordinates;  // u of sector s at 2 s, v at 2 s + 1
  std::vector<int> branch_of;  // per half-edge: seam branch that it belongs to on its left, or -1
  std::vector<SeamTransition> transitions;  // per branch
  int real_count = 0;
  int integer_count = 0;
};

// Substitutes, by signed union-find with exact integer offsets, per seam branch a transition with the
// matching's rotation and an unknown integer translation, per feature edge one constant integer parameter,
// per singular vertex an integer point, and per component one point that fixes the translation of the whole.
// Bommes et al. 2009, section 5.  Raises StageError if no integers satisfy the conditions.
ReducedVariables reduce_variables(const CrossSurface& surface, const CutGraph& graph,
                                  const std::vector<char>& singular);

// 0 if the feature edge h keeps u constant in the chart of its triangle, 1 if it keeps v constant
int constant_parameter(const CrossSurface& surface, int h);

}  // namespace neurframe
