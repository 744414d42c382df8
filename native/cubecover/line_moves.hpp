// Moves of singular lines across single faces.
#pragma once

#include "cubecover/matching.hpp"

namespace neurframe {

// A face beside a singular edge, and the edge, which becomes regular: the face's two other edges take over
// its holonomy.
struct LineMove {
  int half_face;
  int ring;  // of the edge, which the half-face is in
};

// The moves of all singular edges whose middle is in the ball.
std::vector<LineMove> line_moves(const FieldMesh& mesh, const EdgeRings& rings, const Eigen::Vector3d& center,
                                 double radius);

void move_line(FieldMesh& mesh, const EdgeRings& rings, const LineMove& move);

}  // namespace neurframe
