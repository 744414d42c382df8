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
#include <span>
#include <utility>
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

// The star of a vertex falls into sheets, connected through facets; corners go by their place in the star.
template <int N>
class StarWalker {
 public:
  StarWalker(const GridMap<N>& map, const VertexStars& stars, const RecoveredTransitions<N>& found,
             const RealParameters<N>& real)
      : map_(map), stars_(stars), found_(found), real_(real), one_(static_cast<double>(map.one())) {}

  // Sets the parameters of all corners around a vertex; returns the largest move, or -1 on a contradiction.
  double settle(std::size_t vertex, std::vector<std::array<FixedPoint<N>, N + 1>>& P) {
    star_ = stars_.of(vertex);
    visited_.assign(star_.size(), 0);
    from_master_.resize(star_.size());
    find_neighbours();
    waiting_ = star_.size();
    double move = 0.0;
    bool consistent = true;
    for (std::size_t first = 0; waiting_ > 0; ++first) {
      if (visited_[first] != 0) continue;
      collect_sheet(first);
      const double moved = settle_sheet(P, consistent);
      move = std::max(move, moved);
    }
    return consistent ? move : -1.0;
  }

 private:
  // The places behind the facets of every corner: on_boundary where there is none, no_facet for the facet
  // opposite to the corner.
  void find_neighbours() {
    neighbours_.resize(star_.size());
    for (std::size_t place = 0; place < star_.size(); ++place) {
      const int corner = star_[place];
      for (int i = 0; i <= N; ++i) {
        const int h = facet(place, i);
        const int across = map_.twin[static_cast<std::size_t>(h)];
        int& neighbour = neighbours_[place][static_cast<std::size_t>(i)];
        neighbour = on_boundary;
        if (is_opposite(h, corner)) {
          neighbour = no_facet;
        } else if (across >= 0) {
          neighbour = place_across(corner, across);
        }
      }
    }
  }

  // Breadth first, through faces with a certain rotation while there are any, then through ambiguous ones.
  void collect_sheet(std::size_t first) {
    sheet_.clear();
    visit(first, {});
    for (std::size_t certain = 0, any = 0; any < sheet_.size() && waiting_ > 0;) {
      if (certain < sheet_.size()) {
        visit_neighbours(sheet_[certain++], false);
      } else {
        visit_neighbours(sheet_[any++], true);
      }
    }
  }

  void visit(std::size_t place, const GridTransition<N>& from_master) {
    sheet_.push_back(place);
    visited_[place] = 1;
    from_master_[place] = from_master;
    --waiting_;
  }

  void visit_neighbours(std::size_t place, bool ambiguous) {
    for (int i = 0; i <= N; ++i) {
      const int next = neighbours_[place][static_cast<std::size_t>(i)];
      if (next < 0 || visited_[static_cast<std::size_t>(next)] != 0) continue;
      const int h = facet(place, i);
      if (found_.transition[static_cast<std::size_t>(h)].ambiguous == ambiguous)
        visit(static_cast<std::size_t>(next), transition(h) * from_master_[place]);
    }
  }

  int facet(std::size_t place, int i) const { return star_[place] - star_[place] % (N + 1) + i; }

  // True when the facet is the one opposite to the corner, in one simplex.
  static bool is_opposite(int facet, int corner) {
    return Dimension<N>::opposite_corner[static_cast<std::size_t>(facet % (N + 1))] == corner % (N + 1);
  }

  // The same vertex in the simplex behind a facet.
  int place_across(int corner, int across) const {
    const auto t = static_cast<std::size_t>(corner / (N + 1));
    const int vertex = map_.S[t][static_cast<std::size_t>(corner % (N + 1))];
    const int behind = across / (N + 1);
    const int other = (N + 1) * behind + corner_at(map_.S[static_cast<std::size_t>(behind)], vertex);
    return stars_.place[static_cast<std::size_t>(other)];
  }

  GridTransition<N> transition(int h) const {
    return as_grid_transition(found_.transition[static_cast<std::size_t>(h)]);
  }

  double settle_sheet(std::vector<std::array<FixedPoint<N>, N + 1>>& P, bool& consistent) const {
    FixedSpace<N> space(map_.one());
    for (const std::size_t place : sheet_) consistent = add_conditions(place, space) && consistent;
    const FixedPoint<N> master = space.project(rounded(star_[sheet_[0]]));
    double move = 0.0;
    for (const std::size_t place : sheet_) {
      const int corner = star_[place];
      const FixedPoint<N> value = from_master_[place](master, map_.one());
      for (const Fixed d : difference(value, rounded(corner))) {
        move = std::max(move, std::abs(static_cast<double>(d)) / one_);
      }
      P[static_cast<std::size_t>(corner / (N + 1))][static_cast<std::size_t>(corner % (N + 1))] = value;
    }
    return move;
  }

