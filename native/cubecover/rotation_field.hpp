// Frames without the symmetry of the cube: one chart for the whole solid.
#pragma once

#include "cubecover/boundary_axes.hpp"

namespace neurframe {

// A direction in space that one axis of a tet's chart must have.
struct AxisTarget {
  int tet;
  SignedAxis axis;
  Eigen::Vector3d direction;  // unit
};

// The smoothest rotations, the same in all tets but where the targets bend them: each axis for itself solves
// the Laplace equation on the dual graph, drawn to its targets strongly and to `background` faintly, then the
// nearest rotation is taken (the orientation field of Gregson et al. 2011, section 4).
std::vector<Eigen::Matrix3d> rotation_field(const FieldMesh& mesh, const std::vector<AxisTarget>& targets,
                                            const Eigen::Matrix3d& background);

}  // namespace neurframe
