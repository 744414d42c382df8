// From traced cells to hexes over vertex numbers, and an account of the cells that gave none.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "core/hex_io.hpp"
#include "hexex/folded_cells.hpp"
#include "hexex/grid_vertices.hpp"

namespace neurframe {

enum class CellLoss {
  leaves_mesh,         // the cell sticks out of the boundary
  inexact_transition,  // it needs a face that charts do not fit across
  lost_walk,
  singularity_inside,  // it comes back to itself turned
  overlapping_sheets,  // its place is covered more than once
  collapsed_corners,   // two corners are one vertex
  crowded_face         // one of its faces would have three hexes
};

inline const char* loss_name(CellLoss loss) {
  constexpr const char* names[] = {"leaves_mesh",        "inexact_transition", "lost_walk",
                                   "singularity_inside", "overlapping_sheets", "collapsed_corners",
                                   "crowded_face"};
  return names[static_cast<int>(loss)];
}

struct LostCell {
  CellLoss loss;
  int tet;
  FixedPoint3 centre;  // in the chart of tet
};

struct AssembledHexes {
  std::vector<Hex> hexes;        // vertex numbers of GridVertices, VTK order
  std::vector<int> cell_of_hex;  // the cell that stands for it
  std::vector<LostCell> lost;
  int folded_cells = 0;  // cells seen several times because of folds
};

namespace detail {

// VTK's order of the corners, whose bits are the signs of diagonal()
inline constexpr std::array<int, 8> vtk_corners{0, 1, 3, 2, 4, 5, 7, 6};

inline LostCell lost_cell(CellLoss loss, const Cell& cell) {
  return {loss, cell.tet, cell.centre};
}

inline CellLoss loss_of_walk(WalkEnd end) {
  if (end == WalkEnd::boundary) return CellLoss::leaves_mesh;
  return end == WalkEnd::broken ? CellLoss::inexact_transition : CellLoss::lost_walk;
}

inline CellSummary summary_of(const Cell& cell) {
  CellSummary summary{cell.sign, 1, cell.corners, {}};
  for (std::size_t i = 0; i < 8; ++i) summary.failures[i] = std::min(cell.corners[i], 0);
  return summary;
}

inline void finish_class(const Cell& root, bool twisted, const CellSummary& summary, AssembledHexes& out,
                         int cell) {
  if (summary.sign <= 0) return;  // the fold covers nothing here
  if (twisted) return out.lost.push_back(lost_cell(CellLoss::singularity_inside, root));
  if (summary.sign > 1) return out.lost.push_back(lost_cell(CellLoss::overlapping_sheets, root));
  Hex hex{};
  for (std::size_t i = 0; i < 8; ++i) {
    const auto corner = static_cast<std::size_t>(vtk_corners[i]);
    hex[i] = summary.corners[corner];
    if (hex[i] >= 0) continue;
    const int code = summary.failures[corner];
    return out.lost.push_back(
        lost_cell(code < 0 ? loss_of_walk(failure_of(code)) : CellLoss::lost_walk, root));
  }
  out.folded_cells += summary.members > 1 ? 1 : 0;
  out.hexes.push_back(hex);
  out.cell_of_hex.push_back(cell);
}

// Replaces joined vertices by their representatives and drops hexes that repeat one.
inline void resolve_vertices(const TracedCells& traced, const GridVertices& vertices, AssembledHexes& out) {
  std::size_t kept = 0;
  for (std::size_t h = 0; h < out.hexes.size(); ++h) {
    Hex hex = out.hexes[h];
    for (int& v : hex) v = vertices.find(v);
    Hex sorted = hex;
    std::sort(sorted.begin(), sorted.end());
    const int cell = out.cell_of_hex[h];
    if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end()) {
      out.lost.push_back(
          lost_cell(CellLoss::collapsed_corners, traced.cells[static_cast<std::size_t>(cell)]));
      continue;
    }
    out.hexes[kept] = hex;
    out.cell_of_hex[kept++] = cell;
  }
  out.hexes.resize(kept);
  out.cell_of_hex.resize(kept);
}

}  // namespace detail

// Hexes in ascending order of their cell.
inline AssembledHexes assemble_hexes(const GridMap& map, const InteriorPoints& points,
                                     const TracedCells& traced, GridVertices& vertices) {
  FoldedCells folded(map, points, traced, vertices);
  AssembledHexes out;
  out.hexes.reserve(traced.cells.size());
  out.cell_of_hex.reserve(traced.cells.size());
  for (std::size_t c = 0; c < traced.cells.size(); ++c) {
    const int cell = static_cast<int>(c);
    if (folded.root(cell) != cell) continue;
    const CellSummary summary =
        folded.is_folded(cell) ? folded.summary(cell) : detail::summary_of(traced.cells[c]);
    detail::finish_class(traced.cells[c], folded.twisted(cell), summary, out, cell);
  }
  detail::resolve_vertices(traced, vertices, out);
  return out;
}

}  // namespace neurframe
