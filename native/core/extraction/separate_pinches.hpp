// Cells that touch in a vertex or an edge only, because others are missing, taken apart: the result is a
// manifold.
//
// Cells round a vertex that facets connect share it; other groups of cells there get copies of it.  What then
// is no manifold yet shows in the link of a vertex, the little sphere round it as its hexes cut it, each in a
// triangle: it has to be a disk or the whole sphere.  Where it is neither, the triangles are added one by one
// as long as they make a disk, and the hexes of those that cannot be added are lost.  Round a vertex of quads
// the link is a path or a circle as soon as the groups are apart.
#pragma once

#include <algorithm>
#include <array>
#include <numeric>
#include <vector>

#include "core/extraction/assemble_cells.hpp"
#include "core/extraction/facet_prints.hpp"

namespace neurframe {

namespace detail {

inline constexpr std::size_t hex_facets = CellShape<3>::facets.size();

template <int N>
inline constexpr std::size_t corners_per_cell = CellShape<N>::corners.size();

// Union-find over 0 ... n - 1, whose representatives are the lowest members.
class LowestMember {
 public:
  explicit LowestMember(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }

  int find(int i) {
    while (parent(i) != i) i = parent(i) = parent(parent(i));
    return i;
  }

  void join(int i, int k) {
    const int a = find(i);
    const int b = find(k);
    parent(std::max(a, b)) = std::min(a, b);
  }

 private:
  int& parent(int i) { return parent_[static_cast<std::size_t>(i)]; }

  std::vector<int> parent_;
};

template <int N>
struct FacetOfCell {
  FacetVertices<N> sorted;
  int cell;
  int facet;

  auto operator<=>(const FacetOfCell&) const = default;
};

// All facets, those with the same vertices one after the other; there are at most two of them.
template <int N>
std::vector<FacetOfCell<N>> sorted_facets(const std::vector<CellVertices<N>>& cells) {
  std::vector<FacetOfCell<N>> facets;
  facets.reserve(cells.size() * CellShape<N>::facets.size());
  for (std::size_t c = 0; c < cells.size(); ++c) {
    for (std::size_t f = 0; f < CellShape<N>::facets.size(); ++f) {
      FacetVertices<N> vertices = cell_facet<N>(cells[c], f);
      std::sort(vertices.begin(), vertices.end());
      facets.push_back({vertices, static_cast<int>(c), static_cast<int>(f)});
    }
  }
  std::sort(facets.begin(), facets.end());
  return facets;
}

// Calls visit(facet, the same facet as the other cell sees it) for facets between two cells.
template <int N, class Visit>
void for_each_inner_facet(const std::vector<FacetOfCell<N>>& facets, const Visit& visit) {
  for (std::size_t i = 1; i < facets.size(); ++i) {
    if (facets[i - 1].sorted == facets[i].sorted) visit(facets[i - 1], facets[i]);
  }
}

// The number of a corner among all: corners of cell 0, of cell 1, ...
template <int N>
int corner_number(int cell, std::size_t corner) {
  return cell * cell_corners<N> + static_cast<int>(corner);
}

// Per corner of a cell, the lowest of the corners that are one vertex with it because facets connect them.
template <int N>
std::vector<int> corner_groups(const std::vector<CellVertices<N>>& cells,
                               const std::vector<FacetOfCell<N>>& facets) {
  LowestMember groups(cells.size() * corners_per_cell<N>);
  for_each_inner_facet<N>(facets, [&](const FacetOfCell<N>& one, const FacetOfCell<N>& other) {
    const CellVertices<N>& there = cells[static_cast<std::size_t>(other.cell)];
    for (const int corner : CellShape<N>::facets[static_cast<std::size_t>(one.facet)]) {
      const auto i = static_cast<std::size_t>(corner);
      const int vertex = cells[static_cast<std::size_t>(one.cell)][i];
      const auto k = static_cast<std::size_t>(std::find(there.begin(), there.end(), vertex) - there.begin());
      groups.join(corner_number<N>(one.cell, i), corner_number<N>(other.cell, k));
    }
  });
  std::vector<int> lowest(cells.size() * corners_per_cell<N>);
  for (std::size_t i = 0; i < lowest.size(); ++i) lowest[i] = groups.find(static_cast<int>(i));
  return lowest;
}

// What a hex cuts out of the sphere round one of its corners: per side the facet, and the two vertices
// (groups of corners) at the other ends of the edges that bound it.
struct LinkSide {
  int facet;
  int from;
  int to;
};

struct LinkTriangle {
  int cell;
  std::array<LinkSide, 3> sides;
};

// The triangles of a link, and the largest disk or sphere that grows out of the first of them.
class Link {
 public:
  explicit Link(const std::vector<LinkTriangle>& triangles) : triangles_(triangles) {}

