// Which of the six directions of one chart each boundary face is given: the labels of a polycube.
#pragma once

#include "cubecover/boundary_axes.hpp"

namespace neurframe {

struct LabelCosts {
  double compactness = 0;   // of the length of borders; those along sharp edges are nearly free
  double straightness = 0;  // of the length of borders across the axis that their image will follow
};

// Labels along the frames behind the faces: for each face the signed axis whose direction is near its outward
// normal, in few and compact patches.  They minimise, by alpha-expansion (Boykov, Veksler and Zabih 2001),
// the fidelity and compactness terms of Livesu et al. 2013 (PolyCut, section 4): a border between
// opposite directions, which has no place in a polycube, costs more than any other.  Patches with fewer than
// four corners cannot be rectangles; they are given up in favour of their neighbours as far as that goes.
std::vector<SignedAxis> surface_labels(const FieldMesh& mesh, const std::vector<BoundaryEdge>& edges,
                                       const LabelCosts& costs);

}  // namespace neurframe
