// Which chart axis is normal to the boundary, face by face, and how many quarter turns the solid fills at
// each boundary edge.
#pragma once

#include "cubecover/matching.hpp"

namespace neurframe {

struct SignedAxis {
  int axis = -1;
  int sign = 1;
  bool operator==(const SignedAxis&) const = default;
};

// The axis in the chart that u -> R u leads to.
SignedAxis carried(OctahedralRotation rotation, SignedAxis axis);

// The frame's axis as a direction in space.
Eigen::Vector3d direction_of(const Eigen::Matrix3d& frame, SignedAxis axis);

// An edge of the boundary surface: its ring runs from begin_face to end_face through the solid.
struct BoundaryEdge {
  EdgeKey vertices;  // in the order of the ring
  int ring;
  int begin_face;
  int end_face;
  OctahedralRotation across;  // from the chart behind begin_face to the one behind end_face
};

std::vector<BoundaryEdge> find_boundary_edges(const FieldMesh& mesh, const EdgeRings& rings);

// Per half-face: the axis along the outward normal; axis -1 inside.  Within a patch of the boundary that
// features surround, the axis is decided once, at the best aligned face, and carried from face to face by the
// matchings: deciding it per face contradicts itself near blunt features (Nieser et al. 2011, section 6).
std::vector<SignedAxis> boundary_axes(const FieldMesh& mesh, const std::vector<BoundaryEdge>& edges);

// The quarter turns of the solid at the edge that the field says: 1 convex, 2 flat, 3 concave; 0 and 4 have
// no room or too much; -1 when the two normals' axes turn about one that is not along the edge.
int sector_quarter_turns(const FieldMesh& mesh, const BoundaryEdge& edge,
                         const std::vector<SignedAxis>& axes);

// The chart axis along a feature, in the chart behind begin_face.  Where the boundary bends, it is the one
// that is normal to neither side: the frame itself may lie 45 degrees off, in a tet at a corner of 45 degrees
// that is aligned with the other feature there.
int tangent_axis(const FieldMesh& mesh, const BoundaryEdge& edge, const std::vector<SignedAxis>& axes);

}  // namespace neurframe
