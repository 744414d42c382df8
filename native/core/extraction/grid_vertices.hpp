// The vertices of the result: integer points by number, with those that a fold of the map shows several
// times joined to one.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/extraction/interior_points.hpp"
#include "core/extraction/preimage.hpp"
#include "core/extraction/trace_cells.hpp"

namespace neurframe {

// Where a vertex lies: a simplex that is not flat, and the point in its chart.
template <int N>
struct VertexPlace {
  int simplex = -1;
  FixedPoint<N> point{};
};

template <int N>
class GridVertices {
 public:
  explicit GridVertices(const InteriorPoints<N>& points) : interior_(static_cast<int>(points.count())) {}

  // The number of a named point; `place` is kept for the first who asks.
  int number(const PlaceKey<N>& key, const VertexPlace<N>& place) {
    if (count() == std::numeric_limits<int>::max()) throw StageError("more vertices than can be numbered");
    const auto [found, added] = numbers_.try_emplace(key, count());
    if (added) {
      places_.push_back(place);
      is_mesh_vertex_.push_back(key.simplex < -1 ? 1 : 0);
    }
    return found->second;
  }

  // Declares two numbers one vertex.  It stays where the more special of the two lies: on a vertex of the
  // mesh, else between simplices, else inside one.
  void join(int a, int b) {
    a = find(a);
    b = find(b);
    if (a == b) return;
    if (std::pair(rank(b), b) < std::pair(rank(a), a)) std::swap(a, b);
    parent_[b] = a;
    ++joined_;
  }

  int find(int a) const {
    for (auto up = parent_.find(a); up != parent_.end(); up = parent_.find(a)) a = up->second;
    return a;
  }

  int interior_count() const { return interior_; }
  int count() const { return interior_ + static_cast<int>(places_.size()); }
  int joined() const { return joined_; }
  const VertexPlace<N>& place(int named) const {
    return places_[static_cast<std::size_t>(named - interior_)];
  }

 private:
  int rank(int a) const {
    if (a < interior_) return 2;
    return is_mesh_vertex_[static_cast<std::size_t>(a - interior_)] != 0 ? 0 : 1;
  }

  int interior_;
  int joined_ = 0;
  std::unordered_map<PlaceKey<N>, int, PlaceKeyHash> numbers_;
  std::vector<VertexPlace<N>> places_;
  std::vector<char> is_mesh_vertex_;
  std::unordered_map<int, int> parent_;  // few vertices are ever joined
};

template <int N>
void number_named_corners(TracedCells<N>& traced, GridVertices<N>& vertices) {
  for (const NamedCorner<N>& named : traced.corners) {
    Cell<N>& cell = traced.cells[static_cast<std::size_t>(named.cell)];
    cell.corners[static_cast<std::size_t>(named.corner)] =
        vertices.number(named.key, {named.simplex, named.point});
  }
}

// The vertex at an integer point of the closed simplex t, which must not be flat.
template <int N>
int vertex_at(const GridMap<N>& map, const InteriorPoints<N>& points, PreimageSearch<N>& search, int t,
              const FixedPoint<N>& p, GridVertices<N>& vertices) {
  const FacetSigns<N> signs = exact_facet_signs(map, t, p);
  return all_positive(signs) ? points.number(t, p) : vertices.number(search.key_of(t, p, signs), {t, p});
}

}  // namespace neurframe
