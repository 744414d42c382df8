// The place of a parameter point in the tet mesh: the connected part of its preimage around a tet, and the
// one tet and chart that stand for it.
//
// In an injective map a point lies in the interior of one simplex, and the tets around that simplex all
// contain it. Next to flat tets its preimage can be larger (a whole edge, or a segment through a flat tet).
// Both are the same flood: across every face whose image contains the point.  The lowest tet of the flood,
// with the point in its chart, names the place; equal names are equal points of the mesh, whatever way one
// came.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <vector>

#include "hexex/tet_planes.hpp"

namespace neurframe {

struct PlaceKey {
  int tet = -1;  // or -2 - v for mesh vertex v
  FixedPoint3 point{0, 0, 0};
  bool operator==(const PlaceKey&) const = default;
};

struct PlaceKeyHash {
  std::size_t operator()(const PlaceKey& key) const {
    std::uint64_t hash = static_cast<std::uint64_t>(key.tet) * 0x9e3779b97f4a7c15ULL;
    for (const Fixed x : key.point) {
      hash ^= static_cast<std::uint64_t>(x);
      hash *= 0xff51afd7ed558ccdULL;
      hash ^= hash >> 32;
    }
    return static_cast<std::size_t>(hash);
  }
};

// A tet that contains the point, as a search from one of them finds it.
struct PreimageVisit {
  int tet;
  FixedPoint3 point;
  OctahedralRotation rotation;  // from the chart where the search began to that of tet
};

// True when p lies on the closed image of a half-face.
inline bool face_contains(const GridMap& map, int half_face, const FixedPoint3& p) {
  const std::array<FixedPoint3, 3> x{face_corner(map, half_face, 0), face_corner(map, half_face, 1),
                                     face_corner(map, half_face, 2)};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto [low, high] = std::minmax({x[0][k], x[1][k], x[2][k]});
    if (p[k] < low || p[k] > high) return false;
  }
  const std::array<Int128, 3> normal = cross_product(difference(x[1], x[0]), difference(x[2], x[0]));
  const auto edge_normal = [&](std::size_t i) {
    return cross_product(difference(x[(i + 1) % 3], x[i]), difference(p, x[i]));
  };
  const std::array<std::array<Int128, 3>, 3> edges{edge_normal(0), edge_normal(1), edge_normal(2)};
  std::size_t axis = 0;
  while (axis < 3 && normal[axis] == 0) ++axis;
  if (axis == 3) {  // collinear: p is in the bounding box, so being on the line is enough
    return std::all_of(edges.begin(), edges.end(),
                       [](const auto& n) { return n[0] == 0 && n[1] == 0 && n[2] == 0; });
  }
  if (plane_side(x[0], x[1], x[2], p) != 0) return false;
  return std::all_of(edges.begin(), edges.end(),
                     [&](const auto& n) { return sign_of(n[axis]) * sign_of(normal[axis]) >= 0; });
}

class PreimageSearch {
 public:
  explicit PreimageSearch(const GridMap& map) : map_(map) {}

  // All tets around point p (in the chart of tet t), which lies in the closed tet; valid until the next
  // search.
  const std::vector<PreimageVisit>& visits(int t, const FixedPoint3& p) {
    visits_.assign(1, {t, p, {}});
    // faces too thin to tell their rotation come last: they carry the point right, but perhaps not the chart
    for (std::size_t certain = 0, any = 0; any < visits_.size();) {
      if (certain < visits_.size()) {
        visit_neighbours(certain++, false);
      } else {
        visit_neighbours(any++, true);
      }
    }
    return visits_;
  }

  // The name alone, for a point with these face signs in the tet t that is not flat; a short cut for the two
  // most frequent cases, a vertex and a face away from flat tets.
  PlaceKey key_of(int t, const FixedPoint3& p, const FaceSigns& signs) {
    const Tet& tet = map_.mesh.T[static_cast<std::size_t>(t)];
    int on_faces = 0;
    int zero_face = 0;
    int vertex_corner = 0;
    bool near_flat = false;
    for (int i = 0; i < 4; ++i) {
      const auto corner = static_cast<std::size_t>(i);
      on_faces += signs[corner] == 0 ? 1 : 0;
      (signs[corner] == 0 ? zero_face : vertex_corner) = i;
      near_flat =
          near_flat || (signs[corner] != 0 && map_.touches_flat[static_cast<std::size_t>(tet[corner])] != 0);
    }
    if (on_faces == 0) return {t, p};
    if (near_flat || on_faces == 2) return lowest(visits(t, p));
    if (on_faces == 3) return {-2 - tet[static_cast<std::size_t>(vertex_corner)], {0, 0, 0}};
    const auto h = static_cast<std::size_t>(4 * t + zero_face);
    const int across = map_.twin[h];
    if (across < 0 || across / 4 > t || !map_.transition[h].exact) return {t, p};
    return {across / 4, carry(map_.transition[h], p, map_.fraction_bits)};
  }

 private:
  static PlaceKey lowest(const std::vector<PreimageVisit>& visits) {
    const auto found = std::min_element(visits.begin(), visits.end(),
                                        [](const auto& a, const auto& b) { return a.tet < b.tet; });
    return {found->tet, found->point};
  }

  void visit_neighbours(std::size_t place, bool ambiguous) {
    const PreimageVisit here = visits_[place];
    for (int i = 0; i < 4; ++i) {
      const int h = 4 * here.tet + i;
      const int across = map_.twin[static_cast<std::size_t>(h)];
      const FaceTransition& transition = map_.transition[static_cast<std::size_t>(h)];
      if (across < 0 || !transition.exact || transition.ambiguous != ambiguous) continue;
      if (!face_contains(map_, h, here.point)) continue;
      const auto seen = [&](const PreimageVisit& visit) { return visit.tet == across / 4; };
      if (std::any_of(visits_.begin(), visits_.end(), seen)) continue;
      visits_.push_back({across / 4, carry(transition, here.point, map_.fraction_bits),
                         transition.rotation * here.rotation});
    }
  }

  const GridMap& map_;
  std::vector<PreimageVisit> visits_;
};

}  // namespace neurframe
