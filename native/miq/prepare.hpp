// Refinement that gives the map the freedom it needs near features and singular vertices.
#pragma once

#include <vector>

#include "miq/cross_surface.hpp"

namespace neurframe {

// Splits at midpoints every edge longer than `longest`, longest first.  Returns the number of splits; raises
// StageError where they would be too many.
int split_long_edges(CrossSurface& surface, double longest);

// Until no triangle has two feature edges and no other edge joins two vertices on features: splits such
// triangles at their centroid and such edges at their midpoint.  Returns the number of splits.
int split_around_features(CrossSurface& surface);

// Until no edge joins two critical vertices without being a feature: splits such edges at midpoints.  New
// vertices are not critical; `critical` grows with the vertices.  Matchings must be known and are inherited.
int split_between_critical(CrossSurface& surface, std::vector<char>& critical);

// Until every sector with irregular quarter turns has at least two triangles per quarter turn: splits the
// edges opposite to its widest corners.  With fewer, a corner comes near to a straight angle in the map and
// the star folds as soon as the map is distorted.  Returns the number of splits.
int refine_singular_stars(CrossSurface& surface, const std::vector<char>& singular);

}  // namespace neurframe
