// The vertices of the hex mesh: integer points by number, with those that a fold of the map shows several
// times joined to one.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

#include "hexex/interior_points.hpp"
#include "hexex/preimage.hpp"
#include "hexex/trace_cells.hpp"

namespace neurframe {

// Where a vertex lies: a tet that is not flat, and the point in its chart.
struct VertexPlace {
  int tet = -1;
  FixedPoint3 point{0, 0, 0};
};

class GridVertices {
 public:
  explicit GridVertices(const InteriorPoints& points) : interior_(static_cast<int>(points.count())) {}

  // The number of a named point; `place` is kept for the first who asks.
  int number(const PlaceKey& key, const VertexPlace& place) {
    const auto [found, added] = numbers_.try_emplace(key, interior_ + static_cast<int>(places_.size()));
    if (added) {
      places_.push_back(place);
      is_mesh_vertex_.push_back(key.tet < -1 ? 1 : 0);
    }
    return found->second;
  }

  // Declares two numbers one vertex.  It stays where the more special of the two lies: on a vertex of the tet
  // mesh, else between tets, else inside one.
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
  const VertexPlace& place(int named) const { return places_[static_cast<std::size_t>(named - interior_)]; }

 private:
  int rank(int a) const {
    if (a < interior_) return 2;
    return is_mesh_vertex_[static_cast<std::size_t>(a - interior_)] != 0 ? 0 : 1;
  }

  int interior_;
  int joined_ = 0;
  std::unordered_map<PlaceKey, int, PlaceKeyHash> numbers_;
  std::vector<VertexPlace> places_;
  std::vector<char> is_mesh_vertex_;
  std::unordered_map<int, int> parent_;  // few vertices are ever joined
};

inline void number_named_corners(TracedCells& traced, GridVertices& vertices) {
  for (const NamedCorner& named : traced.corners) {
    Cell& cell = traced.cells[static_cast<std::size_t>(named.cell)];
    cell.corners[static_cast<std::size_t>(named.corner)] =
        vertices.number(named.key, {named.tet, named.point});
  }
}

// The vertex at an integer point of the closed tet t, which must not be flat.
inline int vertex_at(const GridMap& map, const InteriorPoints& points, PreimageSearch& search, int t,
                     const FixedPoint3& p, GridVertices& vertices) {
  const FaceSigns signs = detail::exact_face_signs(map, t, p);
  return all_positive(signs) ? points.number(t, p) : vertices.number(search.key_of(t, p, signs), {t, p});
}

}  // namespace neurframe
