// A new start of the frames in a ball, for where the field has a defect.
#pragma once

#include "cubecover/frame_diffusion.hpp"

namespace neurframe {

struct LocalRestart {
  Eigen::Vector3d center;
  double radius = 0;
  double source = 0;  // in [0, 1): which frame of the ball's rim fills it
};

// Every tet whose centre is in the ball takes one frame of the rim, which is then diffused and projected with
// the rim held, so that the field inside settles anew: often without the defect, because a constant start has
// no singular line of its own.  Returns whether there was a ball with a rim.
bool restart_frames(FieldMesh& mesh, const std::vector<Alignment>& alignments, const LocalRestart& restart);

}  // namespace neurframe