  // A disk or a sphere: connected, as it is here, with one fan of triangles at every vertex, and V - E + F >
  // 0.
  bool is_sound() {
    collect_all();
    const int characteristic = static_cast<int>(vertices_.size()) - static_cast<int>(facets_.size()) +
                               static_cast<int>(triangles_.size());
    return characteristic > 0 && has_one_fan_per_vertex();
  }

  // Calls lose(cell) for each triangle that does not fit.
  template <class Lose>
  void grow_disk(const Lose& lose) {
    std::vector<char> added(triangles_.size(), 0);
    facets_.clear();
    vertices_.clear();
    add(triangles_.front());
    added.front() = 1;
    for (bool grown = true; grown;) {
      grown = false;
      for (std::size_t i = 0; i < triangles_.size(); ++i) {
        if (added[i] != 0 || !keeps_disk(triangles_[i])) continue;
        add(triangles_[i]);
        added[i] = 1;
        grown = true;
      }
    }
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      if (added[i] == 0) lose(triangles_[i].cell);
    }
  }

 private:
  static bool contains(const std::vector<int>& set, int value) {
    return std::find(set.begin(), set.end(), value) != set.end();
  }

  static void insert(std::vector<int>& set, int value) {
    if (!contains(set, value)) set.push_back(value);
  }

  void add(const LinkTriangle& triangle) {
    for (const LinkSide& side : triangle.sides) {
      insert(facets_, side.facet);
      insert(vertices_, side.from);
    }
  }

  void collect_all() {
    facets_.clear();
    vertices_.clear();
    for (const LinkTriangle& triangle : triangles_) add(triangle);
  }

  // A triangle meets a disk in one side, in two sides, or it closes the sphere with all three.
  bool keeps_disk(const LinkTriangle& triangle) const {
    int sides = 0;
    int vertices = 0;
    for (const LinkSide& side : triangle.sides) {
      sides += contains(facets_, side.facet) ? 1 : 0;
      vertices += contains(vertices_, side.from) ? 1 : 0;
    }
    return sides > 1 || (sides == 1 && vertices == 2);
  }

  // Triangles at a vertex of the link, connected through sides at that vertex.
  bool has_one_fan_per_vertex() const {
    return std::all_of(vertices_.begin(), vertices_.end(), [&](int vertex) {
      std::vector<std::array<int, 2>> sides_at;  // facets of the two sides of each triangle there
      for (const LinkTriangle& triangle : triangles_) {
        std::array<int, 2> at{};
        std::size_t found = 0;
        for (const LinkSide& side : triangle.sides) {
          if ((side.from == vertex || side.to == vertex) && found < 2) at[found++] = side.facet;
        }
        if (found == 2) sides_at.push_back(at);
      }
      return are_connected(sides_at);
    });
  }

  static bool are_connected(std::vector<std::array<int, 2>> pairs) {
    std::vector<int> reached{pairs.front()[0], pairs.front()[1]};
    pairs.erase(pairs.begin());
    for (bool grown = true; grown && !pairs.empty();) {
      const auto next = std::find_if(pairs.begin(), pairs.end(), [&](const std::array<int, 2>& pair) {
        return contains(reached, pair[0]) || contains(reached, pair[1]);
      });
      grown = next != pairs.end();
      if (!grown) break;
      insert(reached, (*next)[0]);
      insert(reached, (*next)[1]);
      pairs.erase(next);
    }
    return pairs.empty();
  }

