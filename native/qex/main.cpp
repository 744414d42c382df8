// neurframe-qex: the quad mesh of an integer-grid map.
#include <string>
#include <utility>

#include "core/extraction/report.hpp"
#include "core/program.hpp"
#include "core/quad_map_io.hpp"
#include "core/step_clock.hpp"
#include "qex/build_quad_grid_map.hpp"

namespace neurframe {
namespace {

CommandLine command_line() {
  return {
      "neurframe-qex",
      "Extracts the quad mesh of an integer-grid map (OBJ with one vt per corner), exactly and in parallel.\n"
      "Comment lines `# neurframe transition f g r tu tv` in MAP.obj give exact transition functions.",
      {"MAP.obj"},
      {{"--output", "-o", "OUT.obj", "quad mesh", true},
       {"--locations", "", "FILE", "per vertex of OUT: triangle of MAP and 3 barycentric coordinates"}}};
}

ExitCode extract(const Arguments& arguments, Json& statistics) {
  const int threads = worker_threads(arguments);
  Json cpu_seconds;  // a copy goes into the statistics at the end
  StepClock clock(cpu_seconds);
  report_progress(0.0, "reading");
  QuadMap real = read_quad_map(arguments.positional(0));
  clock.finish("read");
  report_progress(0.2, "exact map");
  bool mirrored = false;
  MapReport report;
  const GridMap<2> map = build_quad_grid_map(std::move(real), threads, mirrored, report);
  clock.finish("exact_map");
  const Extraction<2> extraction = extract_cells(map, threads, [](double fraction, const std::string& step) {
    report_progress(0.3 + 0.6 * fraction, step);
  });
  clock.finish("extract");
  report_map(map, report, statistics);
  statistics["mirrored"] = mirrored;
  statistics["quads"] = extraction.cells.size();
  statistics["vertices"] = extraction.V.size();
  statistics["folded_cells"] = extraction.folded_cells;
  statistics["joined_vertices"] = extraction.joined_vertices;
  statistics["separated_vertices"] = extraction.separated_vertices;
  report_losses(map, extraction, statistics);
  const bool complete = is_complete(report, extraction);
  statistics["complete"] = complete;
  report_progress(0.9, "writing");
  write_quads_obj(arguments.text("--output"), extraction.V, extraction.cells);
  if (arguments.given("--locations")) write_locations<2>(arguments.text("--locations"), extraction.locations);
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
