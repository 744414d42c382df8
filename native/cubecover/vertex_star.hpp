// Matchings along walks that stay in the star of a vertex.
#pragma once

#include "cubecover/matching.hpp"

namespace neurframe {

// From the chart of tet `from` to that of tet `to`, both at the vertex.  Which way the walk takes matters
// only by holonomies of the singular edges that end there.
OctahedralRotation transport_in_star(const FieldMesh& mesh, int vertex, int from, int to);

}  // namespace neurframe
