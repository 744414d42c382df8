// One orientation for a whole tet mesh.
//
// Orientation is a matter of connectivity here: neighbours must see their common face from opposite sides,
// and each connected component as a whole has positive volume.  A single tet that is turned inside out in
// space or in the parameters then stands out as such (maps in circulation have a few).
#pragma once

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "core/hex_map_io.hpp"
#include "core/tet_mesh.hpp"

namespace neurframe {

struct OrientationReport {
  std::vector<char> turned;  // per tet: corners 2 and 3 had to be swapped
  int turned_tets = 0;
  int mirrored_components = 0;  // components with a left-handed map, whose first parameter was negated
};

namespace detail {

inline void swap_corners(HexMap& map, std::size_t t) {
  std::swap(map.mesh.T[t][2], map.mesh.T[t][3]);
  std::swap(map.parameters[t][2], map.parameters[t][3]);
}

inline double parametric_volume6(const std::array<Point3, 4>& P) {
  return signed_volume6({{P[0], P[1], P[2], P[3]}, {{0, 1, 2, 3}}}, 0);
}

// The tets connected to `seed` and whether each has to be turned to agree with it.
inline std::vector<std::size_t> component_of(const HexMap& map, const std::vector<int>& twin,
                                             std::size_t seed, std::vector<signed char>& turn) {
  std::vector<std::size_t> members{seed};
  turn[seed] = 0;
  for (std::size_t next = 0; next < members.size(); ++next) {
    const std::size_t t = members[next];
    for (std::size_t i = 0; i < 4; ++i) {
      const int half_face = static_cast<int>(4 * t + i);
      if (twin[4 * t + i] < 0) continue;
      const auto s = static_cast<std::size_t>(twin[4 * t + i] / 4);
      const bool coherent = is_coherently_oriented(map.mesh.T, twin, half_face);
      const auto wanted = static_cast<signed char>(coherent ? turn[t] : 1 - turn[t]);
      if (turn[s] < 0) {
        turn[s] = wanted;
        members.push_back(s);
      } else if (turn[s] != wanted) {
        throw InputError("tets " + std::to_string(t) + " and " + std::to_string(s) +
                         ": the tet mesh is not orientable");
      }
    }
  }
  return members;
}

inline double total(const std::vector<std::size_t>& members, const std::vector<signed char>& turn,
                    auto volume6) {
  double sum = 0.0;
  for (const std::size_t t : members) sum += turn[t] != 0 ? -volume6(t) : volume6(t);
  return sum;
}

// The half-faces opposite corners 2 and 3 of turned tets change places.
inline void renumber_twins(const std::vector<char>& turned, std::vector<int>& twin) {
  const auto renumbered = [&](int h) {
    return h >= 0 && h % 4 >= 2 && turned[static_cast<std::size_t>(h / 4)] != 0 ? h ^ 1 : h;
  };
  for (int& other : twin) other = renumbered(other);
  for (std::size_t t = 0; t < turned.size(); ++t) {
    if (turned[t] != 0) std::swap(twin[4 * t + 2], twin[4 * t + 3]);
  }
}

}  // namespace detail

// Turns tets (and mirrors left-handed maps) in place, and renumbers the twins with them.  Raises InputError
// when the mesh is not orientable.
inline OrientationReport orient_tets(HexMap& map, std::vector<int>& twin) {
  OrientationReport report;
  std::vector<signed char> turn(map.mesh.T.size(), -1);
  report.turned.assign(map.mesh.T.size(), 0);
  for (std::size_t seed = 0; seed < map.mesh.T.size(); ++seed) {
    if (turn[seed] >= 0) continue;
    const std::vector<std::size_t> members = detail::component_of(map, twin, seed, turn);
    const double volume =
        detail::total(members, turn, [&](std::size_t t) { return signed_volume6(map.mesh, t); });
    const double parametric = detail::total(
        members, turn, [&](std::size_t t) { return detail::parametric_volume6(map.parameters[t]); });
    const bool mirrored = (volume < 0.0) != (parametric < 0.0) && parametric != 0.0;
    report.mirrored_components += mirrored ? 1 : 0;
    for (const std::size_t t : members) {
      report.turned[t] = (turn[t] != 0) != (volume < 0.0) ? 1 : 0;
      if (!mirrored) continue;
      for (Point3& u : map.parameters[t]) u[0] = -u[0];
    }
  }
  for (std::size_t t = 0; t < map.mesh.T.size(); ++t) {
    if (report.turned[t] == 0) continue;
    ++report.turned_tets;
    detail::swap_corners(map, t);
  }
  if (report.turned_tets > 0) detail::renumber_twins(report.turned, twin);
  return report;
}

}  // namespace neurframe
