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

#include "core/extraction/fixed_space.hpp"
#include "core/extraction/grid_map.hpp"
#include "core/extraction/recover_transitions.hpp"
#include "core/extraction/vertex_stars.hpp"
#include "core/parallel.hpp"

namespace neurframe {

struct SeamlessReport {
  double largest_move = 0.0;       // in cells, over all corners
  int contradictory_vertices = 0;  // no point satisfies the conditions of the star
  int broken_facets = 0;           // interior facets whose transition is not exact
};

namespace detail {

// One connected part of the star of a vertex, with the transition from its first chart to each of its charts.
template <int N>
struct StarSheet {
  std::vector<int> corners;
  std::vector<GridTransition<N>> from_master;
};

template <int N>
class StarWalker {
 public:
  StarWalker(const GridMap<N>& map, const RecoveredTransitions<N>& found, const RealParameters<N>& real)
      : map_(map), found_(found), real_(real) {}

  // Sets the parameters of all corners of a star; returns the largest move, or -1 on a contradiction.
  double settle(std::span<const int> star, std::vector<std::array<FixedPoint<N>, N + 1>>& P) {
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
    for (int i = 0; i <= N; ++i) {
      const int h = corner - corner % (N + 1) + i;
      const int across = map_.twin[static_cast<std::size_t>(h)];
      if (is_opposite(h, corner) || across < 0 ||
          found_.transition[static_cast<std::size_t>(h)].ambiguous != ambiguous)
        continue;
      const int next = corner_across(corner, across);
      const auto waiting = std::lower_bound(pending_.begin(), pending_.end(), next);
      if (waiting == pending_.end() || *waiting != next) continue;
      pending_.erase(waiting);
      sheet_.corners.push_back(next);
      sheet_.from_master.push_back(transition(h) * sheet_.from_master[place]);
    }
  }

  // True when the facet is the one opposite to the corner, in one simplex.
  static bool is_opposite(int facet, int corner) {
    return Dimension<N>::opposite_corner[static_cast<std::size_t>(facet % (N + 1))] == corner % (N + 1);
  }

  int corner_across(int corner, int across) const {
    const auto t = static_cast<std::size_t>(corner / (N + 1));
    const int vertex = map_.S[t][static_cast<std::size_t>(corner % (N + 1))];
    return across - across % (N + 1) + corner_at(map_.S[static_cast<std::size_t>(across / (N + 1))], vertex);
  }

  GridTransition<N> transition(int h) const {
    return as_grid_transition(found_.transition[static_cast<std::size_t>(h)]);
  }

  double settle_sheet(std::vector<std::array<FixedPoint<N>, N + 1>>& P, bool& consistent) const {
    FixedSpace<N> space(map_.one());
    for (std::size_t place = 0; place < sheet_.corners.size(); ++place) {
      consistent = add_conditions(place, space) && consistent;
    }
    const FixedPoint<N> master = space.project(rounded(sheet_.corners[0]));
    double move = 0.0;
    for (std::size_t place = 0; place < sheet_.corners.size(); ++place) {
      const int corner = sheet_.corners[place];
      const FixedPoint<N> value = sheet_.from_master[place](master, map_.one());
      for (const Fixed d : difference(value, rounded(corner))) {
        move = std::max(move, std::abs(from_fixed(d, map_.fraction_bits)));
      }
      P[static_cast<std::size_t>(corner / (N + 1))][static_cast<std::size_t>(corner % (N + 1))] = value;
    }
    return move;
  }

  bool add_conditions(std::size_t place, FixedSpace<N>& space) const {
    const int corner = sheet_.corners[place];
    const GridTransition<N> to_master = sheet_.from_master[place].inverse();
    bool consistent = true;
    for (int i = 0; i <= N; ++i) {
      const int h = corner - corner % (N + 1) + i;
      if (is_opposite(h, corner)) continue;
      const int across = map_.twin[static_cast<std::size_t>(h)];
      if (across < 0) {
        consistent = add_boundary_plane(h, to_master, space) && consistent;
      } else if (across > h && !found_.transition[static_cast<std::size_t>(h)].ambiguous) {
        const std::size_t other = place_of(corner_across(corner, across));
        const GridTransition<N> loop =
            sheet_.from_master[other].inverse() * transition(h) * sheet_.from_master[place];
        if (loop != GridTransition<N>{}) consistent = space.require_fixed_by(loop) && consistent;
      }
    }
    return consistent;
  }

  bool add_boundary_plane(int h, const GridTransition<N>& to_master, FixedSpace<N>& space) const {
    const BoundaryPlane& plane = found_.boundary[static_cast<std::size_t>(h)];
    if (plane.axis < 0) return true;
    FixedPoint<N> direction{};
    direction[static_cast<std::size_t>(plane.axis)] = 1;
    FixedPoint<N> point{};
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

  FixedPoint<N> rounded(int corner) const {
    const auto& corners = real_[static_cast<std::size_t>(corner / (N + 1))];
    FixedPoint<N> lattice{};
    for (std::size_t k = 0; k < N; ++k) {
      lattice[k] = to_fixed(corners[static_cast<std::size_t>(corner % (N + 1))][k], map_.fraction_bits);
    }
    return lattice;
  }

  const GridMap<N>& map_;
  const RecoveredTransitions<N>& found_;
  const RealParameters<N>& real_;
  std::vector<int> pending_;  // ascending
  StarSheet<N> sheet_;
};

// Marks the transitions that map the corners of their facet exactly; returns the number of facets that fail.
template <int N>
int mark_exact_transitions(GridMap<N>& map) {
  int broken = 0;
  for (std::size_t i = 0; i < map.twin.size(); ++i) {
    const int other = map.twin[i];
    const int h = static_cast<int>(i);
    if (other < h) continue;
    const auto s = static_cast<std::size_t>(other / (N + 1));
    const std::array<int, N> vertices = facet_vertices<N>(map.S, h);
    const std::array<FixedPoint<N>, N> points = facet_points(map, h);
    bool exact = true;
    for (std::size_t k = 0; k < N; ++k) {
      const auto corner = static_cast<std::size_t>(corner_at(map.S[s], vertices[k]));
      exact = exact && carry(map.transition[i], points[k], map.fraction_bits) == map.P[s][corner];
    }
    broken += exact ? 0 : 1;
    map.transition[i].exact = map.transition[static_cast<std::size_t>(other)].exact = exact;
  }
  return broken;
}

}  // namespace detail

// Fills map.P and map.transition from the real parameters.
template <int N>
SeamlessReport make_seamless(const RealParameters<N>& real, const RecoveredTransitions<N>& found, int threads,
                             GridMap<N>& map) {
  const VertexStars stars = vertex_stars(map);
  map.P.resize(map.S.size());
  std::vector<double> moves(map.V.size(), 0.0);
  parallel_chunks(static_cast<std::int64_t>(moves.size()), threads,
                  [&](std::int64_t begin, std::int64_t end, std::int64_t) {
                    detail::StarWalker<N> walker(map, found, real);
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
  report.broken_facets = detail::mark_exact_transitions(map);
  return report;
}

}  // namespace neurframe
