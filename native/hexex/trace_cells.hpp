// The preimages of cell centres, and for each of them where the walks to the eight corners of the cell end.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/parallel.hpp"
#include "hexex/diagonal_walk.hpp"
#include "hexex/interior_points.hpp"
#include "hexex/lattice_points.hpp"
#include "hexex/preimage.hpp"

namespace neurframe {

// Corner codes: a vertex number, or minus one minus the WalkEnd that kept the walk from arriving.
constexpr int failed_corner(WalkEnd end) {
  return -1 - static_cast<int>(end);
}
constexpr WalkEnd failure_of(int code) {
  return static_cast<WalkEnd>(-1 - code);
}

struct Cell {
  int tet;
  FixedPoint3 centre;        // in the chart of tet
  OctahedralRotation frame;  // the perturbation Q in the chart of tet
  std::int8_t sign;          // 1, -1 in a flipped tet, 0 where the class of the cell has to tell
  std::array<int, 8> corners;
};

// A vertex that is not strictly inside a tet: its name, and a tet that is not flat with the vertex in its
// chart.
struct NamedCorner {
  int cell;
  int corner;
  PlaceKey key;
  int tet;
  FixedPoint3 point;
};

// A cell whose centre lies between tets, under the name of that place.
struct NamedCentre {
  int cell;
  PlaceKey key;
};

struct TracedCells {
  std::vector<Cell> cells;
  std::vector<NamedCorner> corners;
  std::vector<NamedCentre> centres;
};

namespace detail {

inline FaceSigns exact_face_signs(const GridMap& map, int t, const FixedPoint3& p) {
  FaceSigns signs{};
  for (int face = 0; face < 4; ++face)
    signs[static_cast<std::size_t>(face)] = exact_face_sign(map, t, face, p);
  return signs;
}

// True when p + Q(e) is inside tet t, for a point p of the closed tet with these face signs.
inline bool perturbed_inside(const GridMap& map, int t, const FixedPoint3& p, const FaceSigns& signs,
                             OctahedralRotation Q) {
  for (int face = 0; face < 4; ++face) {
    if (signs[static_cast<std::size_t>(face)] != 0) continue;
    const int h = 4 * t + face;
    const int side = plane_side(face_corner(map, h, 0), face_corner(map, h, 1), face_corner(map, h, 2), p, Q);
    if (side * map.orientation[static_cast<std::size_t>(t)] >= 0) return false;
  }
  return true;
}

class CellTracer {
 public:
  CellTracer(const GridMap& map, const InteriorPoints& points, TracedCells& out)
      : map_(map), points_(points), search_(map), out_(out) {}

  void trace_tet(int t) {
    const Fixed half = map_.one() / 2;
    const LatticeBox box = lattice_box(map_, t, half);
    if (box.empty() || map_.orientation[static_cast<std::size_t>(t)] == 0) return;
    const TetPlanes planes(map_, t);
    for_each_column(planes, box, map_.one(), half, [&](std::int64_t x, std::int64_t y, Interval column) {
      for (std::int64_t z = column.begin; z < column.end; ++z) {
        const FixedPoint3 p{x * map_.one() + half, y * map_.one() + half, z * map_.one() + half};
        const FaceSigns signs = planes.signs(p);
        if (none_negative(signs)) add_cell(t, p, signs, planes);
      }
    });
  }

 private:
  void add_cell(int t, const FixedPoint3& p, const FaceSigns& signs, const TetPlanes& planes) {
    const int number = static_cast<int>(out_.cells.size());
    Cell cell{t, p, {}, map_.orientation[static_cast<std::size_t>(t)], {}};
    if (!all_positive(signs)) {
      if (!owns_tie(t, p, signs, cell)) return;
      out_.centres.push_back({number, search_.key_of(t, p, signs)});
    }
    for (int corner = 0; corner < 8; ++corner) {
      int& code = cell.corners[static_cast<std::size_t>(corner)];
      code = cell.sign == 0 ? failed_corner(WalkEnd::returned) : trace_corner(number, cell, corner, planes);
    }
    out_.cells.push_back(cell);
  }

