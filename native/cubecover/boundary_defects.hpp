// Defects of a field at the boundary.
#pragma once

#include "cubecover/defects.hpp"

namespace neurframe {

void add_boundary_defects(const CombedField& field, std::vector<Defect>& defects);

}  // namespace neurframe
