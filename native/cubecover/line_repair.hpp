// Repairs of a prepared field by moves of its singular lines, where their frames left defects.
#pragma once

#include "cubecover/preparation.hpp"

namespace neurframe {

// The field after the moves round its defects that lower the defect score, and with lines parted from nodes
// that no hex mesh has.
PreparedField with_line_repairs(PreparedField prepared);

// A field without defects whose map is not valid, with lines parted from its nodes, first from those that no
// hex mesh has: where two only touch, their valences do not tell.
PreparedField with_lines_parted(FieldMesh mesh, const Preparation& preparation);

}  // namespace neurframe
