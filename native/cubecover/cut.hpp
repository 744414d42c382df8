// Combing and the cut: charts that agree across most faces, and the faces where they do not.
#pragma once

#include "cubecover/field_mesh.hpp"

namespace neurframe {

// Re-expresses the frames, one chart change per tet, so that the matchings across a spanning tree of the dual
// graph are the identity (Nieser et al. 2011, section 5).  Returns, per half-face, whether it belongs to the
// cut: not on the tree and not forced open by a regular edge all of whose other faces are open.
std::vector<char> comb_and_cut(FieldMesh& mesh);

struct CornerClasses {
  std::vector<std::array<int, 4>> of_corner;  // per tet and corner
  std::vector<int> vertex;                    // per class
  int count() const { return static_cast<int>(vertex.size()); }
};

// Corners of one vertex that are joined by faces outside the cut share one parameter value.
CornerClasses corner_classes(const FieldMesh& mesh, const std::vector<char>& cut);

// Connected component of each tet.
std::vector<int> components(const FieldMesh& mesh);

}  // namespace neurframe
