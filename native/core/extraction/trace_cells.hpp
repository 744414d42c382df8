// The preimages of cell centres, and for each of them where the walks to the corners of the cell end.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/extraction/corner_planes.hpp"
#include "core/extraction/diagonal_walk.hpp"
#include "core/extraction/interior_points.hpp"
#include "core/extraction/lattice_points.hpp"
#include "core/extraction/preimage.hpp"
#include "core/parallel.hpp"

namespace neurframe {

// Corner codes: a vertex number, or minus one minus the WalkEnd that kept the walk from arriving.
constexpr int failed_corner(WalkEnd end) {
  return -1 - static_cast<int>(end);
}
constexpr WalkEnd failure_of(int code) {
  return static_cast<WalkEnd>(-1 - code);
}

template <int N>
struct Cell {
  int simplex;
  FixedPoint<N> centre;  // in the chart of the simplex
  Rotation<N> frame;     // the perturbation Q in that chart
  std::int8_t sign;      // 1, -1 in a flipped simplex, 0 where the class of the cell has to tell
  std::array<int, cell_corners<N>> corners;
};

// A vertex that is not strictly inside a simplex: its name, and a simplex that is not flat with the vertex in
// its chart.
template <int N>
struct NamedCorner {
  int cell;
  int corner;
  PlaceKey<N> key;
  int simplex;
  FixedPoint<N> point;
};

// A cell whose centre lies between simplices, under the name of that place.
template <int N>
struct NamedCentre {
  int cell;
  PlaceKey<N> key;
};

template <int N>
struct TracedCells {
  std::vector<Cell<N>> cells;
  std::vector<NamedCorner<N>> corners;
  std::vector<NamedCentre<N>> centres;
};

namespace detail {

template <int N>
class CellTracer {
 public:
  CellTracer(const GridMap<N>& map, const InteriorPoints<N>& points, TracedCells<N>& out)
      : map_(map), points_(points), search_(map), out_(out) {}

  void trace_simplex(int t) {
    const Fixed half = map_.one() / 2;
    const LatticeBox<N> box = lattice_box(map_, t, half);
    if (map_.orientation[static_cast<std::size_t>(t)] == 0 || certainly_outside(map_, t, box, half)) return;
    const SimplexPlanes<N> planes(map_, t);
    std::optional<CornerPlanes<N>> corners;
    for_each_lattice_point(map_, planes, box, half, [&](const FixedPoint<N>& p, const FacetSigns<N>& signs) {
      if (!corners) corners.emplace(planes, half);
      add_cell(t, p, signs, *corners);
    });
  }

 private:
  void add_cell(int t, const FixedPoint<N>& p, const FacetSigns<N>& signs, const CornerPlanes<N>& corners) {
    const int number = static_cast<int>(out_.cells.size());
    Cell<N> cell{t, p, {}, map_.orientation[static_cast<std::size_t>(t)], {}};
    if (!all_positive(signs)) {
      if (!owns_tie(t, p, signs, cell)) return;
      out_.centres.push_back({number, search_.key_of(t, p, signs)});
    }
    cell.corners.fill(failed_corner(WalkEnd::returned));
    if (cell.sign != 0) trace_corners(number, corners, cell);
    out_.cells.push_back(cell);
  }

  // A centre between simplices belongs to the one that holds it after the perturbation, which the lowest
  // defines. Next to flat or flipped ones there may be none or several: the lowest that is not flat keeps the
  // cell for later.
  bool owns_tie(int t, const FixedPoint<N>& p, const FacetSigns<N>& signs, Cell<N>& cell) {
    const std::vector<PreimageVisit<N>>& visits = search_.visits(t, p);
    const PreimageVisit<N>* lowest = nullptr;
    bool sound = true;
    for (const PreimageVisit<N>& visit : visits) {
      const int orientation = map_.orientation[static_cast<std::size_t>(visit.simplex)];
      sound = sound && orientation > 0;
      if (orientation != 0 && (lowest == nullptr || visit.simplex < lowest->simplex)) lowest = &visit;
    }
    if (!sound) cell.sign = 0;
    if (!sound) return lowest->simplex == t;
    cell.frame = lowest->rotation.inverse();
    return perturbed_inside(map_, t, p, signs, cell.frame);
  }

  void trace_corners(int number, const CornerPlanes<N>& planes, Cell<N>& cell) {
    const RealPoint<N + 1> values = planes.values(cell.centre);
    for (int corner = 0; corner < cell_corners<N>; ++corner) {
      const CertainSides<N> sides = planes.sides(values, corner);
      int& code = cell.corners[static_cast<std::size_t>(corner)];
      if (sides.all_inside()) {
        code = points_.number(cell.simplex, corner_point(cell, corner));
        continue;
      }
      const WalkResult<N> walk =
          walk_diagonal(map_, cell.simplex, cell.centre, corner, cell.frame, sides.only_exit());
      code = walk.end == WalkEnd::reached ? vertex_at(number, corner, walk) : failed_corner(walk.end);
    }
  }

  FixedPoint<N> corner_point(const Cell<N>& cell, int corner) const {
    FixedPoint<N> q = cell.centre;
    const std::array<int, N> s = diagonal<N>(corner);
    for (std::size_t i = 0; i < N; ++i) q[i] += s[i] * (map_.one() / 2);
    return q;
  }

  int vertex_at(int number, int corner, const WalkResult<N>& walk) {
    if (walk.inside) return points_.number(walk.simplex, walk.point);
    const FacetSigns<N> signs = exact_facet_signs(map_, walk.simplex, walk.point);
    if (all_positive(signs)) return points_.number(walk.simplex, walk.point);
    out_.corners.push_back(
        {number, corner, search_.key_of(walk.simplex, walk.point, signs), walk.simplex, walk.point});
    return 0;  // set when the names are numbered
  }

  const GridMap<N>& map_;
  const InteriorPoints<N>& points_;
  PreimageSearch<N> search_;
  TracedCells<N>& out_;
};

template <int N>
void append(TracedCells<N>& all, const TracedCells<N>& part) {
  const int offset = static_cast<int>(all.cells.size());
  all.cells.insert(all.cells.end(), part.cells.begin(), part.cells.end());
  for (NamedCorner<N> corner : part.corners) {
    corner.cell += offset;
    all.corners.push_back(corner);
  }
  for (NamedCentre<N> centre : part.centres) {
    centre.cell += offset;
    all.centres.push_back(centre);
  }
}

}  // namespace detail

// All cells in ascending order of simplex; corners that are named have code 0 until they are numbered.
template <int N>
TracedCells<N> trace_cells(const GridMap<N>& map, const InteriorPoints<N>& points, int threads) {
  const auto simplices = static_cast<std::int64_t>(map.P.size());
  std::vector<TracedCells<N>> parts(static_cast<std::size_t>(chunk_count(simplices)));
  parallel_chunks(simplices, threads, [&](std::int64_t begin, std::int64_t end, std::int64_t chunk) {
    detail::CellTracer<N> tracer(map, points, parts[static_cast<std::size_t>(chunk)]);
    for (std::int64_t t = begin; t < end; ++t) tracer.trace_simplex(static_cast<int>(t));
  });
  TracedCells<N> all;
  std::size_t cells = 0;
  for (const TracedCells<N>& part : parts) cells += part.cells.size();
  if (cells > static_cast<std::size_t>(most_cells))
    throw StageError("more than " + std::to_string(most_cells) + " cells");
  all.cells.reserve(cells);
  for (TracedCells<N>& part : parts) {
    detail::append(all, part);
    part = {};
  }
  return all;
}

}  // namespace neurframe
