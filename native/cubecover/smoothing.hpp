// Smoothing of the frames on the split mesh.
#pragma once

#include "cubecover/field_mesh.hpp"

namespace neurframe {

// Sweeps over the tets: each frame becomes the nearest rotation to the mean of its neighbours' frames,
// matched to it and weighted with the area of the shared face over the distance of the centres; then the
// boundary layer is aligned again.  Children of a split start with their parent's frame; smoothing gives them
// the field that the finer mesh can resolve, which lets singular lines settle and keep their distance from
// the boundary.
void smooth_frames(FieldMesh& mesh, int sweeps);

}  // namespace neurframe
