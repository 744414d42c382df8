// The unknowns of the map and its exact linear constraints: closed seams, and integers where the hex mesh
// needs them (boundary, features, singular edges and nodes).
#pragma once

#include "cubecover/boundary_axes.hpp"
#include "cubecover/cut.hpp"
#include "cubecover/elimination.hpp"
#include "cubecover/singular_graph.hpp"

namespace neurframe {

// A mesh whose charts are combed, with everything that the constraints are read from.
struct CombedField {
  FieldMesh mesh;
  EdgeRings rings;
  std::vector<char> cut;  // per half-face
  CornerClasses classes;
  std::vector<BoundaryEdge> boundary_edges;
  std::vector<SignedAxis> boundary_axis;  // per half-face
  SingularGraph singular;
};

CombedField comb_field(FieldMesh mesh);

// Unknown 3 c + i of the elimination is coordinate i of corner class c; integers and their like come after.
Elimination constrain(const CombedField& field);

inline int coordinate_unknown(const CombedField& field, int tet, int corner, int axis) {
  return 3 * at(at(field.classes.of_corner, tet), corner) + axis;
}

}  // namespace neurframe
