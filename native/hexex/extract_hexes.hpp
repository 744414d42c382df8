// Hex extraction, cell-centred: from an exact integer-grid map to a hex mesh.
//
//   1. number the integer points inside tets                      interior_points.hpp
//   2. find the cell centres, walk to the eight corners of each    trace_cells.hpp, diagonal_walk.hpp
//   3. number the corners between tets; join what folds repeat     grid_vertices.hpp, folded_vertices.hpp
//   4. assemble hexes, account for the cells that gave none        folded_cells.hpp, assemble_hexes.hpp,
//   manifold_hexes.hpp
//   5. place the vertices                                          here
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "hexex/assemble_hexes.hpp"
#include "hexex/folded_vertices.hpp"
#include "hexex/grid_vertices.hpp"
#include "hexex/interior_points.hpp"
#include "hexex/manifold_hexes.hpp"
#include "hexex/trace_cells.hpp"

namespace neurframe {

// A vertex of the result on the input: tet and barycentric coordinates (of the corners in map.mesh.T order).
struct Location {
  int tet = -1;
  std::array<double, 4> weights{};
};

struct Extraction {
  HexMesh mesh;
  std::vector<Location> locations;  // per vertex
  std::vector<LostCell> lost;
  int folded_cells = 0;
  int joined_vertices = 0;
};

// Barycentric coordinates from exact determinants: exact zeros where the point lies on a face, edge or
// vertex.
inline Location locate(const GridMap& map, const VertexPlace& place) {
  Location location{place.tet, {}};
  const auto& P = map.P[static_cast<std::size_t>(place.tet)];
  const auto whole = static_cast<double>(orient3d(P[0], P[1], P[2], P[3]));
  for (std::size_t i = 0; i < 4; ++i) {
    std::array<FixedPoint3, 4> replaced = P;
    replaced[i] = place.point;
    location.weights[i] =
        static_cast<double>(orient3d(replaced[0], replaced[1], replaced[2], replaced[3])) / whole;
  }
  return location;
}

inline Point3 position(const GridMap& map, const Location& location) {
  Point3 p{0, 0, 0};
  for (std::size_t i = 0; i < 4; ++i) {
    const auto v = static_cast<std::size_t>(map.mesh.T[static_cast<std::size_t>(location.tet)][i]);
    for (std::size_t k = 0; k < 3; ++k) p[k] += location.weights[i] * map.mesh.V[v][k];
  }
  return p;
}

namespace detail {

// Renumbers the vertices that hexes use, in ascending order of their old numbers; returns new numbers, -1 if
// unused.
inline std::vector<int> compact_vertices(std::vector<Hex>& hexes, int vertices, int& used) {
  std::vector<int> renumbered(static_cast<std::size_t>(vertices), -1);
  for (const Hex& hex : hexes) {
    for (const int v : hex) renumbered[static_cast<std::size_t>(v)] = 0;
  }
  used = 0;
  for (int& number : renumbered) number = number == 0 ? used++ : -1;
  for (Hex& hex : hexes) {
    for (int& v : hex) v = renumbered[static_cast<std::size_t>(v)];
  }
  return renumbered;
}

inline void place_vertices(const GridMap& map, const InteriorPoints& points, const GridVertices& vertices,
                           const std::vector<int>& renumbered, int threads, Extraction& out) {
  const auto place = [&](int number, const VertexPlace& where) {
    const int v = renumbered[static_cast<std::size_t>(number)];
    if (v < 0) return;
    out.locations[static_cast<std::size_t>(v)] = locate(map, where);
    out.mesh.V[static_cast<std::size_t>(v)] = position(map, out.locations[static_cast<std::size_t>(v)]);
  };
  parallel_for(static_cast<std::int64_t>(map.P.size()), threads, [&](std::int64_t t) {
    points.for_each(static_cast<int>(t),
                    [&](int number, const FixedPoint3& p) { place(number, {static_cast<int>(t), p}); });
  });
  for (int number = vertices.interior_count(); number < vertices.count(); ++number) {
    place(number, vertices.place(number));
  }
}

}  // namespace detail

using ExtractionProgress = std::function<void(double fraction, const std::string& step)>;

inline Extraction extract_hexes(const GridMap& map, int threads, const ExtractionProgress& progress) {
  progress(0.0, "grid points");
  const InteriorPoints points(map, threads);
  progress(0.1, "cells");
  TracedCells traced = trace_cells(map, points, threads);
  progress(0.6, "vertices");
  GridVertices vertices(points);
  number_named_corners(traced, vertices);
  join_folded_vertices(map, points, vertices);
  progress(0.7, "hexes");
  AssembledHexes assembled = assemble_hexes(map, points, traced, vertices);
  drop_crowding_hexes(traced, vertices.count(), assembled);
  progress(0.9, "positions");
  Extraction out;
  out.mesh.H = std::move(assembled.hexes);
  out.lost = std::move(assembled.lost);
  out.folded_cells = assembled.folded_cells;
  out.joined_vertices = vertices.joined();
  int used = 0;
  const std::vector<int> renumbered = detail::compact_vertices(out.mesh.H, vertices.count(), used);
  out.mesh.V.resize(static_cast<std::size_t>(used));
  out.locations.resize(static_cast<std::size_t>(used));
  detail::place_vertices(map, points, vertices, renumbered, threads, out);
  return out;
}

}  // namespace neurframe
