// Splits without which no piecewise linear integer-grid map can exist on the mesh, whatever the field
// (Liu and Bommes 2023, section on refinement; notes of DESIGN.md on tet meshes that can carry a map).
#pragma once

#include "cubecover/field_mesh.hpp"

namespace neurframe {

// Each of these returns how many simplices it split.

// Afterwards no interior edge or face has all its vertices on the boundary, and no tet has two boundary
// faces: all four vertices of such a simplex may lie on one integer plane, which leaves the tets there no
// volume.
int separate_boundary(FieldMesh& mesh);

// Afterwards every edge between two vertices of singular or feature edges is such an edge itself, and no face
// has three of them: each singular line has room of its own.
int separate_critical_edges(FieldMesh& mesh);

}  // namespace neurframe
