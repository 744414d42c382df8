// Combing of the crosses along a dual spanning tree, and the cut graph that opens the surface to disks.
#pragma once

#include <vector>

#include "miq/cross_surface.hpp"

namespace neurframe {

// A spanning forest of the dual graph by breadth-first search, as the half-edges that lead into each
// triangle; turns the crosses so that the matching across them is zero.  Returns per half-edge whether the
// forest crosses it.
std::vector<char> comb(CrossSurface& surface);

// A maximal chain of seam edges without a node inside: the transition is constant along it.
struct SeamBranch {
  std::vector<int> half_edges;  // in order, all with the same side of the cut on their left
};

struct CutGraph {
  std::vector<char> seam;  // per half-edge
  std::vector<SeamBranch> branches;
};

// What the forest leaves, pruned of all tips that are neither critical vertices nor on the boundary.
CutGraph build_cut_graph(const CrossSurface& surface, const std::vector<char>& crossed,
                         const std::vector<char>& critical);

// Corners of one vertex that no seam separates share a sector.  Returns the sector of every corner.
std::vector<int> corner_sectors(const CrossSurface& surface, const std::vector<char>& seam,
                                int& sector_count);

}  // namespace neurframe
