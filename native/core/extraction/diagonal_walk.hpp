// Walking the straight segment from a lattice point to one of the lattice points half a cell away along a
// diagonal.
//
// The segment is shifted by a symbolic perturbation e, so it meets only the interiors of facets, each
// crossing is decided by exact signs, and in every simplex there is exactly one way on.  The preimage of the
// segment is one-dimensional and every piece of it is a path: in simplices of the orientation of the start
// the walk runs forward, in those of the opposite orientation backward, through flat ones it passes on the
// spot.  So it ends at a preimage of the end point, or, where the map folds, at another preimage of the start
// point, or it leaves the mesh.
#pragma once

#include <array>
#include <optional>

#include "core/extraction/certain_sides.hpp"
#include "core/extraction/simplex_planes.hpp"

namespace neurframe {

template <int N>
inline constexpr int cell_corners = 1 << N;

// Corner c of a cell lies at centre + one half of diagonal(c); bit i of c is set where coordinate i grows.
template <int N>
constexpr std::array<int, N> diagonal(int corner) {
  std::array<int, N> s{};
  for (int i = 0; i < N; ++i) s[static_cast<std::size_t>(i)] = ((corner >> i) & 1) != 0 ? 1 : -1;
  return s;
}

// The corner that `corner` becomes in a chart turned by R.
template <int N>
constexpr int turned_corner(Rotation<N> R, int corner) {
  const std::array<int, N> s = R(diagonal<N>(corner));
  int turned = 0;
  for (int i = 0; i < N; ++i) turned |= (s[static_cast<std::size_t>(i)] > 0 ? 1 : 0) << i;
  return turned;
}

enum class WalkEnd {
  reached,   // the end point, in the closed simplex
  returned,  // another preimage of the start point, in a simplex of the opposite orientation
  boundary,  // left the mesh
  broken,    // came to a facet whose transition is not exact
  lost       // more steps than any sane path
};

template <int N>
struct WalkResult {
  WalkEnd end = WalkEnd::lost;
  int simplex = -1;
  FixedPoint<N> point{};  // the point reached or returned to, in the chart of the simplex
  Rotation<N> rotation;   // from the chart of the start to that of the simplex
  bool inside = false;    // the point is certainly strictly inside the simplex
};

namespace detail {

inline constexpr int most_walk_steps = 1'000'000;

template <int N>
class DiagonalWalk {
 public:
  // From p + Q(e) inside simplex t (not flat) to the same shift of p + diagonal(corner) / 2.
  DiagonalWalk(const GridMap<N>& map, int t, const FixedPoint<N>& p, int corner, Rotation<N> Q)
      : map_(map), simplex_(t), end_(p), s_(diagonal<N>(corner)), Q_(Q), start_orientation_(orientation()) {
    for (std::size_t i = 0; i < N; ++i) end_[i] += s_[i] * (map.one() / 2);
  }

  // first_exit: the facet that the segment leaves simplex t through, or -1 where that is not known.
  WalkResult<N> run(int first_exit) {
    int exit = first_exit;
    for (int step = 0, entry = -1; step < most_walk_steps; ++step) {
      if (exit < 0) {
        const std::optional<WalkEnd> end = find_exit(entry, exit);
        if (end) return result(*end, *end == WalkEnd::returned ? start() : end_);
      }
      const auto h = static_cast<std::size_t>((N + 1) * simplex_ + exit);
      const int across = map_.twin[h];
      if (across < 0) return at_boundary();
      if (!map_.transition[h].exact) return result(WalkEnd::broken, end_);
      cross(map_.transition[h], across / (N + 1));
      entry = across % (N + 1);
      exit = -1;
    }
    return result(WalkEnd::lost, end_);
  }

 private:
  int orientation() const { return map_.orientation[static_cast<std::size_t>(simplex_)]; }

  FixedPoint<N> start() const {
    FixedPoint<N> p = end_;
    for (std::size_t i = 0; i < N; ++i) p[i] -= s_[i] * (map_.one() / 2);
    return p;
  }

  WalkResult<N> result(WalkEnd end, const FixedPoint<N>& point) const {
    return {end, simplex_, point, rotation_, inside_};
  }

  // Sets the facet through which the walk leaves the current simplex, or returns how it ends there.  Running
  // forward, the side of the end point alone tells nearly always, and in doubles.
  std::optional<WalkEnd> find_exit(int entry, int& exit) {
    const bool forward = orientation() == start_orientation_;
    if (forward) {
      const CertainSides<N> sides = certain_sides(map_, simplex_, end_);
      inside_ = sides.all_inside();
      if (inside_) return WalkEnd::reached;
      exit = sides.only_exit();
      if (exit >= 0) return {};
    }
    exit = entry < 0 ? first_exit() : next_exit(entry);
    if (exit < 0) return WalkEnd::lost;
    if (forward && inside_of(exit, end_)) return WalkEnd::reached;
    if (orientation() == -start_orientation_ && inside_of(exit, start())) return WalkEnd::returned;
    return {};
  }

