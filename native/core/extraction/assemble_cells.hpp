// From traced cells to cells over vertex numbers, and an account of those that gave none.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "core/extraction/folded_cells.hpp"
#include "core/extraction/grid_vertices.hpp"

namespace neurframe {

// The corners of a cell (see diagonal()) in the order of the output, and its facets, outward, in that order.
template <int N>
struct CellShape;

template <>
struct CellShape<2> {
  static constexpr std::array<int, 4> corners{0, 1, 3, 2};  // counter-clockwise
  static constexpr std::array<std::array<int, 2>, 4> facets{{{0, 1}, {1, 2}, {2, 3}, {3, 0}}};
};

template <>
struct CellShape<3> {
  static constexpr std::array<int, 8> corners{0, 1, 3, 2, 4, 5, 7, 6};  // VTK's order
  static constexpr std::array<std::array<int, 4>, 6> facets{
      {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}};
};

template <int N>
using CellVertices = std::type_identity_t<std::array<int, cell_corners<N>>>;

enum class CellLoss {
  leaves_mesh,         // the cell sticks out of the boundary
  inexact_transition,  // it needs a facet that charts do not fit across
  lost_walk,
  singularity_inside,  // it comes back to itself turned
  overlapping_sheets,  // its place is covered more than once
  collapsed_corners,   // two corners are one vertex
  crowded_facet,       // one of its facets would have three cells, or two on one side
  pinched              // others touch it in a vertex or an edge only, and cannot be taken apart from it
};

inline const char* loss_name(CellLoss loss) {
  constexpr const char* names[] = {
      "leaves_mesh",        "inexact_transition", "lost_walk",     "singularity_inside",
      "overlapping_sheets", "collapsed_corners",  "crowded_facet", "pinched"};
  return names[static_cast<int>(loss)];
}

template <int N>
struct LostCell {
  CellLoss loss;
  int simplex;
  FixedPoint<N> centre;  // in the chart of the simplex
};

template <int N>
struct AssembledCells {
  std::vector<CellVertices<N>> cells;  // numbers of GridVertices, in the order of CellShape
  std::vector<int> traced;             // the traced cell behind each of them
  std::vector<LostCell<N>> lost;
  int folded = 0;  // cells seen several times because of folds
};

namespace detail {

template <int N>
LostCell<N> lost_cell(CellLoss loss, const Cell<N>& cell) {
  return {loss, cell.simplex, cell.centre};
}

inline CellLoss loss_of_walk(WalkEnd end) {
  if (end == WalkEnd::boundary) return CellLoss::leaves_mesh;
  return end == WalkEnd::broken ? CellLoss::inexact_transition : CellLoss::lost_walk;
}

template <int N>
void finish_class(const TracedCells<N>& traced, int root, bool twisted, const CellSummary<N>& summary,
                  AssembledCells<N>& out) {
  const auto lose = [&](CellLoss loss) {
    out.lost.push_back(lost_cell(loss, traced.cells[static_cast<std::size_t>(root)]));
  };
  if (summary.sign <= 0) return;  // the fold covers nothing here
  if (twisted) return lose(CellLoss::singularity_inside);
  if (summary.sign > 1) return lose(CellLoss::overlapping_sheets);
  CellVertices<N> vertices{};
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const auto corner = static_cast<std::size_t>(CellShape<N>::corners[i]);
    vertices[i] = summary.corners[corner];
    const int code = summary.failures[corner];
    if (vertices[i] < 0) return lose(code < 0 ? loss_of_walk(failure_of(code)) : CellLoss::lost_walk);
  }
  out.folded += summary.members > 1 ? 1 : 0;
  out.cells.push_back(vertices);
  out.traced.push_back(root);
}

// A cell that is seen once, from a simplex that is not flipped.
template <int N>
void finish_cell(const TracedCells<N>& traced, int number, AssembledCells<N>& out) {
  const Cell<N>& cell = traced.cells[static_cast<std::size_t>(number)];
  CellVertices<N> vertices{};
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    vertices[i] = cell.corners[static_cast<std::size_t>(CellShape<N>::corners[i])];
    if (vertices[i] < 0) {
      out.lost.push_back(lost_cell(loss_of_walk(failure_of(vertices[i])), cell));
      return;
    }
  }
  out.cells.push_back(vertices);
  out.traced.push_back(number);
}

// Keeps the cells for which keep(index) is true and books the others as lost.
template <int N, class Keep>
void filter_cells(const TracedCells<N>& traced, CellLoss loss, AssembledCells<N>& out, const Keep& keep) {
  std::size_t kept = 0;
  for (std::size_t c = 0; c < out.cells.size(); ++c) {
    if (!keep(c)) {
      out.lost.push_back(lost_cell(loss, traced.cells[static_cast<std::size_t>(out.traced[c])]));
      continue;
    }
    out.cells[kept] = out.cells[c];
    out.traced[kept++] = out.traced[c];
  }
  out.cells.resize(kept);
  out.traced.resize(kept);
}

template <std::size_t Size>
bool has_repeated_entry(const std::array<int, Size>& entries) {
  int equal = 0;  // all pairs, without branches: faster than sorting eight numbers
  for (std::size_t i = 0; i < Size; ++i) {
    for (std::size_t k = i + 1; k < Size; ++k) equal |= entries[i] == entries[k] ? 1 : 0;
  }
  return equal != 0;
}

// Replaces joined vertices by their representatives and drops cells that repeat one.
template <int N>
void resolve_vertices(const TracedCells<N>& traced, const GridVertices<N>& vertices, AssembledCells<N>& out) {
  filter_cells(traced, CellLoss::collapsed_corners, out, [&](std::size_t c) {
    for (int& v : out.cells[c]) v = vertices.joined() > 0 ? vertices.find(v) : v;
    return !has_repeated_entry(out.cells[c]);
  });
}

}  // namespace detail

// Cells in ascending order of the traced cell behind them.
template <int N>
AssembledCells<N> assemble_cells(const GridMap<N>& map, const InteriorPoints<N>& points,
                                 const TracedCells<N>& traced, GridVertices<N>& vertices) {
  FoldedCells<N> folded(map, points, traced, vertices);
  AssembledCells<N> out;
  out.cells.reserve(traced.cells.size());
  out.traced.reserve(traced.cells.size());
  for (std::size_t c = 0; c < traced.cells.size(); ++c) {
    const int cell = static_cast<int>(c);
    if (!folded.is_folded(cell)) {
      detail::finish_cell(traced, cell, out);
    } else if (folded.root(cell) == cell) {
      detail::finish_class(traced, cell, folded.twisted(cell), folded.summary(cell), out);
    }
  }
  detail::resolve_vertices(traced, vertices, out);
  return out;
}

}  // namespace neurframe
