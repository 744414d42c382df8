// The seed corpora: small files of every kind, written by our own writers where there are some.
//   write_seeds FOLDER      writes FOLDER/NAME/seed... for each harness fuzz_NAME
#include <cstdio>
#include <filesystem>
#include <string>

#include "core/hex_map_io.hpp"
#include "core/quad_map_io.hpp"
#include "core/tet_io.hpp"
#include "fuzz/fuzz_target.hpp"

namespace neurframe {
namespace {

using std::filesystem::path;

const std::string crosses = "1 0 0 0 1 0\n0 1 0 0 0 1\n0 0 1 1 0 0\n1 0 0 0 1 0\n";
const std::string features = R"({"format": "neurframe-features", "edges": [[0, 1], [1, 2], [4, 7]]})";

void write_text(const path& file, const std::string& text) {
  TextWriter out(file.string());
  out << text;
  out.commit();
}

path corpus(const path& folder, const char* name) {
  std::filesystem::create_directories(folder / name);
  return folder / name;
}

// The unit cube of five tets.
TetMesh cube() {
  TetMesh mesh;
  for (int v = 0; v < 8; ++v) mesh.V.push_back({double(v & 1), double(v >> 1 & 1), double(v >> 2)});
  mesh.T = {{0, 1, 2, 4}, {1, 3, 2, 7}, {1, 4, 5, 7}, {2, 6, 4, 7}, {1, 2, 4, 7}};
  return mesh;
}

// Each cell edge is 1 / cells.
HexMap cube_map(double cells) {
  HexMap map{cube(), {}};
  for (const Tet& tet : map.mesh.T) {
    auto& corners = map.parameters.emplace_back();
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t k = 0; k < 3; ++k) corners[i][k] = cells * map.mesh.V[std::size_t(tet[i])][k];
    }
  }
  return map;
}

// `sectors` triangles round a vertex; each is half a square of 4 cells, turned a quarter from one to the
// next.
QuadMap fan_map(int sectors) {
  QuadMap map;
  map.mesh.V.push_back({0, 0, 0});
  for (int s = 0; s < sectors; ++s) {
    const double angle = 6.283185307179586 * s / sectors;
    map.mesh.V.push_back({std::cos(angle), std::sin(angle), 0});
  }
  for (int s = 0; s < sectors; ++s) {
    map.mesh.F.push_back({0, 1 + s, 1 + (s + 1) % sectors});
    map.parameters.push_back({{{0, 0}, {2, 0}, {0, 2}}});
    map.transitions.push_back({s, (s + 1) % sectors, {QuarterTurn(3), {0, 0}}});
  }
  return map;
}

std::string contents(const path& file) {
  return read_file(file.string());
}

void write_maps(const path& folder) {
  write_hex_map((corpus(folder, "hex_map") / "cube1").string(), cube_map(1));
  write_hex_map((corpus(folder, "hex_map") / "cube3").string(), cube_map(3));
  write_quad_map((corpus(folder, "quad_map") / "fan3").string(), fan_map(3));
  write_quad_map((corpus(folder, "quad_map") / "fan5").string(), fan_map(5));
  write_text(
      corpus(folder, "quad_map") / "square",
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 3 0\nvt 3 3\nvt 0 3\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n");
}

void write_fields(const path& folder) {
  const path tets = corpus(folder, "tet_mesh") / "cube";
  const path frames = corpus(folder, "frames") / "axes";
  write_tet_mesh(tets.string(), cube());
  write_frames(frames.string(), std::vector<Frame>(5, Frame{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}));
  write_text(corpus(folder, "features") / "json", features);
  write_text(corpus(folder, "features") / "text", "0 1\n# a comment\n4 7\n");
  const std::string files = contents(tets) + std::string(part_separator) + contents(frames) +
                            std::string(part_separator) + features;
  write_text(corpus(folder, "field_mesh") / "cube", files);
  write_text(corpus(folder, "cubecover") / "cube", files);
}

void write_surfaces(const path& folder) {
  const std::string separator(part_separator);
  const std::string surface =
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2/1 3/2 4/3\nf -4//1 -1//1 -2//1\n";
  const std::string sizing = "1\n0.5\n2\n1\n";
  const std::string rosy = "4\n4\n1 0 0\n0 1 0\n0 0 1\n1 0 0\n";
  for (const char* name : {"surface", "miq"}) {
    write_text(
        corpus(folder, name) / "tetrahedron",
        surface + separator + crosses + separator + "0 1\n2 3\n" + separator + sizing + separator + rosy);
  }
}

void write_command_lines(const path& folder) {
  write_text(corpus(folder, "arguments") / "all", "in.obj\n-o\nout.obj\n--count\n4\n--factor\n2.5\n--flag");
}

}  // namespace
}  // namespace neurframe

int main(int argc, char** argv) {
  using namespace neurframe;
  if (argc != 2) return std::fputs("usage: write_seeds FOLDER\n", stderr), 2;
  write_maps(argv[1]);
  write_fields(argv[1]);
  write_surfaces(argv[1]);
  write_command_lines(argv[1]);
  return 0;
}
