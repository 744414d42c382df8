// Which way singular arcs run along their axis, decided for each arc as a whole.
#pragma once

#include "cubecover/boundary_axes.hpp"
#include "cubecover/singular_graph.hpp"

namespace neurframe {

// An arc of coarse tets is jagged: a short edge may run across its axis, even a little backwards, and taken
// for itself it would be of valence 3 in an arc of valence 5, which no hex mesh has.  Per arc the
// orientations are chosen that cost least: the length that runs backwards, and a fixed part of the mean edge
// for every turn. Where an arc leaves a smooth boundary, its axis is the normal, so that end is given.  What
// turns after that turns indeed.
void orient_arcs(const FieldMesh& mesh, const std::vector<SignedAxis>& boundary_axis, SingularGraph& graph);

// The singular graph of a matched field, its arcs oriented.
SingularGraph oriented_singular_graph(const FieldMesh& mesh, const EdgeRings& rings);

}  // namespace neurframe
