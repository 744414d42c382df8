// neurframe-cubecover: a tet mesh and one frame per tet to an integer-grid map.
#include <cmath>

#include "core/hex_map_io.hpp"
#include "core/program.hpp"
#include "core/tet_io.hpp"
#include "cubecover/features_io.hpp"
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
     {"--target-cells", "", "N", "... or the number of hexes", false}}};

FieldMesh read_field_mesh(const Arguments& arguments) {
  const TetMesh tets = read_tet_mesh(arguments.positional(0));
  const std::vector<Frame> axes = read_frames(arguments.positional(1));
  std::vector<Eigen::Vector3d> points;
  for (const Point3& p : tets.V) points.emplace_back(p[0], p[1], p[2]);
  std::vector<Eigen::Matrix3d> frames(axes.size());
  for (std::size_t t = 0; t < axes.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const Point3& axis = at(axes[t], k);
      frames[t].col(k) = Eigen::Vector3d(axis[0], axis[1], axis[2]);
    }
  }
  std::vector<EdgeKey> features;
  if (arguments.given("--features")) {
    features = read_features(arguments.text("--features"), static_cast<int>(points.size()));
  }
  FieldMesh mesh = make_field_mesh(std::move(points), tets.T, std::move(frames), std::move(features));
  const double angle_deg = arguments.number("--feature-angle", 45, 0, 180);
  if (!arguments.given("--features")) mesh.features = sharp_edges(mesh, angle_deg);
  return mesh;
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

void write_map(const std::string& path, const Parametrization& result) {
  HexMap map;
  for (const Eigen::Vector3d& point : result.field.mesh.points)
    map.mesh.V.push_back({point.x(), point.y(), point.z()});
  map.mesh.T = result.field.mesh.tets;
  for (const auto& corners : result.map.parameters) {
    auto& parameters = map.parameters.emplace_back();
    for (int corner = 0; corner < 4; ++corner) {
      for (int axis = 0; axis < 3; ++axis) {
        at(at(parameters, corner), axis) =
            from_fixed(at(at(corners, corner), axis), result.map.fraction_bits);
      }
    }
  }
  write_hex_map(path, map);
}

ExitCode run(const Arguments& arguments, Json& statistics) {
  FieldMesh mesh = read_field_mesh(arguments);
  const ParametrizeOptions options{cell_length(arguments, mesh)};
  statistics["edge_length"] = options.cell_length;
  const Parametrization result = parametrize(std::move(mesh), options, report_progress);
  write_map(arguments.text("--output"), result);
  describe(result, statistics);
  report_progress(1, result.verification.valid() ? "valid map written" : "map written, but it is not valid");
  return result.verification.valid() ? ExitCode::done : ExitCode::incomplete;
}

}  // namespace
}  // namespace neurframe

int main(int argc, char** argv) {
  return neurframe::run_program(neurframe::command_line, argc, argv, neurframe::run);
}
