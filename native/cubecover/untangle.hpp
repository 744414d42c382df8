// Foldover-free optimisation of the map over its free columns (Garanzha et al. 2021), by Newton's method.
#pragma once

#include "cubecover/face_targets.hpp"

namespace neurframe {

struct UntangleResult {
  Eigen::VectorXd columns;
  Foldover before;
  Foldover after;
  int iterations = 0;
};

// Minimises the barrier energy over the columns [0, active); the others keep their values.  Stops when
// nothing is folded and the energy has settled, or when six iterations brought less than a tenth fewer folded
// tets and turned faces:
// what does not unfold then has a defect in the field, which no optimiser removes.
UntangleResult untangle(const TetTargets& targets, const std::vector<FaceTarget>& faces,
                        const ReducedMap& map, const Eigen::VectorXd& columns, int active, int threads);

}  // namespace neurframe
