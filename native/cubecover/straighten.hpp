// Shorter and straighter singular lines by changing matchings one face at a time (cf. Liu and Bommes 2023).
#pragma once

#include "cubecover/field_mesh.hpp"

namespace neurframe {

// For every interior face with a singular edge and at most one (smooth) boundary vertex, the matching of the
// 24 that minimises the cost of its three edges (length, more for edges off their axis, much more for
// compound ones) plus its own mismatch; until no face improves.  The best matching of each face alone makes
// lines zigzag, and a zigzag turns off its axis.  Nearer to the boundary faces stay as they are: changing
// those did harm (measured, notes). Returns how many matchings changed.
int straighten_singular_lines(FieldMesh& mesh);

}  // namespace neurframe
