// Matchings (period jumps) between neighbouring crosses, and the quarter turns of the field around vertices.
#pragma once

#include <vector>

#include "miq/cross_surface.hpp"

namespace neurframe {

// Turns the cross of every triangle with a feature edge by the least angle that aligns it with that edge (the
// longest one if there are several).  Returns the largest turn in radians.
double align_to_features(CrossSurface& surface);

// Rounds the rotation between neighbouring crosses to quarter turns: the matching of every half-edge.
void compute_matchings(CrossSurface& surface);

// Rotation in (-pi, pi] that is left of the first axis across half-edge h after its matching is taken off.
double rotation_residual(const CrossSurface& surface, int h);

// The corners of one vertex between two feature edges, or all of them where there are less than two.
struct Sector {
  int vertex;
  std::vector<int> corners;  // counter-clockwise
  bool closed;               // no feature edge at the vertex
  int quarter_turns;         // of the map from the first spoke to the last: 4 at a regular interior vertex
  double angle;              // radians on the surface, all corners together
};

// All sectors.  Quarter turns are counted as angle, not modulo 4: (sum of corner angles + residuals) / 90
// degrees.
std::vector<Sector> measure_sectors(const CrossSurface& surface);

// per vertex: -1 regular, else the index of its first sector in `sectors` that makes it an integer point
std::vector<char> singular_vertices(const CrossSurface& surface, const std::vector<Sector>& sectors);

// Smooths the crosses, with all matchings kept, in the triangles within `radius` of the given vertices; those
// beside features are held.  Least squares of the residual rotations (Bommes et al. 2009, equation 3,
// integers fixed).
void relax_field(CrossSurface& surface, const std::vector<int>& vertices, double radius);

// edge length / dual edge length
double dual_weight(const CrossSurface& surface, int h);

}  // namespace neurframe
