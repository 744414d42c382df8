// Ribbons of faces that part a straight singular line from a node.
#pragma once

#include "cubecover/ribbons.hpp"
#include "cubecover/singular_graph.hpp"

namespace neurframe {

// Two lines that touch at a vertex look like a node, but come to lie on one grid line, and what is between
// them has no volume.  Where two edges of one valence at a node turn against each other along a fan of faces,
// they are one straight line, which the fan takes past the node.  One such fan for each of these pairs, which
// meets no other line and does not go along the boundary; the narrowest first.  The graph's arcs are
// oriented.
std::vector<Ribbon> parting_ribbons(const FieldMesh& mesh, const EdgeRings& rings, const SingularGraph& graph,
                                    const std::vector<int>& nodes);

}  // namespace neurframe
