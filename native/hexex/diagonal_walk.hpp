// Walking the straight segment from a lattice point to one of the eight lattice points half a cell away.
//
// The segment is shifted by a symbolic perturbation e, so it meets only the interiors of faces, each crossing
// is decided by exact signs, and in every tet there is exactly one way on.  The map restricted to the
// preimage of the segment is one-dimensional and every piece of it is a path: in tets of the orientation of
// the start the walk runs forward, in tets of the opposite orientation backward, through flat ones it passes
// on the spot.  So it ends at a preimage of the end point, or, where the map folds, at another preimage of
// the start point, or it leaves the mesh.
#pragma once

#include <array>

#include "hexex/tet_planes.hpp"

namespace neurframe {

// Corner c of a cell lies at centre + one half of diagonal(c); bit i of c is set where coordinate i grows.
constexpr std::array<int, 3> diagonal(int corner) {
  return {(corner & 1) != 0 ? 1 : -1, (corner & 2) != 0 ? 1 : -1, (corner & 4) != 0 ? 1 : -1};
}

// The corner that `corner` becomes in a chart turned by R.
constexpr int turned_corner(OctahedralRotation R, int corner) {
  const std::array<int, 3> s = R(diagonal(corner));
  return (s[0] > 0 ? 1 : 0) | (s[1] > 0 ? 2 : 0) | (s[2] > 0 ? 4 : 0);
}

enum class WalkEnd {
  reached,   // the end point, in the closed tet
  returned,  // another preimage of the start point, in a tet of the opposite orientation
  boundary,  // left the mesh
  broken,    // came to a face whose transition is not exact
  lost       // more steps than any sane path
};

struct WalkResult {
  WalkEnd end = WalkEnd::lost;
  int tet = -1;
  FixedPoint3 point{0, 0, 0};   // the point reached or returned to, in the chart of `tet`
  OctahedralRotation rotation;  // from the chart of the start to that of `tet`
};

namespace detail {

inline constexpr int most_walk_steps = 1'000'000;

class DiagonalWalk {
 public:
  // From p + Q(e) inside tet t (not flat) to the same shift of p + diagonal(corner) / 2.
  DiagonalWalk(const GridMap& map, int t, const FixedPoint3& p, int corner, OctahedralRotation Q)
      : map_(map),
        tet_(t),
        start_(p),
        end_(p),
        s_(diagonal(corner)),
        Q_(Q),
        start_orientation_(orientation()) {
    for (std::size_t i = 0; i < 3; ++i) end_[i] += s_[i] * (map.one() / 2);
  }

  WalkResult run() {
    int exit = first_exit();
    for (int step = 0; step < most_walk_steps && exit >= 0; ++step) {
      if (orientation() == start_orientation_ && inside_of(exit, end_)) return result(WalkEnd::reached, end_);
      if (orientation() == -start_orientation_ && inside_of(exit, start_))
        return result(WalkEnd::returned, start_);
      const auto h = static_cast<std::size_t>(4 * tet_ + exit);
      const int across = map_.twin[h];
      if (orientation() == start_orientation_) last_forward_ = result(WalkEnd::reached, end_);
      if (across < 0) return at_boundary();
      if (!map_.transition[h].exact) return result(WalkEnd::broken, end_);
      cross(map_.transition[h], across / 4);
      exit = next_exit(across % 4);
    }
    return result(WalkEnd::lost, end_);
  }

 private:
  int orientation() const { return map_.orientation[static_cast<std::size_t>(tet_)]; }

  WalkResult result(WalkEnd end, const FixedPoint3& point) const { return {end, tet_, point, rotation_}; }

  std::array<DiagonalView::Projected, 4> projected_corners(const DiagonalView& view) const {
    const auto& P = map_.P[static_cast<std::size_t>(tet_)];
    return {view(P[0]), view(P[1]), view(P[2]), view(P[3])};
  }

  // The face of the first tet that the segment leaves through.
  int first_exit() const {
    const DiagonalView view(start_, s_, Q_);
    const auto x = projected_corners(view);
    for (std::size_t face = 0; face < 4; ++face) {
      bool around = true;
      for (std::size_t k = 0; k < 3 && around; ++k) {
        const auto a = static_cast<std::size_t>(face_corners[face][k]);
        const auto b = static_cast<std::size_t>(face_corners[face][(k + 1) % 3]);
        around = view.turn(x[a], x[b]) == start_orientation_;
      }
      if (around) return static_cast<int>(face);
    }
    return -1;
  }

  // The other face that the line meets, having come in through face `entry`.  Seen along the line, the entry
  // face winds round it by -start_orientation_ in every tet, because faces are crossed from behind to front.
  int next_exit(int entry) const {
    const DiagonalView view(start_, s_, Q_);
    const auto x = projected_corners(view);
    const auto& corners = face_corners[static_cast<std::size_t>(entry)];
    std::array<int, 3> turn{};
    for (std::size_t k = 0; k < 3; ++k) {
      turn[k] = view.turn(x[static_cast<std::size_t>(entry)], x[static_cast<std::size_t>(corners[k])]);
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t next = (k + 1) % 3;
      if (turn[k] == -start_orientation_ && turn[next] == start_orientation_) return corners[(k + 2) % 3];
    }
    return -1;
  }

  // True when p + e lies on the inner side of a face of the current tet.
  bool inside_of(int face, const FixedPoint3& p) const {
    const int h = 4 * tet_ + face;
    const int side =
        plane_side(face_corner(map_, h, 0), face_corner(map_, h, 1), face_corner(map_, h, 2), p, Q_);
    return side * orientation() < 0;
  }

  // An end point on the boundary may be pushed out of the mesh by the perturbation.  Then the walk leaves
  // where the end point is, perhaps through flat tets, and the last tet that it ran forward in holds the end
  // point.
  WalkResult at_boundary() const {
    FaceSigns signs{};
    for (int i = 0; i < 4; ++i) {
      signs[static_cast<std::size_t>(i)] = exact_face_sign(map_, last_forward_.tet, i, last_forward_.point);
    }
    return none_negative(signs) ? last_forward_ : result(WalkEnd::boundary, end_);
  }

  void cross(const FaceTransition& transition, int tet) {
    tet_ = tet;
    start_ = carry(transition, start_, map_.fraction_bits);
    end_ = carry(transition, end_, map_.fraction_bits);
    if (transition.rotation.is_identity()) return;
    s_ = transition.rotation(s_);
    Q_ = transition.rotation * Q_;
    rotation_ = transition.rotation * rotation_;
  }

  const GridMap& map_;
  int tet_;
  FixedPoint3 start_;
  FixedPoint3 end_;
  std::array<int, 3> s_;
  OctahedralRotation Q_;
  OctahedralRotation rotation_;
  int start_orientation_;
  WalkResult last_forward_;
};

}  // namespace detail

inline WalkResult walk_diagonal(const GridMap& map, int t, const FixedPoint3& p, int corner,
                                OctahedralRotation Q) {
  return detail::DiagonalWalk(map, t, p, corner, Q).run();
}

}  // namespace neurframe
