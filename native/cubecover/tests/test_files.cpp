// Feature files, and a map that is read back from its file exactly.
#include <cstdio>
#include <fstream>

#include "core/testing.hpp"
#include "cubecover/map_io.hpp"
#include "cubecover/parametrize.hpp"
#include "grid_meshes.hpp"

namespace neurframe {
namespace {

std::string written(const char* name, const std::string& text) {
  std::ofstream(name) << text;
  return name;
}

void test_features() {
  const std::vector<EdgeKey> wanted = {{0, 3}, {2, 4}};
  const std::string json =
      R"({"format": "neurframe-features", "edges": [[3, 0], [2,4]], "chains": [[0, 3]]})";
  CHECK(read_features(written("cubecover_features.json", json), 5) == wanted);
  CHECK(read_features(written("cubecover_features.txt", "3 0\n# a comment\n2 4\n"), 5) == wanted);
  CHECK(read_features(written("cubecover_features.json", R"({"edges": []})"), 5).empty());
  CHECK_THROWS(read_features(written("cubecover_features.txt", "0 5\n"), 5), InputError, "0 to 4");
  CHECK_THROWS(read_features(written("cubecover_features.txt", "0 1 2\n"), 5), InputError, "end of the file");
  CHECK_THROWS(read_features(written("cubecover_features.json", R"({"corners": []})"), 5), InputError,
               "edges");
  std::remove("cubecover_features.json");
  std::remove("cubecover_features.txt");
}

void test_map_round_trip() {
  const Parametrization result =
      parametrize(cylinder(6, 2, 0.6), {0.25, 0, 1}, [](double, const std::string&) {});
  const char* path = "cubecover_round_trip.hexex";
  write_hex_map(path, to_hex_map(result.field.mesh, result.map));
  const HexMap map = read_hex_map(path);
  std::remove(path);
  CHECK(map.mesh.T == result.field.mesh.tets);
  ExactMap read{result.map.fraction_bits, {}};
  for (const auto& corners : map.parameters) {
    auto& parameters = read.parameters.emplace_back();
    for (std::size_t c = 0; c < 4; ++c) {
      for (std::size_t i = 0; i < 3; ++i) parameters[c][i] = to_fixed(corners[c][i], read.fraction_bits);
    }
  }
  CHECK(read.parameters == result.map.parameters);
}

void test_bad_frames_are_refused() {
  const FieldMesh mesh = box({1, 1, 1});
  std::vector<Eigen::Matrix3d> frames = mesh.frames;
  frames[2].col(1) = frames[2].col(0);
  CHECK_THROWS(make_field_mesh(mesh.points, mesh.tets, frames, {}), InputError, "tet 2");
  frames.pop_back();
  CHECK_THROWS(make_field_mesh(mesh.points, mesh.tets, frames, {}), InputError, "one frame per tet");
}

}  // namespace
}  // namespace neurframe

int main() {
  neurframe::test_features();
  neurframe::test_map_round_trip();
  neurframe::test_bad_frames_are_refused();
  return neurframe::test_result();
}
