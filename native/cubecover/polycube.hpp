// The field of last resort: one chart for the whole solid, whose boundary faces take its six directions.
#pragma once

#include "cubecover/field_mesh.hpp"

namespace neurframe {

struct PolycubeLabels {
  double compactness = 0;      // of the labels; 0 for no polycube
  int rounds = 1;              // of labels and frames in turn: with more, labels follow a bend
  bool inner_features = true;  // features between faces of one label are kept as lines of the grid
};

// The mesh with frames that turn smoothly from tet to tet without singular lines, matchings that are all the
// identity, and the borders of the labels among its features: what `comb_field` needs to make it the field of
// a polycube map (Gregson et al. 2011; Livesu et al. 2013; Protais et al. 2022).  The chart's axes are those
// that the frames of the boundary layer have in common; labels and frames are found in turn, so that a bent
// part keeps its labels along the bend.
FieldMesh polycube_field(FieldMesh mesh, const PolycubeLabels& options);

}  // namespace neurframe
