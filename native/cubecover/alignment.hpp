// Turns the frames of the first layer of tets to the boundary.
#pragma once

#include "cubecover/field_mesh.hpp"

namespace neurframe {

// Every tet that touches the boundary gets one axis along the boundary's normal there, or along the feature
// edge that it touches, and a second one where a tet with a boundary face has a feature edge.  With only the
// tets behind boundary faces aligned, singular lines slide onto the surface and touch it tangentially; the
// tets between a line and the plane beside it then have no volume for any choice of the unknowns. The frames
// turn by the smallest angle; a tet between differently directed patches keeps its frame.
void align_boundary_layer(FieldMesh& mesh);

}  // namespace neurframe