  auto seen_corners(const DiagonalView<N>& view) const {
    const auto& P = map_.P[static_cast<std::size_t>(simplex_)];
    std::array<decltype(view(P[0])), N + 1> seen{};
    for (std::size_t i = 0; i <= N; ++i) seen[i] = view(P[i]);
    return seen;
  }

  // The facet of the first simplex that the segment leaves through.
  int first_exit() const {
    const DiagonalView<N> view(end_, s_, Q_);
    const auto x = seen_corners(view);
    for (std::size_t facet = 0; facet <= N; ++facet) {
      const auto corner = [&](std::size_t k) {
        return static_cast<std::size_t>(Dimension<N>::facet_corners[facet][k % N]);
      };
      bool leaves = true;
      if constexpr (N == 3) {
        for (std::size_t k = 0; k < 3 && leaves; ++k) {
          leaves = view.turn(x[corner(k)], x[corner(k + 1)]) == start_orientation_;
        }
      } else {
        leaves = x[corner(0)] == -start_orientation_ && x[corner(1)] == start_orientation_;
      }
      if (leaves) return static_cast<int>(facet);
    }
    return -1;
  }

  // The other facet that the line meets, having come in through `entry`.  Seen along the line, the entry
  // facet turns against start_orientation_ in every simplex, because facets are crossed from behind to front.
  int next_exit(int entry) const {
    const DiagonalView<N> view(end_, s_, Q_);
    const auto x = seen_corners(view);
    const auto opposite =
        static_cast<std::size_t>(Dimension<N>::opposite_corner[static_cast<std::size_t>(entry)]);
    if constexpr (N == 2) {
      return x[opposite] == start_orientation_ ? (entry + 1) % 3 : (entry + 2) % 3;
    } else {
      const auto& corners = face_corners[static_cast<std::size_t>(entry)];
      std::array<int, 3> turn{};
      for (std::size_t k = 0; k < 3; ++k)
        turn[k] = view.turn(x[opposite], x[static_cast<std::size_t>(corners[k])]);
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t next = (k + 1) % 3;
        if (turn[k] == -start_orientation_ && turn[next] == start_orientation_) return corners[(k + 2) % 3];
      }
      return -1;
    }
  }

  // True when p + e lies on the inner side of a facet of the current simplex.
  bool inside_of(int facet, const FixedPoint<N>& p) const {
    return outer_side<N>(facet_points(map_, (N + 1) * simplex_ + facet), p, Q_) * orientation() < 0;
  }

  // An end point on the boundary may be pushed out of the mesh by the perturbation.  Then the walk leaves
  // where the end point is, perhaps through flat simplices, and the last one that it ran forward in holds the
  // end point.
  WalkResult<N> at_boundary() const {
    const WalkResult<N> last =
        orientation() == start_orientation_ ? result(WalkEnd::reached, end_) : last_forward_;
    const FacetSigns<N> signs = exact_facet_signs(map_, last.simplex, last.point);
    return none_negative(signs) ? last : result(WalkEnd::boundary, end_);
  }

  void cross(const FacetTransition<N>& transition, int simplex) {
    if (orientation() == start_orientation_ &&
        map_.orientation[static_cast<std::size_t>(simplex)] != start_orientation_)
      last_forward_ = result(WalkEnd::reached, end_);
    simplex_ = simplex;
    end_ = carry(transition, end_, map_.fraction_bits);
    if (transition.rotation == Rotation<N>{}) return;
    s_ = transition.rotation(s_);
    Q_ = transition.rotation * Q_;
    rotation_ = transition.rotation * rotation_;
  }

  const GridMap<N>& map_;
  int simplex_;
  FixedPoint<N> end_;
  std::array<int, N> s_;
  Rotation<N> Q_;
  Rotation<N> rotation_;
  int start_orientation_;
  bool inside_ = false;
  WalkResult<N> last_forward_;
};

}  // namespace detail

// first_exit: the facet that the segment leaves simplex t through, where that is known already.
template <int N>
WalkResult<N> walk_diagonal(const GridMap<N>& map, int t, const FixedPoint<N>& p, int corner,
                            std::type_identity_t<Rotation<N>> Q, int first_exit = -1) {
  return detail::DiagonalWalk<N>(map, t, p, corner, Q).run(first_exit);
}

}  // namespace neurframe
