// Ribbons of faces that unzip a turning point.
#pragma once

#include "cubecover/line_moves.hpp"

namespace neurframe {

// Moves one after the other: each makes the edge regular that the one before made singular.
using Ribbon = std::vector<LineMove>;

// Where a singular line arrives along its axis and goes back against it, with the other valence, both parts
// can go on straight instead: the edge of the turn becomes regular by a ribbon of faces that follows the axis
// to the boundary, whose normal it is there, and whose two sides become singular.  The cheapest such ribbon
// for each of the edges next to a turning point; none where the axis leads elsewhere.
std::vector<Ribbon> unzipping_ribbons(const FieldMesh& mesh, const EdgeRings& rings);

}  // namespace neurframe
