// Frames that follow matchings.
#pragma once

#include "cubecover/alignment.hpp"

namespace neurframe {

// Where singular lines were moved the frames still turn round their old places.  Those near the faces are
// averaged with their neighbours across the matchings, which stay, and then projected.
void settle_frames(FieldMesh& mesh, const std::vector<Alignment>& alignments,
                   const std::vector<int>& half_faces);

}  // namespace neurframe
