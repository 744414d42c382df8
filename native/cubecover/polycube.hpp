// The field of last resort: one chart for the whole solid, whose boundary faces take its six directions.
#pragma once

#include "cubecover/surface_labels.hpp"

namespace neurframe {

// The mesh with frames that turn smoothly from tet to tet without singular lines, matchings that are all the
// identity, and the borders of the labels among its features: what `comb_field` needs to make it the field of
// a polycube map (Gregson et al. 2011; Livesu et al. 2013; Protais et al. 2022).  The chart's axes are those
// that the frames of the boundary layer have in common.
FieldMesh polycube_field(FieldMesh mesh, const LabelCosts& costs);

// The same without the features between faces of one label, which then need not be lines of the grid.
FieldMesh without_inner_features(FieldMesh polycube);

// The same without those inner features that reach one of the tets, each up to where it meets others.
FieldMesh without_inner_features_at(FieldMesh polycube, const std::vector<int>& tets);

}  // namespace neurframe
