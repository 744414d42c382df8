// Exactly seamless fixed-point parameters, vertex by vertex.
//
// For each vertex one chart of its star is the master.  A tree of faces carries the master's value to the
// other charts through the transition functions, which map the fixed-point lattice onto itself without
// rounding; every face of the star that is not in the tree closes a loop, and the value must be a fixed point
// of it; a boundary face puts one coordinate on an integer.  FixedSpace solves these conditions exactly,
// singular edges included, because the loops round them are among the loops of the star.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/hex_map_io.hpp"
#include "core/parallel.hpp"
#include "hexex/fixed_space.hpp"
#include "hexex/grid_map.hpp"
#include "hexex/recover_transitions.hpp"
#include "hexex/vertex_stars.hpp"

namespace neurframe {

struct SeamlessReport {
  double largest_move = 0.0;       // in cells, over all corners
  int contradictory_vertices = 0;  // no point satisfies the conditions of the star
  int broken_faces = 0;            // interior faces whose transition is not exact
};

namespace detail {

// One connected part of the star of a vertex, with the transition from its first chart to each of its charts.
struct StarSheet {
  std::vector<int> corners;
  std::vector<GridTransition3> from_master;
};

class StarWalker {
 public:
  StarWalker(const GridMap& map, const RecoveredTransitions& found, const HexMap& real)
      : map_(map), found_(found), real_(real) {}

  // Sets the parameters of all corners of a star; returns the largest move, or -1 on a contradiction.
  double settle(std::span<const int> star, std::vector<std::array<FixedPoint3, 4>>& P) {
    double move = 0.0;
    bool consistent = true;
    pending_.assign(star.begin(), star.end());
    while (!pending_.empty()) {
      collect_sheet();
      const double moved = settle_sheet(P, consistent);
      move = std::max(move, moved);
    }
    return consistent ? move : -1.0;
  }

 private:
  // Breadth first, through faces with a certain rotation while there are any, then through ambiguous ones.
  void collect_sheet() {
    sheet_.corners.assign(1, pending_.front());
    sheet_.from_master.assign(1, {});
    pending_.erase(pending_.begin());
    for (std::size_t certain = 0, any = 0; any < sheet_.corners.size();) {
      if (certain < sheet_.corners.size()) {
        visit_neighbours(certain++, false);
      } else {
        visit_neighbours(any++, true);
      }
    }
  }

  void visit_neighbours(std::size_t place, bool ambiguous) {
    const int corner = sheet_.corners[place];
    for (int i = 0; i < 4; ++i) {
      const int h = corner - corner % 4 + i;
      const int across = map_.twin[static_cast<std::size_t>(h)];
      if (h == corner || across < 0 || found_.transition[static_cast<std::size_t>(h)].ambiguous != ambiguous)
        continue;
      const int next = corner_across(corner, across);
      const auto waiting = std::lower_bound(pending_.begin(), pending_.end(), next);
      if (waiting == pending_.end() || *waiting != next) continue;
      pending_.erase(waiting);
      sheet_.corners.push_back(next);
      sheet_.from_master.push_back(transition(h) * sheet_.from_master[place]);
    }
  }

  int corner_across(int corner, int across) const {
    const auto t = static_cast<std::size_t>(corner / 4);
    const int vertex = map_.mesh.T[t][static_cast<std::size_t>(corner % 4)];
    return across - across % 4 + corner_of(map_.mesh.T[static_cast<std::size_t>(across / 4)], vertex);
  }

  GridTransition3 transition(int h) const {
    return as_grid_transition(found_.transition[static_cast<std::size_t>(h)]);
  }

  double settle_sheet(std::vector<std::array<FixedPoint3, 4>>& P, bool& consistent) const {
    FixedSpace space(map_.one());
    for (std::size_t place = 0; place < sheet_.corners.size(); ++place) {
      consistent = add_conditions(place, space) && consistent;
    }
    const FixedPoint3 master = space.project(rounded(sheet_.corners[0]));
    double move = 0.0;
    for (std::size_t place = 0; place < sheet_.corners.size(); ++place) {
      const int corner = sheet_.corners[place];
      const FixedPoint3 value = sheet_.from_master[place](master, map_.one());
      for (const Fixed d : difference(value, rounded(corner))) {
        move = std::max(move, std::abs(from_fixed(d, map_.fraction_bits)));
      }
      P[static_cast<std::size_t>(corner / 4)][static_cast<std::size_t>(corner % 4)] = value;
    }
    return move;
  }

