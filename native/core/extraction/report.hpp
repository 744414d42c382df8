// What an extraction says about its map and its losses: the statistics and the location file.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "core/extraction/build_grid_map.hpp"
#include "core/extraction/extract_cells.hpp"
#include "core/json.hpp"
#include "core/text_writer.hpp"

namespace neurframe {

inline constexpr std::size_t most_located_losses = 1000;

template <int N>
void report_map(const GridMap<N>& map, const MapReport& report, Json& statistics) {
  statistics[std::string(SimplexNames<N>::simplex) + "s"] = map.P.size();
  statistics["input_vertices"] = map.V.size();
  statistics["fraction_bits"] = map.fraction_bits;
  statistics["parametric_volume"] = report.parametric_volume;
  statistics["flipped"] = report.flipped;
  statistics["flat"] = report.flat;
  statistics["boundary_facets"] = report.boundary_facets;
  statistics["unaligned_boundary_facets"] = report.unaligned_boundary_facets;
  statistics["contradictory_vertices"] = report.seamless.contradictory_vertices;
  statistics["inexact_facets"] = report.seamless.broken_facets;
  statistics["largest_move_to_seamless"] = report.seamless.largest_move;
}

template <int N>
void report_losses(const GridMap<N>& map, const Extraction<N>& extraction, Json& statistics) {
  Json& lost = statistics["lost_cells"];
  lost["total"] = extraction.lost.size();
  Json causes;
  for (const LostCell<N>& cell : extraction.lost) {
    Json& count = causes[loss_name(cell.loss)];
    count = count.integer_or(0) + 1;
  }
  lost["causes"] = causes;
  std::vector<Json> places;
  for (std::size_t i = 0; i < std::min(extraction.lost.size(), most_located_losses); ++i) {
    const LostCell<N>& cell = extraction.lost[i];
    const Point3 centre = position(map, locate(map, cell.simplex, cell.centre));
    Json place;
    place["cause"] = loss_name(cell.loss);
    place[SimplexNames<N>::simplex] = cell.simplex;
    place["at"] = std::vector<double>(centre.begin(), centre.end());
    places.push_back(place);
  }
  lost["places"] = places;
}

// Every cell of the grid has volume one, so an extraction without loss has as many cells as there is volume.
template <int N>
bool is_complete(const MapReport& report, const Extraction<N>& extraction) {
  return extraction.lost.empty() && report.whole_volume &&
         report.parametric_volume == static_cast<double>(extraction.cells.size());
}

// One line per vertex: simplex of the input (from 0) and barycentric coordinates in the order of its corners
// there.
template <int N>
void write_locations(const std::string& path, const std::vector<Location<N>>& locations) {
  TextWriter out(path);
  for (const Location<N>& location : locations) {
    out << location.simplex;
    for (const double weight : location.weights) out << ' ' << weight;
    out << '\n';
  }
  out.commit();
}

}  // namespace neurframe
