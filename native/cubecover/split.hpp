// Conforming splits of edges, faces and tets.  Children inherit frame and matchings of their parent;
// matchings are stored, never recomputed (shared/notes: recomputing them moves singular edges).
#pragma once

#include <vector>

#include "cubecover/field_mesh.hpp"

namespace neurframe {

// A simplex to split at its centroid: 2, 3 or 4 distinct vertices of one tet.
struct SplitTarget {
  std::vector<int> vertices;
  int tet;  // one tet that has them
};

// Splits a maximal subset of the targets of which no two share a tet, in the order given, so that every split
// is judged on the original tets and the result is conforming.  Returns how many were split.
int split_independent(FieldMesh& mesh, const std::vector<SplitTarget>& targets);

}  // namespace neurframe