  bool add_conditions(std::size_t place, FixedSpace& space) const {
    const int corner = sheet_.corners[place];
    const GridTransition3 to_master = sheet_.from_master[place].inverse();
    bool consistent = true;
    for (int i = 0; i < 4; ++i) {
      const int h = corner - corner % 4 + i;
      if (h == corner) continue;
      const int across = map_.twin[static_cast<std::size_t>(h)];
      if (across < 0) {
        consistent = add_boundary_plane(h, to_master, space) && consistent;
      } else if (across > h && !found_.transition[static_cast<std::size_t>(h)].ambiguous) {
        const std::size_t other = place_of(corner_across(corner, across));
        const GridTransition3 loop =
            sheet_.from_master[other].inverse() * transition(h) * sheet_.from_master[place];
        if (loop != GridTransition3{}) consistent = space.require_fixed_by(loop) && consistent;
      }
    }
    return consistent;
  }

  bool add_boundary_plane(int h, const GridTransition3& to_master, FixedSpace& space) const {
    const BoundaryPlane& plane = found_.boundary[static_cast<std::size_t>(h)];
    if (plane.axis < 0) return true;
    FixedPoint3 direction{0, 0, 0};
    direction[static_cast<std::size_t>(plane.axis)] = 1;
    FixedPoint3 point{0, 0, 0};
    point[static_cast<std::size_t>(plane.axis)] = plane.value;
    direction = to_master.rotation(direction);
    point = to_master(point, Fixed{1});
    std::size_t axis = 0;
    while (direction[axis] == 0) ++axis;
    return space.require_value(axis, point[axis] * map_.one());
  }

  std::size_t place_of(int corner) const {
    return static_cast<std::size_t>(std::find(sheet_.corners.begin(), sheet_.corners.end(), corner) -
                                    sheet_.corners.begin());
  }

  FixedPoint3 rounded(int corner) const {
    const Point3& u =
        real_.parameters[static_cast<std::size_t>(corner / 4)][static_cast<std::size_t>(corner % 4)];
    return {to_fixed(u[0], map_.fraction_bits), to_fixed(u[1], map_.fraction_bits),
            to_fixed(u[2], map_.fraction_bits)};
  }

  const GridMap& map_;
  const RecoveredTransitions& found_;
  const HexMap& real_;
  std::vector<int> pending_;  // ascending
  StarSheet sheet_;
};

// Marks the transitions that map the three corners of their face exactly; returns the number of faces that
// fail.
inline int mark_exact_transitions(GridMap& map) {
  int broken = 0;
  for (std::size_t i = 0; i < map.twin.size(); ++i) {
    const int other = map.twin[i];
    if (other < static_cast<int>(i)) continue;
    const int h = static_cast<int>(i);
    const std::array<int, 3> vertices = half_face_vertices(map.mesh.T, h);
    bool exact = true;
    for (int k = 0; k < 3; ++k) {
      const auto s = static_cast<std::size_t>(other / 4);
      const auto corner =
          static_cast<std::size_t>(corner_of(map.mesh.T[s], vertices[static_cast<std::size_t>(k)]));
      exact =
          exact && carry(map.transition[i], face_corner(map, h, k), map.fraction_bits) == map.P[s][corner];
    }
    broken += exact ? 0 : 1;
    map.transition[i].exact = map.transition[static_cast<std::size_t>(other)].exact = exact;
  }
  return broken;
}

}  // namespace detail

// Fills map.P and the exactness of map.transition from the real parameters.
inline SeamlessReport make_seamless(const HexMap& real, const RecoveredTransitions& found, int threads,
                                    GridMap& map) {
  const VertexStars stars = vertex_stars(map.mesh);
  map.P.resize(map.mesh.T.size());
  std::vector<double> moves(map.mesh.V.size(), 0.0);
  parallel_chunks(static_cast<std::int64_t>(moves.size()), threads,
                  [&](std::int64_t begin, std::int64_t end, std::int64_t) {
                    detail::StarWalker walker(map, found, real);
                    for (std::int64_t v = begin; v < end; ++v) {
                      moves[static_cast<std::size_t>(v)] =
                          walker.settle(stars.of(static_cast<std::size_t>(v)), map.P);
                    }
                  });
  SeamlessReport report;
  for (const double move : moves) {
    report.contradictory_vertices += move < 0.0 ? 1 : 0;
    report.largest_move = std::max(report.largest_move, move);
  }
  map.transition = found.transition;
  report.broken_faces = detail::mark_exact_transitions(map);
  return report;
}

}  // namespace neurframe
