// Frames smoothed as a whole: diffusion and projection in turn, the boundary layer held along the boundary.
#pragma once

#include "cubecover/alignment.hpp"

namespace neurframe {

struct FrameDiffusion {
  int rounds = 0;
  double first_stiffness = 0.004;  // 1 / (length of a diffusion step), in units of the mean degree of the
  double last_stiffness = 0.25;    // dual graph: diffusion over about 15 and over 2 tets
};

// The scheme of Merriman, Bence and Osher on the octahedral variety (Palmer et al. 2020, section 5.2): an
// implicit step of the heat flow of the coefficients on the dual graph, then the nearest frame of every tet,
// with shorter and shorter steps.  Frames of aligned tets only turn about their fixed axis, or not at all.
// What comes out is a field of true frames whose singular lines are short and keep off the boundary.
void diffuse_frames(FieldMesh& mesh, const std::vector<Alignment>& alignments,
                    const FrameDiffusion& diffusion);

}  // namespace neurframe
