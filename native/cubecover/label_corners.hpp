// The vertices of the boundary where labels meet, and what a polycube makes of them.
#pragma once

#include "cubecover/borders.hpp"

namespace neurframe {

// A vertex where three borders or more meet.
struct LabelCorner {
  // The faces round the vertex, as half-faces, by label: one fan for each run of faces of one label,
  // counter-clockwise as seen from outside.
  struct Fan {
    std::vector<int> half_faces;
    double angle = 0;             // radians
    int least_quarter_turns = 0;  // the angle of its image
    int most_quarter_turns = 0;
  };
  int vertex;
  std::vector<Fan> fans;
  bool is_possible = false;  // whether labels follow each other like this at any vertex of a polycube
  double stretch = 0;        // radians: its angles less those of the most similar such vertex, summed
};

// A vertex of a polycube is the common corner of one to seven octants, whose boundary is a disc: what cannot
// be found there, as labels and convex or concave edges that follow each other, is impossible.  Two patches
// of one label that meet in a vertex, with a convex border and a concave one between them, are: the wedge
// between them has no width there.  A border that hardly bends may be either.
std::vector<LabelCorner> find_label_corners(const FieldMesh& mesh, const std::vector<BoundaryEdge>& edges,
                                            const std::vector<SignedAxis>& labels);

}  // namespace neurframe
