// From a mesh with frames to one that can carry a map: splits, alignment, matchings, constraints.
#pragma once

#include "cubecover/defects.hpp"

namespace neurframe {

// How to prepare.  No setting suits every field, so several are judged by the defects that they leave.
struct Preparation {
  double longest_edge = 0;  // edges are halved down to this first; 0 for no limit
  int smoothing_sweeps = 0;
  bool straighten = true;
};

struct PreparationScore {
  Preparation preparation;
  int tets;
  double defect_score;
};

struct PreparedField {
  CombedField field;
  Elimination elimination;
  ReducedMap map;
  std::vector<Defect> defects;
  Preparation preparation;
  std::vector<PreparationScore> judged;  // what best_preparation chose from, in the order of trying
};

PreparedField prepare(FieldMesh mesh, const Preparation& preparation);

// The preparation with the lowest defect score: the mesh as it is, smoothed, without straightened lines, or,
// where that halves the score, with edges bounded by their mean length.  The first one without defects ends
// the search.
PreparedField best_preparation(const FieldMesh& mesh);

// Halves the edges of the tets that failed, so that the next try has room there.
FieldMesh refined_around(const FieldMesh& mesh, const std::vector<int>& tets);

}  // namespace neurframe
