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

#include "core/fixed_point.hpp"
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
  const Point3 a = difference(P[1], P[0]);
  const Point3 b = difference(P[2], P[0]);
  const Point3 c = difference(P[3], P[0]);
  return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
         a[2] * (b[0] * c[1] - b[1] * c[0]);
}

// Of a connected component, in the orientation of its first tet.
struct ComponentVolume {
  double space = 0.0;
  double parametric = 0.0;

  bool mirrored() const { return (space < 0.0) != (parametric < 0.0) && parametric != 0.0; }
};

// Connected components of the tets, and whether each tet has to be turned to agree with the first of its own.
struct Components {
  std::vector<int> of;     // per tet
  std::vector<char> turn;  // per tet
  std::vector<ComponentVolume> volumes;
};

[[noreturn]] inline void refuse_orientation(int t, int s) {
  throw InputError("tets " + std::to_string(t) + " and " + std::to_string(s) +
                   ": the tet mesh is not orientable");
}

// Visits the neighbours of tet t.  A face between visited tets is checked from its first side only.
inline void visit_neighbours(const HexMap& map, const std::vector<int>& twin, int t, Components& found,
                             std::vector<int>& queue) {
  for (int h = 4 * t; h < 4 * t + 4; ++h) {
    const int across = twin[static_cast<std::size_t>(h)];
    if (across < 0) continue;
    const int s = across / 4;
    const bool visited = found.of[static_cast<std::size_t>(s)] >= 0;
    if (visited && across < h) continue;
    const bool coherent = is_coherently_oriented(map.mesh.T, twin, h);
    const bool wanted = coherent == (found.turn[static_cast<std::size_t>(t)] != 0);
    char& turn = found.turn[static_cast<std::size_t>(s)];
    if (visited && (turn != 0) != wanted) refuse_orientation(t, s);
    turn = wanted ? 1 : 0;
    if (visited) continue;
    found.of[static_cast<std::size_t>(s)] = found.of[static_cast<std::size_t>(t)];
    queue.push_back(s);
  }
}

inline void add_volume(const HexMap& map, std::size_t t, bool turned, ComponentVolume& volume) {
  const double sign = turned ? -1.0 : 1.0;
  volume.space += sign * signed_volume6(map.mesh, t);
  volume.parametric += sign * parametric_volume6(map.parameters[t]);
}

inline Components find_components(const HexMap& map, const std::vector<int>& twin) {
  const std::size_t tets = map.mesh.T.size();
  Components found{std::vector<int>(tets, -1), std::vector<char>(tets, 0), {}};
  std::vector<int> queue;
  for (std::size_t seed = 0; seed < tets; ++seed) {
    if (found.of[seed] >= 0) continue;
    found.of[seed] = static_cast<int>(found.volumes.size());
    ComponentVolume& volume = found.volumes.emplace_back();
    queue.assign(1, static_cast<int>(seed));
    for (std::size_t next = 0; next < queue.size(); ++next) {
      const auto t = static_cast<std::size_t>(queue[next]);
      add_volume(map, t, found.turn[t] != 0, volume);
      visit_neighbours(map, twin, queue[next], found, queue);
    }
  }
  return found;
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
  const detail::Components components = detail::find_components(map, twin);
  const std::vector<detail::ComponentVolume>& volumes = components.volumes;
  OrientationReport report;
  for (const detail::ComponentVolume& volume : volumes)
    report.mirrored_components += volume.mirrored() ? 1 : 0;
  report.turned.assign(map.mesh.T.size(), 0);
  for (std::size_t t = 0; t < map.mesh.T.size(); ++t) {
    const detail::ComponentVolume& volume = volumes[static_cast<std::size_t>(components.of[t])];
    if (volume.mirrored()) {
      for (Point3& u : map.parameters[t]) u[0] = -u[0];
    }
    if ((components.turn[t] != 0) == (volume.space < 0.0)) continue;
    report.turned[t] = 1;
    ++report.turned_tets;
    detail::swap_corners(map, t);
  }
  if (report.turned_tets > 0) detail::renumber_twins(report.turned, twin);
  return report;
}

}  // namespace neurframe
