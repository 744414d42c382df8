// Turns the frames of the first layer of tets to the boundary.
#pragma once

#include <optional>

#include "cubecover/field_mesh.hpp"

namespace neurframe {

using Direction = std::optional<Eigen::Vector3d>;

// Directions, of unit length and orthogonal to each other, that axes of a tet's frame should have.
struct Alignment {
  Direction first;
  Direction second;
};

// Every tet that touches the boundary gets one axis along the boundary's normal there, or along the feature
// edge that it touches, and a second one where a tet with a boundary face has a feature edge.  With only the
// tets behind boundary faces aligned, singular lines slide onto the surface and touch it tangentially; the
// tets between a line and the plane beside it then have no volume for any choice of the unknowns.  A tet
// between differently directed patches is not aligned.
std::vector<Alignment> boundary_alignments(const FieldMesh& mesh);

// The frame turned by the smallest angles that align it: its axis nearest to the first direction, and then,
// about that one, another axis to the second.
Eigen::Matrix3d aligned_frame(const Eigen::Matrix3d& frame, const Alignment& alignment);

void align_boundary_layer(FieldMesh& mesh);

}  // namespace neurframe
