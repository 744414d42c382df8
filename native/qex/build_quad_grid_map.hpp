// The exact integer-grid map of a triangle mesh from what map.obj holds.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/extraction/build_grid_map.hpp"
#include "core/quad_map_io.hpp"

namespace neurframe {

namespace detail {

// Twice the area of the parameters, with sign.
inline double total_area2(const QuadMap& map) {
  double sum = 0.0;
  for (const auto& u : map.parameters) {
    const RealPoint<2> a = difference(u[1], u[0]);
    const RealPoint<2> b = difference(u[2], u[0]);
    sum += a[0] * b[1] - a[1] * b[0];
  }
  return sum;
}

// Negates u: a rotation R becomes its inverse, a translation (tu, tv) becomes (-tu, tv).
inline void mirror(QuadMap& map) {
  for (auto& corners : map.parameters) {
    for (Vector2<double>& u : corners) u[0] = -u[0];
  }
  for (GivenTransition2& given : map.transitions) {
    given.transition.rotation = given.transition.rotation.inverse();
    given.transition.translation[0] = -given.transition.translation[0];
  }
}

// How far the given transition is from carrying the parameters of f to those of g at half-edge h of f.
inline double deviation(const GridMap<2>& map, const QuadMap& real, const GivenTransition2& given, int h) {
  const FacetParameters<2> here = seen_from(map, real.parameters, h, given.f);
  const FacetParameters<2> there = seen_from(map, real.parameters, h, given.g);
  double largest = 0.0;
  for (std::size_t k = 0; k < 2; ++k) {
    largest = std::max(largest, largest_entry(difference(given.transition(here[k], 1.0), there[k])));
  }
  return largest;
}

// The half-edge of f that the given transition is for; of several between f and g the one it fits.
inline int half_edge_of(const GridMap<2>& map, const QuadMap& real, const GivenTransition2& given) {
  const std::string name = "transition " + std::to_string(given.f) + " " + std::to_string(given.g);
  const int triangles = static_cast<int>(map.S.size());
  if (given.f >= triangles || given.g >= triangles) {
    throw InputError(name + ": the mesh has " + std::to_string(triangles) + " triangles");
  }
  int best = -1;
  double least = INFINITY;
  for (int h = 3 * given.f; h < 3 * given.f + 3; ++h) {
    const int across = map.twin[static_cast<std::size_t>(h)];
    if (across < 0 || across / 3 != given.g) continue;
    const double off = deviation(map, real, given, h);
    if (best < 0 || off < least) {
      best = h;
      least = off;
    }
  }
  if (best < 0) throw InputError(name + ": these triangles share no edge");
  if (!(least <= map_tolerance)) {
    throw InputError(name + ": it leaves the parameters " + std::to_string(least) +
                     " cells apart, allowed are " + std::to_string(map_tolerance));
  }
  return best;
}

}  // namespace detail

// Lets the transitions that the file gives replace those recovered from parameters.
inline void use_given_transitions(const GridMap<2>& map, const QuadMap& real,
                                  RecoveredTransitions<2>& found) {
  std::vector<char> given_here(map.twin.size(), 0);
  for (const GivenTransition2& given : real.transitions) {
    const int h = detail::half_edge_of(map, real, given);
    const GridTransition2& forward = given.transition;
    const auto here = static_cast<std::size_t>(h);
    const auto behind = static_cast<std::size_t>(map.twin[here]);
    detail::set_transition<2>(forward, false, found.transition[here]);
    detail::set_transition<2>(forward.inverse(), false, found.transition[behind]);
    given_here[here] = given_here[behind] = 1;
  }
  std::erase_if(found.impossible, [&](int h) { return given_here[static_cast<std::size_t>(h)] != 0; });
}

// Raises InputError, with the reason and the place, for what is no integer-grid map.  Flipped and flat
// triangles, and boundary edges off the isolines, are no reason: they are counted.
inline GridMap<2> build_quad_grid_map(QuadMap real, int threads, bool& mirrored, MapReport& report) {
  mirrored = detail::total_area2(real) < 0.0;
  if (mirrored) detail::mirror(real);
  GridMap<2> map;
  map.V = real.mesh.V;
  map.S = real.mesh.F;
  map.twin = half_edge_twins(map.S, map.V.size());
  map.fraction_bits = fraction_bits_of<2>(real.parameters);
  RecoveredTransitions<2> found = recover_transitions(map, real.parameters, threads);
  use_given_transitions(map, real, found);
  report.boundary_facets = static_cast<int>(std::count(map.twin.begin(), map.twin.end(), -1));
  report.unaligned_boundary_facets = static_cast<int>(found.unaligned.size());
  refuse_impossible_facets(map, real.parameters, found);
  complete_grid_map(real.parameters, found, threads, map, report);
  return map;
}

}  // namespace neurframe
