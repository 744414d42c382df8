// neurframe-miq: from crosses on the triangles of a surface to a seamless integer-grid map.
#include <cmath>

#include "core/program.hpp"
#include "core/text_reader.hpp"
#include "miq/parametrize.hpp"
#include "miq/surface_io.hpp"

namespace neurframe {
namespace {

CommandLine command_line() {
  return {"neurframe-miq",
          "Mixed-integer parametrisation: a seamless integer-grid map of a triangle mesh that follows its "
          "crosses.\n"
          "CROSS.txt has one line per triangle with two tangent vectors (6 numbers), or is a .rosy file.",
          {"SURFACE.obj", "CROSS.txt"},
          {{"--output", "-o", "MAP.obj", "the map: refined triangles with one vt per corner", true},
           {"--edge-length", "", "H", "target edge length in input units"},
           {"--scale", "", "S", "target edge length = bounding box diagonal / S (default 100)"},
           {"--target-faces", "", "N", "target number of quads, reached within 5 %"},
           {"--features", "", "FILE",
            "vertex pairs (from 0), one a line, to become edges; none are detected then"},
           {"--feature-angle", "", "DEG", "dihedral angle above which edges are features (default 45)"},
           {"--sizing", "", "FILE", "one factor on the edge length per vertex"},
           {"--singularities", "", "FILE",
            "writes x y z, quarter turns, and 1 if on a feature, per singular point"},
           {"--source", "", "FILE", "writes the input triangle of each triangle of the map"}}};
}

ParametrizeOptions options_from(const Arguments& arguments, const TriangleMesh& mesh) {
  ParametrizeOptions options;
  if (arguments.given("--edge-length") + arguments.given("--scale") + arguments.given("--target-faces") > 1) {
    throw InputError("give only one of --edge-length, --scale and --target-faces");
  }
  options.edge_length = arguments.number("--edge-length", 0, 1e-300, 1e300);
  options.integer_grid.target_faces = arguments.integer("--target-faces", 0, 1, 100000000);
  if (!arguments.given("--edge-length")) {
    options.edge_length = diagonal(mesh.V) / arguments.number("--scale", 100, 0.1, 1e6);
  }
  options.seamless.threads = options.integer_grid.threads = worker_threads(arguments);
  options.preparation.features.angle_deg = arguments.number("--feature-angle", 45, 0, 180);
  if (arguments.given("--features")) {
    options.preparation.features.given = true;
    options.preparation.features.pairs = read_vertex_pairs(arguments.text("--features"), mesh.V.size());
  }
  return options;
}

void write_singular(const std::string& path, const std::vector<SingularPoint>& points) {
  TextWriter out(path);
  for (const SingularPoint& point : points) {
    for (const double x : point.position) out << x << ' ';
    out << point.quarter_turns << ' ' << int{point.on_feature} << '\n';
  }
  out.commit();
}

ExitCode run(const Arguments& arguments, Json& statistics) {
  const TriangleMesh mesh = read_surface_obj(arguments.positional(0));
  const auto crosses = read_crosses(arguments.positional(1), mesh);
  std::vector<double> sizing;
  if (arguments.given("--sizing")) sizing = read_sizing(arguments.text("--sizing"), mesh.V.size());
  const ParametrizeOptions options = options_from(arguments, mesh);
  const Parametrization result = parametrize(mesh, crosses, sizing, options, statistics);
  write_quad_map(arguments.text("--output"), result.map);
  if (arguments.given("--source")) write_integers(arguments.text("--source"), result.source);
  if (arguments.given("--singularities")) write_singular(arguments.text("--singularities"), result.singular);
  return result.complete ? ExitCode::done : ExitCode::incomplete;
}

}  // namespace
}  // namespace neurframe

int main(int argc, char** argv) {
  return neurframe::run_program(neurframe::command_line(), argc, argv, neurframe::run);
}
