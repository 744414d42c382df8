// Extraction from a fuzzed map, kept to maps that are small: time goes into many maps, not into many cells.
#pragma once

#include "core/extraction/build_grid_map.hpp"

namespace neurframe {

// The lattice points in the boxes of all simplices.
template <int N>
double boxed_points(const GridMap<N>& map) {
  double points = 0.0;
  for (std::size_t t = 0; t < map.P.size(); ++t) {
    const LatticeBox<N> box = lattice_box(map, static_cast<int>(t), 0);
    double volume = 1.0;
    for (std::size_t k = 0; k < N; ++k) volume *= static_cast<double>(box.high[k] - box.low[k] + 2);
    points += volume;
  }
  return points;
}

// Every cell refers to vertices that exist, and every vertex has a location on the map.
template <int N>
void extract_if_small(const GridMap<N>& map) {
  if (!(boxed_points(map) < 20000.0)) return;
  const Extraction<N> out = extract_cells(map, 1, [](double, const std::string&) {});
  for (const auto& cell : out.cells) {
    for (const int v : cell) {
      if (v < 0 || static_cast<std::size_t>(v) >= out.V.size()) std::abort();
    }
  }
  for (const Location<N>& location : out.locations) {
    if (location.simplex < 0 || static_cast<std::size_t>(location.simplex) >= map.S.size()) std::abort();
  }
}

}  // namespace neurframe
