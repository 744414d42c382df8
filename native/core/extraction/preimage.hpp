// The place of a parameter point in the mesh: the connected part of its preimage around a simplex, and the
// one simplex and chart that stand for it.
//
// In an injective map a point lies in the interior of one vertex, edge, triangle or tet, and the simplices
// around that all contain it.  Next to flat ones its preimage can be larger (a whole edge, or a segment
// through a flat tet).  Both are the same flood: across every facet whose image contains the point.  The
// lowest simplex of the flood, with the point in its chart, names the place; equal names are equal points of
// the mesh, whatever way one came.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <unordered_set>
#include <vector>

#include "core/extraction/simplex_planes.hpp"

namespace neurframe {

template <int N>
struct PlaceKey {
  int simplex = -1;  // or -2 - v for mesh vertex v
  FixedPoint<N> point{};
  bool operator==(const PlaceKey&) const = default;
};

struct PlaceKeyHash {
  template <int N>
  std::size_t operator()(const PlaceKey<N>& key) const {
    std::uint64_t hash = static_cast<std::uint64_t>(key.simplex) * 0x9e3779b97f4a7c15ULL;
    for (const Fixed x : key.point) {
      hash ^= static_cast<std::uint64_t>(x);
      hash *= 0xff51afd7ed558ccdULL;
      hash ^= hash >> 32;
    }
    return static_cast<std::size_t>(hash);
  }
};

// A simplex that contains the point, as a search from one of them finds it.
template <int N>
struct PreimageVisit {
  int simplex;
  FixedPoint<N> point;
  Rotation<N> rotation;  // from the chart where the search began to that of the simplex
};

template <std::size_t Corners, std::size_t Size>
bool in_bounding_box(const std::array<std::array<Fixed, Size>, Corners>& x,
                     const std::array<Fixed, Size>& p) {
  for (std::size_t k = 0; k < Size; ++k) {
    const auto [low, high] =
        std::minmax_element(x.begin(), x.end(), [k](const auto& a, const auto& b) { return a[k] < b[k]; });
    if (p[k] < (*low)[k] || p[k] > (*high)[k]) return false;
  }
  return true;
}

// True when p lies on the closed image of a facet.
inline bool facet_contains(const std::array<FixedPoint<2>, 2>& x, const FixedPoint<2>& p) {
  return in_bounding_box(x, p) && outer_side(x, p) == 0;
}

inline bool facet_contains(const std::array<FixedPoint<3>, 3>& x, const FixedPoint<3>& p) {
  if (!in_bounding_box(x, p)) return false;
  const std::array<Int128, 3> normal = outward_normal(x);
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
  return outer_side(x, p) == 0 && std::all_of(edges.begin(), edges.end(), [&](const auto& n) {
           return sign_of(n[axis]) * sign_of(normal[axis]) >= 0;
         });
}

template <int N>
class PreimageSearch {
 public:
  explicit PreimageSearch(const GridMap<N>& map) : map_(map) {}

  // All simplices around point p (in the chart of simplex t), which lies in the closed simplex; valid until
  // the next search.
  const std::vector<PreimageVisit<N>>& visits(int t, const FixedPoint<N>& p) {
    visits_.assign(1, {t, p, {}});
    if (!seen_.empty()) seen_.clear();
    // facets too thin to tell their rotation come last: they carry the point right, but perhaps not the chart
    for (std::size_t certain = 0, any = 0; any < visits_.size();) {
      if (certain < visits_.size()) {
        visit_neighbours(certain++, false);
      } else {
        visit_neighbours(any++, true);
      }
    }
    return visits_;
  }

  // The name of the place of p, which has these facet signs in simplex t; the simplex must not be flat.
  // Vertices and facets away from flat simplices need no search.
  PlaceKey<N> key_of(int t, const FixedPoint<N>& p, const FacetSigns<N>& signs) {
    const Simplex<N>& simplex = map_.S[static_cast<std::size_t>(t)];
    int on_facets = 0;
    int zero_facet = 0;
    int vertex = 0;
    bool near_flat = false;
    for (int facet = 0; facet <= N; ++facet) {
      if (signs[static_cast<std::size_t>(facet)] == 0) {
        ++on_facets;
        zero_facet = facet;
        continue;
      }
      const int corner = Dimension<N>::opposite_corner[static_cast<std::size_t>(facet)];
      vertex = simplex[static_cast<std::size_t>(corner)];
      near_flat = near_flat || map_.touches_flat[static_cast<std::size_t>(vertex)] != 0;
    }
    if (on_facets == 0) return {t, p};
    if (on_facets == N && !near_flat) return {-2 - vertex, {}};
    if (on_facets > 1 || near_flat) return lowest(visits(t, p));
    const auto h = static_cast<std::size_t>((N + 1) * t + zero_facet);
    const int across = map_.twin[h];
    if (across < 0 || across / (N + 1) > t || !map_.transition[h].exact) return {t, p};
    return {across / (N + 1), carry(map_.transition[h], p, map_.fraction_bits)};
  }

 private:
  static PlaceKey<N> lowest(const std::vector<PreimageVisit<N>>& visits) {
    const auto found = std::min_element(visits.begin(), visits.end(),
                                        [](const auto& a, const auto& b) { return a.simplex < b.simplex; });
    return {found->simplex, found->point};
  }

  void visit_neighbours(std::size_t place, bool ambiguous) {
    const PreimageVisit<N> here = visits_[place];
    for (int facet = 0; facet <= N; ++facet) {
      const int h = (N + 1) * here.simplex + facet;
      const int across = map_.twin[static_cast<std::size_t>(h)];
      const FacetTransition<N>& transition = map_.transition[static_cast<std::size_t>(h)];
      if (across < 0 || !transition.exact || transition.ambiguous != ambiguous) continue;
      if (!facet_contains(facet_points(map_, h), here.point)) continue;
      const int behind = across / (N + 1);
      if (!is_new(behind)) continue;
      visits_.push_back(
          {behind, carry(transition, here.point, map_.fraction_bits), transition.rotation * here.rotation});
    }
  }

  // To be called once for a simplex that is then visited.  Few are compared one by one; the star of a vertex
  // with thousands of simplices would take quadratic time so.
  bool is_new(int simplex) {
    constexpr std::size_t few = 32;
    if (visits_.size() < few) {
      return std::none_of(visits_.begin(), visits_.end(),
                          [&](const PreimageVisit<N>& visit) { return visit.simplex == simplex; });
    }
    if (seen_.empty()) {
      for (const PreimageVisit<N>& visit : visits_) seen_.insert(visit.simplex);
    }
    return seen_.insert(simplex).second;
  }

  const GridMap<N>& map_;
  std::vector<PreimageVisit<N>> visits_;
  std::unordered_set<int> seen_;  // the simplices visited, where they are many
};

}  // namespace neurframe
