// neurframe-cubecover: a tet mesh and one frame per tet to an integer-grid map.
#include <cmath>

#include "core/program.hpp"
#include "cubecover/map_io.hpp"
#include "cubecover/report.hpp"

namespace neurframe {
namespace {

const CommandLine command_line = {
    "neurframe-cubecover",
    "Builds an integer-grid map (map.hexex) from tets (MEDIT) and frames (FRA 1).  Statistics go to stdout "
    "as JSON;\n"
    "a map that is not valid is still written, with exit status 4 and the places of what is wrong.",
    {"TETS.mesh", "FRAMES.fra"},
    {{"--output", "-o", "MAP.hexex", "where the map goes", true},
     {"--features", "", "FILE", "feature edges: features.json, or text with two vertex numbers a line",
      false},
     {"--feature-angle", "", "DEG", "without --features: edges that bend by more are features (default 45)",
      false},
     {"--edge-length", "", "H", "target edge length of the hexes, in units of the mesh", false},
     {"--scale", "", "S", "... or the bounding-box diagonal divided by it (default 30)", false},
     {"--target-cells", "", "N", "... or the number of hexes", false},
     {"--polycube", "", "WHEN",
      "a map without singular lines: never, auto (where no field of frames carries a map; default), only",
      false},
     {"--retries", "", "N", "more tries, refined where the map is not valid (default 2)", false},
     {"--alternative", "", "N", "the N-th best of the valid maps that differ (default 1)", false}}};

FieldMesh read_field_mesh(const Arguments& arguments) {
  const TetMesh tets = read_tet_mesh(arguments.positional(0));
  std::vector<EdgeKey> features;
  if (arguments.given("--features")) {
    features = read_features(arguments.text("--features"), static_cast<int>(tets.V.size()));
  }
  FieldMesh mesh = to_field_mesh(tets, read_frames(arguments.positional(1)), std::move(features));
  const double angle_deg = arguments.number("--feature-angle", 45, 0, 180);
  if (!arguments.given("--features")) mesh.features = sharp_edges(mesh, angle_deg);
  return mesh;
}

Polycubes when_polycubes(const Arguments& arguments) {
  const std::string when = arguments.given("--polycube") ? arguments.text("--polycube") : "auto";
  if (when == "never") return Polycubes::never;
  if (when == "only") return Polycubes::only;
  if (when != "auto") throw InputError("--polycube takes never, auto or only, not " + when);
  return Polycubes::where_needed;
}

double cell_length(const Arguments& arguments, const FieldMesh& mesh) {
  const int given =
      arguments.given("--edge-length") + arguments.given("--scale") + arguments.given("--target-cells");
  if (given > 1) throw InputError("give only one of --edge-length, --scale and --target-cells");
  if (arguments.given("--edge-length")) return arguments.number("--edge-length", 0, 1e-300, 1e300);
  if (arguments.given("--target-cells")) {
    double volume = 0;
    for (int t = 0; t < mesh.tet_count(); ++t) volume += tet_volume(mesh, t);
    return std::cbrt(volume / arguments.integer("--target-cells", 0, 1, 1000000000));
  }
  return diagonal(mesh) / arguments.number("--scale", 30, 1e-3, 1e6);
}

ExitCode run(const Arguments& arguments, Json& statistics) {
  const FieldMesh mesh = read_field_mesh(arguments);
  const ParametrizeOptions options{cell_length(arguments, mesh), arguments.integer("--retries", 2, 0, 20),
                                   worker_threads(arguments), when_polycubes(arguments),
                                   arguments.integer("--alternative", 1, 1, 20)};
  statistics["edge_length"] = options.cell_length;
  const Parametrization result = parametrize(mesh, options, report_progress);
  write_hex_map(arguments.text("--output"), to_hex_map(result.field.mesh, result.map));
  describe(result, statistics);
  report_progress(1, result.verification.valid() ? "valid map written" : "map written, but it is not valid");
  return result.verification.valid() ? ExitCode::done : ExitCode::incomplete;
}

}  // namespace
}  // namespace neurframe

int main(int argc, char** argv) {
  return neurframe::run_program(neurframe::command_line, argc, argv, neurframe::run);
}
