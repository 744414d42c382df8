// What keeps a field from carrying an integer-grid map, found before anything is solved.
#pragma once

#include "cubecover/constraints.hpp"
#include "cubecover/reduced_map.hpp"

namespace neurframe {

struct Defect {
  enum class Kind {
    compound_edge,    // turns about a diagonal of the cube: no hex mesh has such an edge
    off_axis_edge,    // the frame's axis is more than 54.7 degrees off the edge: another axis is nearer
    turning_point,    // a singular line changes its axis in passing a vertex
    grazing_end,      // a singular line leaves the boundary along a part of it
    empty_sector,     // no quarter turn of the solid is left between two boundary faces
    overfull_sector,  // four quarter turns between two boundary faces
    crooked_sector,   // the boundary turns about an axis that is not along the edge
    empty_corner,     // no quarter turn is left between two features of one part of the boundary
    cusp,             // the same where they leave their vertex within 30 degrees: the shape has no room
    impossible_node,  // no vertex of a hex mesh has edges of such valences
    degenerate_tet    // no volume for any choice of the free unknowns
  };
  Kind kind;
  Eigen::Vector3d place;
};

const char* name_of(Defect::Kind kind);

// What a defect of this kind adds to the score.
double weight_of(Defect::Kind kind);

// How far the field is from carrying a map: 0 without defects; kinds that no solver survives weigh most.
double defect_score(const std::vector<Defect>& defects);

// Nodes whose edges are all of valence 3 or 5, in numbers that no vertex of a hex mesh has.
std::vector<int> impossible_nodes(const SingularGraph& graph);

std::vector<Defect> field_defects(const CombedField& field);

// Tets whose determinant is zero for two choices of random values of the free unknowns, in exact arithmetic:
// they are so for all.  Once may be chance: two unknowns get one value in some tet of a hundred thousand.
std::vector<Defect> degenerate_tets(const CombedField& field, const ReducedMap& map);

}  // namespace neurframe