  bool add_conditions(std::size_t place, FixedSpace<N>& space) const {
    bool consistent = true;
    for (int i = 0; i <= N; ++i) {
      const int other = neighbours_[place][static_cast<std::size_t>(i)];
      const int h = facet(place, i);
      if (other == on_boundary) {
        consistent = add_boundary_plane(h, from_master_[place].inverse(), space) && consistent;
      } else if (other != no_facet && map_.twin[static_cast<std::size_t>(h)] > h &&
                 !found_.transition[static_cast<std::size_t>(h)].ambiguous) {
        consistent = add_loop(place, h, static_cast<std::size_t>(other), space) && consistent;
      }
    }
    return consistent;
  }

  // From the master to one chart, across its facet h to another, and back.
  bool add_loop(std::size_t place, int h, std::size_t other, FixedSpace<N>& space) const {
    const GridTransition<N> there = transition(h) * from_master_[place];
    if (there == from_master_[other]) return true;
    return space.require_fixed_by(from_master_[other].inverse() * there);
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

  FixedPoint<N> rounded(int corner) const {
    const auto& corners = real_[static_cast<std::size_t>(corner / (N + 1))];
    FixedPoint<N> lattice{};
    for (std::size_t k = 0; k < N; ++k) {
      lattice[k] = nearest(corners[static_cast<std::size_t>(corner % (N + 1))][k] * one_);
    }
    return lattice;
  }

  // std::llround for |x| < 2^52, without the call.
  static Fixed nearest(double x) {
    const auto whole = static_cast<Fixed>(x);
    const double rest = x - static_cast<double>(whole);
    return whole + (rest >= 0.5 ? 1 : 0) - (rest <= -0.5 ? 1 : 0);
  }

  static constexpr int on_boundary = -1;
  static constexpr int no_facet = -2;

  const GridMap<N>& map_;
  const VertexStars& stars_;
  const RecoveredTransitions<N>& found_;
  const RealParameters<N>& real_;
  double one_;
  std::span<const int> star_;
  std::vector<std::array<int, N + 1>> neighbours_;  // per place and facet
  std::vector<char> visited_;                       // per place
  std::vector<GridTransition<N>> from_master_;      // per place
  std::size_t waiting_ = 0;                         // places not visited yet
  std::vector<std::size_t> sheet_;                  // places in the order of the visits, the master first
};

// True when the transition across facet h maps the corners of the facet exactly.
template <int N>
bool is_exact(const GridMap<N>& map, int h) {
  const auto s = static_cast<std::size_t>(map.twin[static_cast<std::size_t>(h)] / (N + 1));
  const std::array<int, N> vertices = facet_vertices<N>(map.S, h);
  const std::array<FixedPoint<N>, N> points = facet_points(map, h);
  const FacetTransition<N>& transition = map.transition[static_cast<std::size_t>(h)];
  bool exact = true;
  for (std::size_t k = 0; k < N; ++k) {
    const auto corner = static_cast<std::size_t>(corner_at(map.S[s], vertices[k]));
    exact = exact && carry(transition, points[k], map.fraction_bits) == map.P[s][corner];
  }
  return exact;
}

// Marks the transitions that are exact; returns the number of facets that fail.
template <int N>
int mark_exact_transitions(GridMap<N>& map, int threads) {
  const auto facets = static_cast<std::int64_t>(map.twin.size());
  const std::vector<int> broken =
      parallel_collect<int>(facets, threads, [&](std::int64_t begin, std::int64_t end, auto& failed) {
        for (int h = static_cast<int>(begin); h < end; ++h) {
          const int other = map.twin[static_cast<std::size_t>(h)];
          if (other < h) continue;
          const bool exact = is_exact(map, h);
          if (!exact) failed.push_back(h);
          map.transition[static_cast<std::size_t>(h)].exact = exact;
          map.transition[static_cast<std::size_t>(other)].exact = exact;
        }
      });
  return static_cast<int>(broken.size());
}

}  // namespace detail

// Fills map.P and map.transition from the real parameters.
template <int N>
SeamlessReport make_seamless(const RealParameters<N>& real, RecoveredTransitions<N> found, int threads,
                             GridMap<N>& map) {
  const VertexStars stars = vertex_stars(map);
  map.P.resize(map.S.size());
  std::vector<double> moves(map.V.size(), 0.0);
  parallel_chunks(static_cast<std::int64_t>(moves.size()), threads,
                  [&](std::int64_t begin, std::int64_t end, std::int64_t) {
                    detail::StarWalker<N> walker(map, stars, found, real);
                    for (std::int64_t v = begin; v < end; ++v) {
                      moves[static_cast<std::size_t>(v)] = walker.settle(static_cast<std::size_t>(v), map.P);
                    }
                  });
  SeamlessReport report;
  for (const double move : moves) {
    report.contradictory_vertices += move < 0.0 ? 1 : 0;
    report.largest_move = std::max(report.largest_move, move);
  }
  map.transition = std::move(found.transition);
  report.broken_facets = detail::mark_exact_transitions(map, threads);
  return report;
}

}  // namespace neurframe