  // A centre between tets belongs to the tet that holds it after the perturbation, which the lowest tet
  // defines. Next to flat or flipped tets there may be none or several: the lowest that is not flat keeps the
  // cell for later.
  bool owns_tie(int t, const FixedPoint3& p, const FaceSigns& signs, Cell& cell) {
    const std::vector<PreimageVisit>& visits = search_.visits(t, p);
    const PreimageVisit* lowest = nullptr;
    bool sound = true;
    for (const PreimageVisit& visit : visits) {
      const int orientation = map_.orientation[static_cast<std::size_t>(visit.tet)];
      sound = sound && orientation > 0;
      if (orientation != 0 && (lowest == nullptr || visit.tet < lowest->tet)) lowest = &visit;
    }
    if (!sound) cell.sign = 0;
    if (!sound) return lowest->tet == t;
    cell.frame = lowest->rotation.inverse();
    return perturbed_inside(map_, t, p, signs, cell.frame);
  }

  int trace_corner(int number, const Cell& cell, int corner, const TetPlanes& planes) {
    FixedPoint3 q = cell.centre;
    const std::array<int, 3> s = diagonal(corner);
    for (std::size_t i = 0; i < 3; ++i) q[i] += s[i] * (map_.one() / 2);
    bool inside = true;
    for (std::size_t face = 0; face < 4; ++face) inside = inside && planes.value(face, q) > planes.error();
    if (inside) return points_.number(cell.tet, q);
    const WalkResult walk = walk_diagonal(map_, cell.tet, cell.centre, corner, cell.frame);
    return walk.end == WalkEnd::reached ? vertex_at(number, corner, walk) : failed_corner(walk.end);
  }

  int vertex_at(int number, int corner, const WalkResult& walk) {
    const FaceSigns signs = exact_face_signs(map_, walk.tet, walk.point);
    if (all_positive(signs)) return points_.number(walk.tet, walk.point);
    out_.corners.push_back(
        {number, corner, search_.key_of(walk.tet, walk.point, signs), walk.tet, walk.point});
    return 0;  // set when the names are numbered
  }

  const GridMap& map_;
  const InteriorPoints& points_;
  PreimageSearch search_;
  TracedCells& out_;
};

inline void append(TracedCells& all, const TracedCells& part) {
  const int offset = static_cast<int>(all.cells.size());
  all.cells.insert(all.cells.end(), part.cells.begin(), part.cells.end());
  for (NamedCorner corner : part.corners) {
    corner.cell += offset;
    all.corners.push_back(corner);
  }
  for (NamedCentre centre : part.centres) {
    centre.cell += offset;
    all.centres.push_back(centre);
  }
}

}  // namespace detail

// All cells in ascending order of tet; corners that are named have code 0 until they are numbered.
inline TracedCells trace_cells(const GridMap& map, const InteriorPoints& points, int threads) {
  const auto tets = static_cast<std::int64_t>(map.P.size());
  std::vector<TracedCells> parts(static_cast<std::size_t>(chunk_count(tets)));
  parallel_chunks(tets, threads, [&](std::int64_t begin, std::int64_t end, std::int64_t chunk) {
    detail::CellTracer tracer(map, points, parts[static_cast<std::size_t>(chunk)]);
    for (std::int64_t t = begin; t < end; ++t) tracer.trace_tet(static_cast<int>(t));
  });
  TracedCells all;
  std::size_t cells = 0;
  for (const TracedCells& part : parts) cells += part.cells.size();
  if (cells > static_cast<std::size_t>(most_tets))
    throw StageError("more than " + std::to_string(most_tets) + " cells");
  all.cells.reserve(cells);
  for (TracedCells& part : parts) {
    detail::append(all, part);
    part = {};
  }
  return all;
}

}  // namespace neurframe
