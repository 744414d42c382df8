// Ribbons of faces that part a straight singular line from a node.
#pragma once

#include "cubecover/ribbons.hpp"
#include "cubecover/singular_graph.hpp"

namespace neurframe {

// Two lines that touch at a vertex look like a node, but come to lie on one grid line, and what is between
// them has no volume.  Where two edges of one valence at a node turn against each other along a fan of faces,
// they are one straight line, which the fan takes past the node.
//
// Only the narrowest fan between two edges is looked at: those of a node of type (4, 0) are perpendicular on
// the direct way of some 109 degrees, and opposite on the way round the back, between the two others.  Fans
// that are much wider than half a turn are such ways and are left out, and so are those that meet another
// line or the boundary.  The narrowest fans come first.  The graph's arcs are oriented.
std::vector<Ribbon> parting_ribbons(const FieldMesh& mesh, const EdgeRings& rings, const SingularGraph& graph,
                                    const std::vector<int>& nodes);

}  // namespace neurframe
