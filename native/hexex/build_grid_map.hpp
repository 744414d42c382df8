// From the file to the exact map: orientation, transitions, fixed point; or the reason why it is no
// integer-grid map.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>

#include "hexex/grid_map.hpp"
#include "hexex/make_seamless.hpp"
#include "hexex/orient_tets.hpp"
#include "hexex/recover_transitions.hpp"

namespace neurframe {

struct MapReport {
  OrientationReport orientation;
  SeamlessReport seamless;
  int boundary_faces = 0;
  int unaligned_boundary_faces = 0;
  int flipped_tets = 0;
  int flat_tets = 0;
  double parametric_volume = 0.0;  // in cells: the number of hexes of a map without flaws
  bool whole_volume = false;       // it is exactly an integer
};

namespace detail {

inline std::string face_name(const HexMap& map, int h) {
  const std::array<int, 3> v = half_face_vertices(map.mesh.T, h);
  return "face " + std::to_string(v[0]) + "-" + std::to_string(v[1]) + "-" + std::to_string(v[2]);
}

inline std::string as_text(const Point3& u) {
  const auto number = [](double x) {
    char digits[32];
    std::snprintf(digits, sizeof digits, "%.6g", x);
    return std::string(digits);
  };
  return "(" + number(u[0]) + ", " + number(u[1]) + ", " + number(u[2]) + ")";
}

// Raises InputError when charts do not fit, which no extraction can mend.
inline void refuse_impossible_faces(const HexMap& map, const std::vector<int>& twin,
                                    const RecoveredTransitions& found) {
  if (found.impossible.empty()) return;
  const int h = found.impossible.front();
  const int other = twin[static_cast<std::size_t>(h)];
  const FaceParameters a = seen_from(map, h, h / 4);
  const FaceParameters b = seen_from(map, h, other / 4);
  const TransitionChoice choice = best_transition(a, b);
  const bool turned = choice.residual > map_tolerance;
  throw InputError("not an integer-grid map: at " + std::to_string(found.impossible.size()) +
                   " interior faces the charts differ by no grid symmetry; first " + face_name(map, h) +
                   " of tets " + std::to_string(h / 4) + " and " + std::to_string(other / 4) + ": " +
                   (turned ? "no rotation of the grid carries one image to the other (off by " +
                                 std::to_string(choice.residual) + ")"
                           : "translation " + as_text(choice.translation) + ", allowed are integers") +
                   "; a seamless map has to be quantized first");
}

inline void refuse_unaligned_boundary(const HexMap& map, const RecoveredTransitions& found,
                                      int boundary_faces) {
  if (found.unaligned.empty()) return;
  const int h = found.unaligned.front();
  const FaceParameters u = seen_from(map, h, h / 4);
  throw InputError("not an integer-grid map: " + std::to_string(found.unaligned.size()) + " of " +
                   std::to_string(boundary_faces) + " boundary faces lie on no integer plane; first " +
                   face_name(map, h) + " of tet " + std::to_string(h / 4) + " with parameters " +
                   as_text(u[0]) + " " + as_text(u[1]) + " " + as_text(u[2]) +
                   "; --partial-boundary extracts the complete cells all the same");
}

inline int fraction_bits_of(const HexMap& map) {
  double largest = 0.0;
  for (const auto& corners : map.parameters) {
    for (const Point3& u : corners) largest = std::max(largest, largest_entry(u));
  }
  const int bits = fraction_bits_for(largest);
  if (bits == 0) {
    throw InputError("a parameter of " + std::to_string(largest) + " cells; allowed are parameters below 2^" +
                     std::to_string(fixed_total_bits - fixed_least_fraction_bits));
  }
  return bits;
}

// Signs of the tets, exactly, and the total volume, exactly.
inline void measure_volume(GridMap& map, MapReport& report) {
  map.orientation.resize(map.mesh.T.size());
  map.touches_flat.assign(map.mesh.V.size(), 0);
  const Int128 cell = 6 * (Int128{1} << (3 * map.fraction_bits));
  Int128 whole = 0;
  Int128 rest = 0;  // kept below one cell, so that no sum overflows
  for (std::size_t t = 0; t < map.P.size(); ++t) {
    const auto& P = map.P[t];
    const Int128 volume = orient3d(P[0], P[1], P[2], P[3]);
    map.orientation[t] = static_cast<std::int8_t>(sign_of(volume));
    whole += volume / cell;
    rest += volume % cell;
    whole += rest / cell;
    rest %= cell;
    report.flipped_tets += volume < 0 ? 1 : 0;
    report.flat_tets += volume == 0 ? 1 : 0;
    if (volume != 0) continue;
    for (const int v : map.mesh.T[t]) map.touches_flat[static_cast<std::size_t>(v)] = 1;
  }
  report.whole_volume = rest == 0;
  report.parametric_volume =
      static_cast<double>(whole) + static_cast<double>(rest) / static_cast<double>(cell);
}

}  // namespace detail

// Raises InputError, with the reason and the place, for what is no integer-grid map.  Flipped and flat tets
// are no reason: they are counted.  partial_boundary: boundary faces off the integer planes are none either.
inline GridMap build_grid_map(HexMap real, bool partial_boundary, int threads, MapReport& report) {
  GridMap map;
  report.orientation = orient_tets(real, half_face_twins(real.mesh.T, real.mesh.V.size()));
  map.turned = report.orientation.turned;
  map.mesh = real.mesh;
  map.twin = half_face_twins(map.mesh.T, map.mesh.V.size());
  map.fraction_bits = detail::fraction_bits_of(real);
  const RecoveredTransitions found = recover_transitions(real, map.twin, threads);
  report.boundary_faces = static_cast<int>(std::count(map.twin.begin(), map.twin.end(), -1));
  report.unaligned_boundary_faces = static_cast<int>(found.unaligned.size());
  detail::refuse_impossible_faces(real, map.twin, found);
  if (!partial_boundary) detail::refuse_unaligned_boundary(real, found, report.boundary_faces);
  report.seamless = make_seamless(real, found, threads, map);
  detail::measure_volume(map, report);
  return map;
}

}  // namespace neurframe
