// Repairs of a prepared field by moves of its singular lines, where their frames left defects.
#pragma once

#include "cubecover/preparation.hpp"

namespace neurframe {

// The field after the moves round its defects that lower the defect score.
PreparedField with_line_repairs(PreparedField prepared);

}  // namespace neurframe
