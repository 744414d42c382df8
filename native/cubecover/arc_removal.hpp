// Removal of singular arcs that begin and end on one side of the boundary.
#pragma once

#include "cubecover/line_moves.hpp"
#include "cubecover/singular_graph.hpp"

namespace neurframe {

// Makes the arc regular by a surface of faces that it spans together with a curve on the boundary, where its
// axis is the normal: the quarter turn of the arc, carried along the surface, is taken out of their
// matchings.  Returns those faces; none, and the mesh as it was, where the arc does not span such a surface
// near it.
std::vector<int> remove_arc(FieldMesh& mesh, const EdgeRings& rings, const SingularGraph& graph,
                            const SingularArc& arc);

}  // namespace neurframe
