// Borders between labels that no polycube has: convex along one part and concave along the next.
#pragma once

#include "cubecover/boundary_axes.hpp"

namespace neurframe {

// A border of two patches of labels, between two corners, along which the solid bends both ways.  Its image
// is one straight edge of the polycube, which is convex or concave; so a step that fades into a plane, where
// the two parts meet, leaves its patch no width.
struct TurningBorder {
  std::array<int, 2> axes;  // of the two patches
  // the half-faces beside the convex part on either side, then those beside the concave one
  std::array<std::vector<int>, 4> parts;
};

std::vector<TurningBorder> find_turning_borders(const FieldMesh& mesh, const std::vector<BoundaryEdge>& edges,
                                                const std::vector<SignedAxis>& labels);

}  // namespace neurframe
