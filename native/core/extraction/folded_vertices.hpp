// Integer points that a fold of the map shows several times are one vertex.
//
// Each preimage in a flipped simplex has partners: the walks from it towards the cells around it return to
// them. Between simplices the perturbation decides which preimages there are, so all are tried: every link
// that any of them finds is true.
#pragma once

#include <unordered_set>
#include <vector>

#include "core/extraction/grid_vertices.hpp"

namespace neurframe {

template <int N>
class FoldedVertices {
 public:
  FoldedVertices(const GridMap<N>& map, const InteriorPoints<N>& points, GridVertices<N>& vertices)
      : map_(map), points_(points), vertices_(vertices), search_(map) {}

  // Joins the vertices at the integer points of the flipped simplex t.
  void join_points_of(int t) {
    const SimplexPlanes<N> planes(map_, t);
    const LatticeBox<N> box = lattice_box(map_, t, 0);
    for_each_lattice_point(map_, planes, box, 0, [&](const FixedPoint<N>& p, const FacetSigns<N>& signs) {
      if (all_positive(signs)) {
        join_partners(t, p, {});
      } else {
        join_between(t, p, signs);
      }
    });
  }

 private:
  void join_between(int t, const FixedPoint<N>& p, const FacetSigns<N>& signs) {
    if (!done_.insert(search_.key_of(t, p, signs)).second) return;
    const std::vector<PreimageVisit<N>> visits = search_.visits(t, p);
    for (int q = 0; q < Dimension<N>::rotations; ++q) {
      for (const PreimageVisit<N>& visit : visits) {
        if (map_.orientation[static_cast<std::size_t>(visit.simplex)] == 0) continue;
        const Rotation<N> Q = visit.rotation * Rotation<N>(q);
        const FacetSigns<N> here = exact_facet_signs(map_, visit.simplex, visit.point);
        if (perturbed_inside(map_, visit.simplex, visit.point, here, Q)) {
          join_partners(visit.simplex, visit.point, Q);
        }
      }
    }
  }

  void join_partners(int t, const FixedPoint<N>& p, Rotation<N> Q) {
    const int here = vertex_at(map_, points_, search_, t, p, vertices_);
    for (int corner = 0; corner < cell_corners<N>; ++corner) {
      const WalkResult<N> walk = walk_diagonal(map_, t, p, corner, Q);
      if (walk.end != WalkEnd::returned) continue;
      vertices_.join(here, vertex_at(map_, points_, search_, walk.simplex, walk.point, vertices_));
    }
  }

  const GridMap<N>& map_;
  const InteriorPoints<N>& points_;
  GridVertices<N>& vertices_;
  PreimageSearch<N> search_;
  std::unordered_set<PlaceKey<N>, PlaceKeyHash> done_;
};

template <int N>
void join_folded_vertices(const GridMap<N>& map, const InteriorPoints<N>& points, GridVertices<N>& vertices) {
  FoldedVertices<N> folded(map, points, vertices);
  for (std::size_t t = 0; t < map.P.size(); ++t) {
    if (map.orientation[t] < 0) folded.join_points_of(static_cast<int>(t));
  }
}

}  // namespace neurframe
