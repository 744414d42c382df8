// neurframe-hexex: the hex mesh of an integer-grid map.
#include <string>
#include <utility>

#include "core/extraction/report.hpp"
#include "core/hex_io.hpp"
#include "core/hex_map_io.hpp"
#include "core/program.hpp"
#include "core/step_clock.hpp"
#include "hexex/build_hex_grid_map.hpp"

namespace neurframe {
namespace {

CommandLine command_line() {
  return {"neurframe-hexex",
          "Extracts the hex mesh of an integer-grid map (text format of HexEx), exactly and in parallel.",
          {"MAP.hexex"},
          {{"--output", "-o", "OUT", "hex mesh: .mesh (MEDIT), .vtk (legacy) or .ovm", true},
           {"--locations", "", "FILE", "per vertex of OUT: tet of MAP and 4 barycentric coordinates"},
           {"--partial-boundary", "", "", "allow boundary faces that lie on no integer plane"}}};
}

// The corners of turned tets were swapped; the file has them in the order of MAP.
std::vector<Location<3>> in_order_of_file(std::vector<Location<3>> locations,
                                          const std::vector<char>& turned) {
  for (Location<3>& location : locations) {
    if (turned[static_cast<std::size_t>(location.simplex)] != 0)
      std::swap(location.weights[2], location.weights[3]);
  }
  return locations;
}

ExitCode extract(const Arguments& arguments, Json& statistics) {
  const int threads = worker_threads(arguments);
  const std::string output = arguments.text("--output");
  check_hex_format(output);
  Json cpu_seconds;  // a copy goes into the statistics at the end
  StepClock clock(cpu_seconds);
  report_progress(0.0, "reading");
  HexMap real = read_hex_map(arguments.positional(0));
  clock.finish("read");
  report_progress(0.2, "exact map");
  OrientationReport orientation;
  MapReport report;
  const GridMap<3> map = build_hex_grid_map(std::move(real), arguments.given("--partial-boundary"), threads,
                                            orientation, report);
  clock.finish("exact_map");
  Extraction<3> extraction = extract_cells(map, threads, [](double fraction, const std::string& step) {
    report_progress(0.3 + 0.6 * fraction, step);
  });
  clock.finish("extract");
  report_map(map, report, statistics);
  statistics["turned_tets"] = orientation.turned_tets;
  statistics["mirrored_components"] = orientation.mirrored_components;
  statistics["hexes"] = extraction.cells.size();
  statistics["vertices"] = extraction.V.size();
  statistics["folded_cells"] = extraction.folded_cells;
  statistics["joined_vertices"] = extraction.joined_vertices;
  statistics["separated_vertices"] = extraction.separated_vertices;
  report_losses(map, extraction, statistics);
  const bool complete = is_complete(report, extraction);
  statistics["complete"] = complete;
  report_progress(0.9, "writing");
  write_hex_mesh(output, {std::move(extraction.V), std::move(extraction.cells)});
  if (arguments.given("--locations")) {
    write_locations<3>(arguments.text("--locations"),
                       in_order_of_file(extraction.locations, orientation.turned));
  }
  clock.finish("write");
  statistics["cpu_seconds"] = cpu_seconds;
  report_progress(1.0, "done");
  return complete ? ExitCode::done : ExitCode::incomplete;
}

}  // namespace
}  // namespace neurframe

int main(int argc, char** argv) {
  return neurframe::run_program(neurframe::command_line(), argc, argv, neurframe::extract);
}
