// Integer points that a fold of the map shows several times are one vertex.
//
// Each preimage in a flipped tet has partners: the walks from it towards the eight cells around it return to
// them. Between tets the perturbation decides which preimages there are, so all 24 are tried: every link that
// any of them finds is true.
#pragma once

#include <unordered_set>
#include <vector>

#include "hexex/grid_vertices.hpp"

namespace neurframe {

class FoldedVertices {
 public:
  FoldedVertices(const GridMap& map, const InteriorPoints& points, GridVertices& vertices)
      : map_(map), points_(points), vertices_(vertices), search_(map) {}

  // Joins the vertices at the integer points of the flipped tet t.
  void join_points_of(int t) {
    const TetPlanes planes(map_, t);
    const Fixed one = map_.one();
    for_each_column(planes, lattice_box(map_, t, 0), one, 0,
                    [&](std::int64_t x, std::int64_t y, Interval column) {
                      for (std::int64_t z = column.begin; z < column.end; ++z) {
                        const FixedPoint3 p{x * one, y * one, z * one};
                        const FaceSigns signs = planes.signs(p);
                        if (all_positive(signs)) join_partners(t, p, {});
                        if (none_negative(signs) && !all_positive(signs)) join_between_tets(t, p, signs);
                      }
                    });
  }

 private:
  void join_between_tets(int t, const FixedPoint3& p, const FaceSigns& signs) {
    if (!done_.insert(search_.key_of(t, p, signs)).second) return;
    const std::vector<PreimageVisit> visits = search_.visits(t, p);
    for (int q = 0; q < OctahedralRotation::count; ++q) {
      for (const PreimageVisit& visit : visits) {
        if (map_.orientation[static_cast<std::size_t>(visit.tet)] == 0) continue;
        const OctahedralRotation Q = visit.rotation * OctahedralRotation(q);
        const FaceSigns here = detail::exact_face_signs(map_, visit.tet, visit.point);
        if (detail::perturbed_inside(map_, visit.tet, visit.point, here, Q))
          join_partners(visit.tet, visit.point, Q);
      }
    }
  }

  void join_partners(int t, const FixedPoint3& p, OctahedralRotation Q) {
    const int here = vertex_at(map_, points_, search_, t, p, vertices_);
    for (int corner = 0; corner < 8; ++corner) {
      const WalkResult walk = walk_diagonal(map_, t, p, corner, Q);
      if (walk.end != WalkEnd::returned) continue;
      vertices_.join(here, vertex_at(map_, points_, search_, walk.tet, walk.point, vertices_));
    }
  }

  const GridMap& map_;
  const InteriorPoints& points_;
  GridVertices& vertices_;
  PreimageSearch search_;
  std::unordered_set<PlaceKey, PlaceKeyHash> done_;
};

inline void join_folded_vertices(const GridMap& map, const InteriorPoints& points, GridVertices& vertices) {
  FoldedVertices folded(map, points, vertices);
  for (std::size_t t = 0; t < map.P.size(); ++t) {
    if (map.orientation[t] < 0) folded.join_points_of(static_cast<int>(t));
  }
}

}  // namespace neurframe
