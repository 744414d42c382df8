// No facet of the result has more than two cells, nor two on the same side of it.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "core/extraction/assemble_cells.hpp"

namespace neurframe {

namespace detail {

template <int N>
struct CellFacet {
  static constexpr std::size_t corners = std::size_t{1} << (N - 1);

  std::array<int, corners - 1> others;  // its vertices but the smallest, sorted
  int cell;
  bool reversed;  // which way round the cell sees the facet

  bool same_facet(const CellFacet& other) const { return others == other.others; }
  bool operator<(const CellFacet& other) const {
    return others != other.others ? others < other.others : cell < other.cell;
  }
};

// The vertices of a facet from the smallest on.
template <int N>
auto facet_from_smallest(const CellVertices<N>& cell, std::size_t facet) {
  std::array<int, CellFacet<N>::corners> v{};
  for (std::size_t k = 0; k < v.size(); ++k)
    v[k] = cell[static_cast<std::size_t>(CellShape<N>::facets[facet][k])];
  if (N == 2) return v;  // its direction is told below
  std::rotate(v.begin(), std::min_element(v.begin(), v.end()), v.end());
  return v;
}

template <int N>
CellFacet<N> sorted_facet(std::array<int, CellFacet<N>::corners> v, int cell) {
  const bool reversed = N == 2 ? v.back() < v.front() : v.back() < v[1];
  std::sort(v.begin(), v.end());
  CellFacet<N> found{{}, cell, reversed};
  std::copy(v.begin() + 1, v.end(), found.others.begin());
  return found;
}

// Facets in buckets by smallest vertex: first[v] .. first[v+1].
template <int N>
struct CellFacetBuckets {
  std::vector<std::size_t> first;
  std::vector<CellFacet<N>> facets;
};

template <int N>
CellFacetBuckets<N> bucket_cell_facets(const AssembledCells<N>& assembled, int vertices) {
  constexpr std::size_t facets = CellShape<N>::facets.size();
  CellFacetBuckets<N> buckets{std::vector<std::size_t>(static_cast<std::size_t>(vertices) + 1, 0),
                              std::vector<CellFacet<N>>(facets * assembled.cells.size())};
  const auto smallest = [](const auto& v) {
    return static_cast<std::size_t>(*std::min_element(v.begin(), v.end()));
  };
  for (const CellVertices<N>& cell : assembled.cells) {
    for (std::size_t f = 0; f < facets; ++f) ++buckets.first[smallest(facet_from_smallest<N>(cell, f)) + 1];
  }
  for (std::size_t v = 0; v + 1 < buckets.first.size(); ++v) buckets.first[v + 1] += buckets.first[v];
  std::vector<std::size_t> cursor(buckets.first.begin(), buckets.first.end() - 1);
  for (std::size_t c = 0; c < assembled.cells.size(); ++c) {
    for (std::size_t f = 0; f < facets; ++f) {
      const auto v = facet_from_smallest<N>(assembled.cells[c], f);
      buckets.facets[cursor[smallest(v)]++] = sorted_facet<N>(v, static_cast<int>(c));
    }
  }
  return buckets;
}

}  // namespace detail

// Drops cells, latest first, until every facet has at most two, on opposite sides.
template <int N>
void drop_crowding_cells(const TracedCells<N>& traced, int vertices, int threads, AssembledCells<N>& out) {
  detail::CellFacetBuckets<N> buckets = detail::bucket_cell_facets(out, vertices);
  const auto begin_of = [&](std::int64_t v) {
    return buckets.facets.begin() + static_cast<std::ptrdiff_t>(buckets.first[static_cast<std::size_t>(v)]);
  };
  parallel_for(vertices, threads, [&](std::int64_t v) { std::sort(begin_of(v), begin_of(v + 1)); });
  std::vector<char> dropped(out.cells.size(), 0);
  for (std::int64_t v = 0; v < vertices; ++v) {
    for (auto facet = begin_of(v), end = begin_of(v + 1); facet != end;) {
      bool taken[2] = {false, false};
      for (const auto start = facet; facet != end && facet->same_facet(*start); ++facet) {
        char& drop = dropped[static_cast<std::size_t>(facet->cell)];
        bool& side = taken[facet->reversed ? 1 : 0];
        if (drop == 0 && side) drop = 1;
        side = side || drop == 0;
      }
    }
  }
  detail::filter_cells(traced, CellLoss::crowded_facet, out, [&](std::size_t c) { return dropped[c] == 0; });
}

}  // namespace neurframe
