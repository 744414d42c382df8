// No facet of the result has more than two cells, nor two on the same side of it.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "core/extraction/assemble_cells.hpp"
#include "core/extraction/facet_prints.hpp"

namespace neurframe {

namespace detail {

template <int N>
struct CrowdedFacet {
  FacetVertices<N> vertices;  // sorted
  int cell;
  bool reversed;  // which way round the cell sees the facet

  auto operator<=>(const CrowdedFacet&) const = default;
};

// The facets with these prints, in order of vertices, then of cells.
template <int N>
std::vector<CrowdedFacet<N>> facets_of_prints(const std::vector<CellVertices<N>>& cells,
                                              const std::vector<FacetPrint>& prints) {
  std::vector<CrowdedFacet<N>> found;
  for (std::size_t c = 0; c < cells.size() && !prints.empty(); ++c) {
    for_each_facet_print<N>(cells[c], [&](std::size_t facet, FacetPrint print) {
      if (!std::binary_search(prints.begin(), prints.end(), print)) return;
      FacetVertices<N> vertices = cell_facet<N>(cells[c], facet);
      std::sort(vertices.begin(), vertices.end());
      found.push_back({vertices, static_cast<int>(c), (print.print & 1u) != 0});
    });
  }
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace detail

// Drops cells, latest first, until every facet has at most two, on opposite sides.
template <int N>
void drop_crowding_cells(const TracedCells<N>& traced, int vertices, int threads, AssembledCells<N>& out) {
  const std::vector<detail::CrowdedFacet<N>> facets =
      detail::facets_of_prints<N>(out.cells, repeated_facet_prints<N>(out.cells, vertices, threads));
  if (facets.empty()) return;
  std::vector<char> dropped(out.cells.size(), 0);
  for (auto facet = facets.begin(); facet != facets.end();) {
    bool taken[2] = {false, false};
    for (const auto start = facet; facet != facets.end() && facet->vertices == start->vertices; ++facet) {
      char& drop = dropped[static_cast<std::size_t>(facet->cell)];
      bool& side = taken[facet->reversed ? 1 : 0];
      if (drop == 0 && side) drop = 1;
      side = side || drop == 0;
    }
  }
  detail::filter_cells(traced, CellLoss::crowded_facet, out, [&](std::size_t c) { return dropped[c] == 0; });
}

}  // namespace neurframe
