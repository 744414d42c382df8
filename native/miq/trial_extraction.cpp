#include "miq/trial_extraction.hpp"

#include "core/extraction/extract_cells.hpp"
#include "qex/build_quad_grid_map.hpp"

namespace neurframe {

LostQuads lost_quads(const QuadMap& map, int threads) {
  bool mirrored = false;
  MapReport report;
  const GridMap<2> grid = build_quad_grid_map(map, threads, mirrored, report);
  const Extraction<2> extraction = extract_cells(grid, threads, [](double, const std::string&) {});
  LostQuads lost;
  lost.count = static_cast<int>(extraction.lost.size());
  for (const LostCell<2>& cell : extraction.lost) {
    lost.places.push_back(position(grid, locate(grid, cell.simplex, cell.centre)));
  }
  return lost;
}

}  // namespace neurframe
