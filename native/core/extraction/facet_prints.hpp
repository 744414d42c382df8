// Which facets have two cells on one side, told by 32-bit prints: nearly always none.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "core/extraction/assemble_cells.hpp"
#include "core/parallel.hpp"

namespace neurframe {

// A facet as a cell sees it: the smallest vertex, and a print of all its vertices in which the lowest bit
// tells which way round they are.  Equal facets seen from the same side have equal prints.
struct FacetPrint {
  std::uint32_t smallest;
  std::uint32_t print;
  auto operator<=>(const FacetPrint&) const = default;
};

namespace detail {

// Spreads a vertex number over 32 bits, so that sums over different vertices differ (Knuth, multiplicative
// hashing, and one round of mixing).
inline std::uint32_t vertex_print(int vertex) {
  std::uint32_t x = static_cast<std::uint32_t>(vertex) * 0x9e3779b1u;
  x ^= x >> 15;
  return x * 0x85ebca6bu;
}

inline FacetPrint facet_print(const std::array<int, 2>& v, std::uint32_t sum) {
  return {static_cast<std::uint32_t>(std::min(v[0], v[1])), (sum & ~1u) | (v[1] < v[0] ? 1u : 0u)};
}

inline FacetPrint facet_print(const std::array<int, 4>& v, std::uint32_t sum) {
  // the smallest of the even corners against that of the odd ones; its neighbours are the two others
  const std::size_t even = v[2] < v[0] ? 2 : 0;
  const std::size_t odd = v[3] < v[1] ? 3 : 1;
  const std::size_t least = v[odd] < v[even] ? odd : even;
  const bool reversed = v[(least + 3) % 4] < v[(least + 1) % 4];
  return {static_cast<std::uint32_t>(v[least]), (sum & ~1u) | (reversed ? 1u : 0u)};
}

}  // namespace detail

template <int N>
using FacetVertices = std::type_identity_t<std::array<int, std::size_t{1} << (N - 1)>>;

template <int N>
FacetVertices<N> cell_facet(const CellVertices<N>& cell, std::size_t facet) {
  FacetVertices<N> v{};
  for (std::size_t k = 0; k < v.size(); ++k)
    v[k] = cell[static_cast<std::size_t>(CellShape<N>::facets[facet][k])];
  return v;
}

// Calls visit(facet, print) for the facets of a cell.
template <int N, class Visit>
void for_each_facet_print(const CellVertices<N>& cell, const Visit& visit) {
  std::array<std::uint32_t, cell_corners<N>> prints{};
  for (std::size_t i = 0; i < prints.size(); ++i) prints[i] = detail::vertex_print(cell[i]);
  for (std::size_t facet = 0; facet < CellShape<N>::facets.size(); ++facet) {
    std::uint32_t sum = 0;
    for (const int k : CellShape<N>::facets[facet]) sum += prints[static_cast<std::size_t>(k)];
    visit(facet, detail::facet_print(cell_facet<N>(cell, facet), sum));
  }
}

// The prints of all facets in buckets by smallest vertex: first[v] .. first[v+1].
template <int N>
struct FacetPrints {
  std::vector<std::uint32_t> first;
  std::vector<std::uint32_t> prints;
};

template <int N>
FacetPrints<N> bucket_facet_prints(const std::vector<CellVertices<N>>& cells, int vertices) {
  FacetPrints<N> buckets{std::vector<std::uint32_t>(static_cast<std::size_t>(vertices) + 1, 0),
                         std::vector<std::uint32_t>(CellShape<N>::facets.size() * cells.size())};
  for (const CellVertices<N>& cell : cells) {
    for_each_facet_print<N>(cell, [&](std::size_t, FacetPrint facet) { ++buckets.first[facet.smallest]; });
  }
  std::uint32_t end = 0;
  for (std::uint32_t& first : buckets.first) first = end += first;
  // filled from the end, so that `first` is the beginning of each bucket afterwards
  for (const CellVertices<N>& cell : cells) {
    for_each_facet_print<N>(cell, [&](std::size_t, FacetPrint facet) {
      buckets.prints[--buckets.first[facet.smallest]] = facet.print;
    });
  }
  return buckets;
}

// The prints that occur more than once: all facets with two cells on one side, and perhaps some by chance.
// Ascending.
template <int N>
std::vector<FacetPrint> repeated_facet_prints(const std::vector<CellVertices<N>>& cells, int vertices,
                                              int threads) {
  FacetPrints<N> buckets = bucket_facet_prints<N>(cells, vertices);
  return parallel_collect<FacetPrint>(
      vertices, threads, [&](std::int64_t begin, std::int64_t end, std::vector<FacetPrint>& repeated) {
        for (auto v = static_cast<std::size_t>(begin); v < static_cast<std::size_t>(end); ++v) {
          const auto first = buckets.prints.begin() + buckets.first[v];
          const auto last = buckets.prints.begin() + buckets.first[v + 1];
          std::sort(first, last);
          for (auto same = first; (same = std::adjacent_find(same, last)) != last; ++same)
            repeated.push_back({static_cast<std::uint32_t>(v), *same});
        }
      });
}

}  // namespace neurframe
