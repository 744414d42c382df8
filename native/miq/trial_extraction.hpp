// Does a map give all of its quads?  Answered by the extraction itself.
#pragma once

#include <vector>

#include "core/quad_map_io.hpp"

namespace neurframe {

// Cells that are no quads of a mesh, exactly as neurframe-qex would lose them.  A locally injective map loses
// cells only where the surface is less than three cells around: two corners are one vertex then, or two edges
// of the grid join the same two vertices.
struct LostQuads {
  int count = 0;
  std::vector<Point3> places;
};
LostQuads lost_quads(const QuadMap& map, int threads);

}  // namespace neurframe
