// The exact integer-grid map of a tet mesh from what a .hexex file holds.
#pragma once

#include <algorithm>
#include <utility>

#include "core/extraction/build_grid_map.hpp"
#include "core/hex_map_io.hpp"
#include "hexex/orient_tets.hpp"

namespace neurframe {

// Raises InputError, with the reason and the place, for what is no integer-grid map.  Flipped and flat tets
// are no reason: they are counted.  partial_boundary: boundary faces off the integer planes are none either.
inline GridMap<3> build_hex_grid_map(HexMap real, bool partial_boundary, int threads,
                                     OrientationReport& orientation, MapReport& report) {
  GridMap<3> map;
  map.twin = half_face_twins(real.mesh.T, real.mesh.V.size());
  orientation = orient_tets(real, map.twin);
  map.V = std::move(real.mesh.V);
  map.S = std::move(real.mesh.T);
  map.fraction_bits = fraction_bits_of<3>(real.parameters);
  RecoveredTransitions<3> found = recover_transitions(map, real.parameters, threads);
  report.boundary_facets = static_cast<int>(std::count(map.twin.begin(), map.twin.end(), -1));
  report.unaligned_boundary_facets = static_cast<int>(found.unaligned.size());
  refuse_impossible_facets(map, real.parameters, found);
  if (!partial_boundary) refuse_unaligned_boundary(map, real.parameters, found, report.boundary_facets);
  complete_grid_map(real.parameters, std::move(found), threads, map, report);
  return map;
}

}  // namespace neurframe
