// The borders between patches of labels on the boundary.
#pragma once

#include "cubecover/boundary_axes.hpp"

namespace neurframe {

struct BorderStep {
  int edge;       // index of the boundary edge
  bool forwards;  // begin_face is on the side that the first step's begin_face is on
  double bend;    // radians, positive where the solid is convex, times the length
};

// A chain of boundary edges between two labels, from a vertex where borders meet to the next one.
using Border = std::vector<BorderStep>;

// All borders but closed ones, which no other meets.
std::vector<Border> find_borders(const FieldMesh& mesh, const std::vector<BoundaryEdge>& edges,
                                 const std::vector<SignedAxis>& labels);

// A border, or a part of one, bends if its steps' bends add up to this: to 20 degrees over a mean edge.
double least_bend(const FieldMesh& mesh, const std::vector<BoundaryEdge>& edges);

double bend_of(const Border& border);

}  // namespace neurframe
