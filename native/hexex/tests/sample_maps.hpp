// Integer-grid maps with a known hex mesh, for tests.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <vector>

#include "core/hex_map_io.hpp"
#include "core/octahedral_rotation.hpp"

namespace neurframe {

inline constexpr std::array<std::array<int, 3>, 6> axis_orders{
    {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}}};

// The corners of the six tets (Kuhn) of the unit cube at `origin`, positively oriented.
inline std::vector<std::array<std::array<int, 3>, 4>> kuhn_tets(const std::array<int, 3>& origin) {
  std::vector<std::array<std::array<int, 3>, 4>> tets;
  for (std::size_t k = 0; k < axis_orders.size(); ++k) {
    std::array<std::array<int, 3>, 4> tet{origin, origin, origin, origin};
    for (std::size_t i = 1; i < 4; ++i) {
      tet[i] = tet[i - 1];
      ++tet[i][static_cast<std::size_t>(axis_orders[k][i - 1])];
    }
    if (k >= 3) std::swap(tet[1], tet[2]);
    tets.push_back(tet);
  }
  return tets;
}

// The cube [0, 1]^3 in 6 n^3 tets with u = cells x: hexes are exact cubes, cells^3 of them.
inline HexMap cube_map(int n, double cells) {
  HexMap map;
  const auto index = [&](const std::array<int, 3>& g) { return (g[0] * (n + 1) + g[1]) * (n + 1) + g[2]; };
  for (int x = 0; x <= n; ++x) {
    for (int y = 0; y <= n; ++y) {
      for (int z = 0; z <= n; ++z) map.mesh.V.push_back({1.0 * x / n, 1.0 * y / n, 1.0 * z / n});
    }
  }
  for (int i = 0; i < n * n * n; ++i) {
    for (const auto& tet : kuhn_tets({i / (n * n), i / n % n, i % n})) {
      map.mesh.T.push_back({index(tet[0]), index(tet[1]), index(tet[2]), index(tet[3])});
    }
  }
  for (const Tet& tet : map.mesh.T) {
    std::array<Point3, 4> P{};
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t k = 0; k < 3; ++k) P[i][k] = map.mesh.V[static_cast<std::size_t>(tet[i])][k] * cells;
    }
    map.parameters.push_back(P);
  }
  return map;
}

// Moves every vertex inside the cube (and its parameters with it, so that the map stays x -> cells x) by at
// most `amplitude`, on a lattice of 2^-20.
inline void jitter_cube(HexMap& map, double cells, double amplitude, std::mt19937& random) {
  std::uniform_real_distribution<double> offset(-amplitude, amplitude);
  for (Point3& p : map.mesh.V) {
    const bool inner = std::all_of(p.begin(), p.end(), [](double x) { return x > 0.0 && x < 1.0; });
    for (double& x : p) x = std::ldexp(std::nearbyint(std::ldexp(inner ? x + offset(random) : x, 20)), -20);
  }
  for (std::size_t t = 0; t < map.mesh.T.size(); ++t) {
    for (std::size_t i = 0; i < 4; ++i) {
      const Point3& p = map.mesh.V[static_cast<std::size_t>(map.mesh.T[t][i])];
      map.parameters[t][i] = {p[0] * cells, p[1] * cells, p[2] * cells};
    }
  }
}

// Moves only the parameters of the inner vertices of a cube map: folds once the amplitude is large; rounds
// them to multiples of `step`: flat tets.
inline void fold_cube(HexMap& map, double amplitude, double step, std::mt19937& random) {
  std::uniform_real_distribution<double> offset(-amplitude, amplitude);
  std::vector<Point3> moved(map.mesh.V.size());
  for (std::size_t t = 0; t < map.mesh.T.size(); ++t) {
    for (std::size_t i = 0; i < 4; ++i)
      moved[static_cast<std::size_t>(map.mesh.T[t][i])] = map.parameters[t][i];
  }
  for (std::size_t v = 0; v < moved.size(); ++v) {
    const Point3& p = map.mesh.V[v];
    if (!std::all_of(p.begin(), p.end(), [](double x) { return x > 0.0 && x < 1.0; })) continue;
    for (double& u : moved[v]) u = std::nearbyint((u + offset(random)) / step) * step;
  }
  for (std::size_t t = 0; t < map.mesh.T.size(); ++t) {
    for (std::size_t i = 0; i < 4; ++i)
      map.parameters[t][i] = moved[static_cast<std::size_t>(map.mesh.T[t][i])];
  }
}

// Puts every tet in a chart of its own: a random grid symmetry, plus noise as a file with few digits has.
inline void rechart(HexMap& map, std::mt19937& random, double noise = 0.0) {
  std::uniform_int_distribution<int> rotation(0, 23);
  std::uniform_int_distribution<int> shift(-8, 8);
  std::uniform_real_distribution<double> error(-noise, noise);
  for (auto& corners : map.parameters) {
    const GridTransition3 chart{OctahedralRotation(rotation(random)),
                                {shift(random), shift(random), shift(random)}};
    for (Point3& u : corners) {
      u = chart(u, 1.0);
      for (double& x : u) x += error(random);
    }
  }
}

// `sectors` cubes of cells^3 hexes, each in n^3 * 6 tets, around a common vertical edge: an edge of valence
// `sectors` (3, 5, 6, ...).  Number of hexes: sectors cells^3; vertices: (cells + 1)(1 + sectors cells (cells
// + 1)).
inline HexMap sector_map(int sectors, int n, int cells) {
  HexMap map;
  std::map<std::array<int, 4>, int> numbers;
  const double pi = std::acos(-1.0);
  // side x = 0 of a sector is side y = 0 of the next one
  const auto vertex = [&](int sector, std::array<int, 3> g) {
    if (g[0] == 0 && g[1] == 0) sector = 0;
    if (g[0] == 0 && g[1] > 0) {
      sector = (sector + 1) % sectors;
      std::swap(g[0], g[1]);
    }
    const auto [found, added] =
        numbers.try_emplace({sector, g[0], g[1], g[2]}, static_cast<int>(map.mesh.V.size()));
    if (added) {
      const double a = 2.0 * pi * sector / sectors;
      const double b = 2.0 * pi * (sector + 1) / sectors;
      map.mesh.V.push_back({(g[0] * std::cos(a) + g[1] * std::cos(b)) / n,
                            (g[0] * std::sin(a) + g[1] * std::sin(b)) / n, 1.0 * g[2] / n});
    }
    return found->second;
  };
  for (int sector = 0; sector < sectors; ++sector) {
    for (int i = 0; i < n * n * n; ++i) {
      for (const auto& tet : kuhn_tets({i / (n * n), i / n % n, i % n})) {
        Tet T{};
        std::array<Point3, 4> P{};
        for (std::size_t k = 0; k < 4; ++k) {
          T[k] = vertex(sector, tet[k]);
          for (std::size_t axis = 0; axis < 3; ++axis) P[k][axis] = 1.0 * tet[k][axis] * cells / n;
        }
        map.mesh.T.push_back(T);
        map.parameters.push_back(P);
      }
    }
  }
  return map;
}

}  // namespace neurframe
