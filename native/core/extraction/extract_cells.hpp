// Extraction, cell-centred: from an exact integer-grid map to the quads (N = 2) or hexes (N = 3) of its grid.
//
//   1. number the integer points inside simplices                  interior_points.hpp
//   2. find the cell centres, walk to the corners of each          trace_cells.hpp, diagonal_walk.hpp
//   3. number the corners between simplices; join repeated ones    grid_vertices.hpp, folded_vertices.hpp
//   4. assemble cells, account for those that are lost             folded_cells.hpp, assemble_cells.hpp,
//                                                                  manifold_cells.hpp, separate_pinches.hpp
//   5. place the vertices                                          locate_points.hpp, here
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/extraction/assemble_cells.hpp"
#include "core/extraction/folded_vertices.hpp"
#include "core/extraction/locate_points.hpp"
#include "core/extraction/manifold_cells.hpp"
#include "core/extraction/separate_pinches.hpp"

namespace neurframe {

template <int N>
struct Extraction {
  std::vector<Point3> V;
  std::vector<CellVertices<N>> cells;
  std::vector<Location<N>> locations;  // per vertex
  std::vector<LostCell<N>> lost;
  int folded_cells = 0;
  int joined_vertices = 0;
  int separated_vertices = 0;  // copies of others, for cells that no facet connects
};

namespace detail {

// Renumbers the vertices that cells use, in ascending order of their old numbers; returns new numbers, -1 if
// unused.
template <int N>
std::vector<int> compact_vertices(std::vector<CellVertices<N>>& cells, int vertices, int& used) {
  std::vector<int> renumbered(static_cast<std::size_t>(vertices), -1);
  for (const CellVertices<N>& cell : cells) {
    for (const int v : cell) renumbered[static_cast<std::size_t>(v)] = 0;
  }
  used = 0;
  for (int& number : renumbered) number = number == 0 ? used++ : -1;
  for (CellVertices<N>& cell : cells) {
    for (int& v : cell) v = renumbered[static_cast<std::size_t>(v)];
  }
  return renumbered;
}

template <int N>
void place_vertices(const GridMap<N>& map, const InteriorPoints<N>& points, const GridVertices<N>& vertices,
                    const std::vector<int>& renumbered, int threads, Extraction<N>& out) {
  const auto place = [&](int number, const SimplexLocator<N>& locator, const FixedPoint<N>& point) {
    const int v = renumbered[static_cast<std::size_t>(number)];
    if (v < 0) return;
    Location<N>& location = out.locations[static_cast<std::size_t>(v)];
    location = locator(point);
    out.V[static_cast<std::size_t>(v)] = position(map, location);
  };
  parallel_for(static_cast<std::int64_t>(map.P.size()), threads, [&](std::int64_t t) {
    std::optional<SimplexLocator<N>> locator;  // most simplices of a fine mesh have no point
    points.for_each(static_cast<int>(t), [&](int number, const FixedPoint<N>& p) {
      if (!locator) locator.emplace(map, static_cast<int>(t));
      place(number, *locator, p);
    });
  });
  parallel_for(vertices.count() - vertices.interior_count(), threads, [&](std::int64_t i) {
    const int number = vertices.interior_count() + static_cast<int>(i);
    const VertexPlace<N>& named = vertices.place(number);
    place(number, SimplexLocator<N>(map, named.simplex), named.point);
  });
}

// Copies the places of the vertices that `copied` names to the numbers from `vertices` on.
template <int N>
void place_copies(const std::vector<int>& copied, int vertices, const std::vector<int>& renumbered,
                  Extraction<N>& out) {
  for (std::size_t i = 0; i < copied.size(); ++i) {
    const auto from = static_cast<std::size_t>(renumbered[static_cast<std::size_t>(copied[i])]);
    const auto to = static_cast<std::size_t>(renumbered[static_cast<std::size_t>(vertices) + i]);
    out.V[to] = out.V[from];
    out.locations[to] = out.locations[from];
  }
}

// Where no tet is flipped and no cell is lost the cells are those of a manifold.
template <int N>
bool may_be_pinched(const GridMap<N>& map, const AssembledCells<N>& assembled) {
  return !assembled.lost.empty() ||
         std::any_of(map.orientation.begin(), map.orientation.end(), [](auto sign) { return sign < 0; });
}

}  // namespace detail

using ExtractionProgress = std::function<void(double fraction, const std::string& step)>;

template <int N>
Extraction<N> extract_cells(const GridMap<N>& map, int threads, const ExtractionProgress& progress) {
  progress(0.0, "grid points");
  const InteriorPoints<N> points(map, threads);
  progress(0.1, "cells");
  TracedCells<N> traced = trace_cells(map, points, threads);
  progress(0.6, "vertices");
  GridVertices<N> vertices(points);
  number_named_corners(traced, vertices);
  join_folded_vertices(map, points, vertices);
  progress(0.7, "connectivity");
  AssembledCells<N> assembled = assemble_cells(map, points, traced, vertices);
  drop_crowding_cells(traced, vertices.count(), threads, assembled);
  std::vector<int> copied;
  if (detail::may_be_pinched(map, assembled)) copied = separate_pinches(traced, vertices.count(), assembled);
  progress(0.9, "positions");
  Extraction<N> out;
  out.cells = std::move(assembled.cells);
  out.lost = std::move(assembled.lost);
  out.folded_cells = assembled.folded;
  out.joined_vertices = vertices.joined();
  out.separated_vertices = static_cast<int>(copied.size());
  int used = 0;
  const std::vector<int> renumbered =
      detail::compact_vertices<N>(out.cells, vertices.count() + out.separated_vertices, used);
  out.V.resize(static_cast<std::size_t>(used));
  out.locations.resize(static_cast<std::size_t>(used));
  detail::place_vertices(map, points, vertices, renumbered, threads, out);
  detail::place_copies(copied, vertices.count(), renumbered, out);
  return out;
}

}  // namespace neurframe