  const std::vector<LinkTriangle>& triangles_;
  std::vector<int> facets_;  // of what is added
  std::vector<int> vertices_;
};

// Per facet of a cell, 6 c + f, the lowest number of the facet.
inline std::vector<int> facet_numbers(std::size_t cells, const std::vector<FacetOfCell<3>>& facets) {
  const auto number = [](const FacetOfCell<3>& facet) {
    return facet.cell * static_cast<int>(hex_facets) + facet.facet;
  };
  std::vector<int> numbers(cells * hex_facets);
  std::iota(numbers.begin(), numbers.end(), 0);
  for_each_inner_facet<3>(facets, [&](const FacetOfCell<3>& one, const FacetOfCell<3>& other) {
    numbers[static_cast<std::size_t>(number(other))] = number(one);
  });
  return numbers;
}

// The triangle of the corner with this number.
inline LinkTriangle link_triangle(int number, const std::vector<int>& groups,
                                  const std::vector<int>& facets) {
  LinkTriangle triangle{number / cell_corners<3>, {}};
  const int first = triangle.cell * cell_corners<3>;
  std::size_t found = 0;
  for (std::size_t f = 0; f < hex_facets; ++f) {
    const std::array<int, 4>& facet = CellShape<3>::facets[f];
    const auto at = std::find(facet.begin(), facet.end(), number - first);
    if (at == facet.end()) continue;
    const auto i = static_cast<std::size_t>(at - facet.begin());
    triangle.sides[found++] = {facets[static_cast<std::size_t>(triangle.cell) * hex_facets + f],
                               groups[static_cast<std::size_t>(first + facet[(i + 1) % 4])],
                               groups[static_cast<std::size_t>(first + facet[(i + 3) % 4])]};
  }
  return triangle;
}

// Corners in order of their groups, those of one group in ascending order.
inline std::vector<int> corners_by_group(const std::vector<int>& groups) {
  std::vector<int> start(groups.size() + 1, 0);
  for (const int group : groups) ++start[static_cast<std::size_t>(group) + 1];
  std::partial_sum(start.begin(), start.end(), start.begin());
  std::vector<int> order(groups.size());
  for (std::size_t i = 0; i < groups.size(); ++i)
    order[static_cast<std::size_t>(start[static_cast<std::size_t>(groups[i])]++)] = static_cast<int>(i);
  return order;
}

// Which hexes are lost round vertices whose link is neither a disk nor a sphere; links without such a hex
// only, as the others have to be seen anew.
inline std::vector<char> pinched_hexes(const std::vector<CellVertices<3>>& hexes,
                                       const std::vector<int>& groups,
                                       const std::vector<FacetOfCell<3>>& facets) {
  const std::vector<int> numbers = facet_numbers(hexes.size(), facets);
  const std::vector<int> order = corners_by_group(groups);
  std::vector<char> lost(hexes.size(), 0);
  std::vector<LinkTriangle> triangles;
  for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    const int group = groups[static_cast<std::size_t>(order[begin])];
    triangles.clear();
    bool touched = false;
    for (end = begin; end < order.size() && groups[static_cast<std::size_t>(order[end])] == group; ++end) {
      triangles.push_back(link_triangle(order[end], groups, numbers));
      touched = touched || lost[static_cast<std::size_t>(triangles.back().cell)] != 0;
    }
    Link link(triangles);
    if (touched || link.is_sound()) continue;
    link.grow_disk([&](int hex) { lost[static_cast<std::size_t>(hex)] = 1; });
  }
  return lost;
}

// Numbers the groups: the lowest group at a vertex keeps its number, others are added behind `vertices`.
// Returns the vertex that each of those is a copy of.
template <int N>
std::vector<int> number_groups(const std::vector<int>& groups, int vertices,
                               std::vector<CellVertices<N>>& cells) {
  std::vector<char> taken(static_cast<std::size_t>(vertices), 0);
  std::vector<int> number(groups.size());
  std::vector<int> copied;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    int& vertex = cells[i / corners_per_cell<N>][i % corners_per_cell<N>];
    const auto group = static_cast<std::size_t>(groups[i]);
    if (group == i) {
      char& first = taken[static_cast<std::size_t>(vertex)];
      number[i] = first == 0 ? vertex : vertices + static_cast<int>(copied.size());
      if (first != 0) copied.push_back(vertex);
      first = 1;
    }
    vertex = number[group];
  }
  return copied;
}

}  // namespace detail

// Gives groups of cells vertices of their own, from `vertices` on, and books hexes that are in the way as
// lost. Returns the vertex that each new one is a copy of.
template <int N>
std::vector<int> separate_pinches(const TracedCells<N>& traced, int vertices, AssembledCells<N>& out) {
  for (;;) {
    const std::vector<detail::FacetOfCell<N>> facets = detail::sorted_facets<N>(out.cells);
    const std::vector<int> groups = detail::corner_groups<N>(out.cells, facets);
    if constexpr (N == 3) {
      const std::vector<char> lost = detail::pinched_hexes(out.cells, groups, facets);
      if (std::any_of(lost.begin(), lost.end(), [](char l) { return l != 0; })) {
        detail::filter_cells(traced, CellLoss::pinched, out, [&](std::size_t c) { return lost[c] == 0; });
        continue;
      }
    }
    return detail::number_groups<N>(groups, vertices, out.cells);
  }
}

}  // namespace neurframe
