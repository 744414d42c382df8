// Readers and writers: round trips, and a located complaint for every kind of bad file.
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include "core/hex_io.hpp"
#include "core/hex_map_io.hpp"
#include "core/quad_map_io.hpp"
#include "core/testing.hpp"
#include "core/tet_io.hpp"

using namespace neurframe;

static std::string scratch_path(const std::string& name) {
  static const std::filesystem::path folder = [] {
    const auto made = std::filesystem::temp_directory_path() / ("neurframe_io_" + std::to_string(::getpid()));
    std::filesystem::create_directories(made);
    return made;
  }();
  return (folder / name).string();
}

static std::string file_with(const std::string& text) {
  const std::string path = scratch_path("given.txt");
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

static const std::string one_tet =
    "4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1\n0 1 2 3 0 0 0 1/2 0 0 0 -3/4 0 0 0 1e0\n";

static void test_hex_map() {
  const HexMap map = read_hex_map(file_with(one_tet + "trailing walls are ignored"));
  CHECK(map.parameters[0][1][0] == 0.5 && map.parameters[0][2][1] == -0.75 && map.parameters[0][3][2] == 1.0);
  write_hex_map(scratch_path("copy.hexex"), map);
  const HexMap copy = read_hex_map(scratch_path("copy.hexex"));
  CHECK(copy.mesh.V == map.mesh.V && copy.mesh.T == map.mesh.T && copy.parameters == map.parameters);
}

static void test_bad_hex_maps() {
  CHECK_THROWS(read_hex_map(scratch_path("absent")), InputError, "cannot be opened");
  CHECK_THROWS(read_hex_map(file_with("")), InputError, "found the end of the file");
  CHECK_THROWS(read_hex_map(file_with("4\n0 0 0\n1 x 0\n")), InputError, "only");
  CHECK_THROWS(read_hex_map(file_with("2\n0 0 0\n1 x 0\n")), InputError,
               ":3: expected y (a finite number), found 'x'");
  CHECK_THROWS(read_hex_map(file_with("999999999999\n0 0 0\n")), InputError, "bytes are left");
  CHECK_THROWS(read_hex_map(file_with("-4\n")), InputError, "an integer from 0");
  CHECK_THROWS(read_hex_map(file_with("1\n0 0 nan\n")), InputError, "finite");
  CHECK_THROWS(read_hex_map(file_with("1\n0 0 1e999\n")), InputError, "finite");
  CHECK_THROWS(read_hex_map(file_with("1\n0 0 1/0\n")), InputError, "finite");
  CHECK_THROWS(read_hex_map(file_with("1\n0 0 0\n0\n")), InputError, "no tet");
  CHECK_THROWS(read_hex_map(file_with("1\n0 0 0\n1\n0 0 0 7 0 0 0 0 0 0 0 0 0 0 0 0")), InputError,
               ":4: expected a vertex index");
  // an infinite or vanishing denominator, and an overflow whose exponent is negative
  for (const char* number : {"1/inf", "1/1e-400", "1/nan", "1/", "/1", "+", "inf/inf"}) {
    CHECK_THROWS(read_hex_map(file_with(std::string("1\n0 0 ") + number + "\n")), InputError, "finite");
  }
  CHECK_THROWS(read_hex_map(file_with("1\n0 0 1" + std::string(400, '0') + "e-5\n")), InputError, "finite");
  const HexMap tiny = read_hex_map(file_with("1\n0 0 1e-400\n1\n0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0"));
  CHECK(tiny.mesh.V[0][2] == 0.0);
}

static const std::string two_triangles =
    "# made by hand\nv 0 0 0\nv 1 0 0 0.5\r\nv 0 1 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nvt 1 1\no name\n"
    "f 1/1 2/2 3/3\nf 3/-2/1 2/2/1 -1/4\n# neurframe transition 0 1 3 -2 5\n#\n";

static void test_quad_map() {
  const QuadMap map = read_quad_map(file_with(two_triangles));
  CHECK(map.mesh.F == (std::vector<Triangle>{{0, 1, 2}, {2, 1, 3}}));
  CHECK(map.parameters[1][0] == (Vector2<double>{0, 1}));
  CHECK(map.transitions.size() == 1 && map.transitions[0].transition.rotation == QuarterTurn(3));
  write_quad_map(scratch_path("copy.obj"), map);
  const QuadMap copy = read_quad_map(scratch_path("copy.obj"));
  CHECK(copy.mesh.V == map.mesh.V && copy.mesh.F == map.mesh.F && copy.parameters == map.parameters);
  CHECK(copy.transitions[0].transition == map.transitions[0].transition && copy.transitions[0].g == 1);
}

static void test_bad_quad_maps() {
  CHECK_THROWS(read_quad_map(file_with("v 0 0 0\nf 1 1 1\n")), InputError, ":2: expected a corner v/vt");
  CHECK_THROWS(read_quad_map(file_with("v 0 0 0\nvt 0 0\nf 1/1 2/1 1/1\n")), InputError,
               "vertex 2, but 1 are defined");
  CHECK_THROWS(read_quad_map(file_with("v 0 0 0\nvt 0 0\nf 1/1 1/1\n")), InputError,
               "fewer than three corners");
  CHECK_THROWS(read_quad_map(file_with("v 0 0 0\nvt 0 0\nf 1/1 1/1 1/1 1/1\n")), InputError,
               "more than three");
  CHECK_THROWS(read_quad_map(file_with("v 0 0\nvt 0 0\n")), InputError, ":2: expected z");
  CHECK_THROWS(read_quad_map(file_with("# nothing\n")), InputError, "no triangle");
  CHECK_THROWS(read_quad_map(file_with("# neurframe transition 0 1 4 0 0\n")), InputError, "quarter turns");
}

static void test_tets_and_frames() {
  const TetMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1.0 / 3.0}}, {{0, 1, 2, 3}}};
  write_tet_mesh(scratch_path("t.mesh"), mesh);
  const TetMesh copy = read_tet_mesh(scratch_path("t.mesh"));
  CHECK(copy.V == mesh.V && copy.T == mesh.T);
  const std::string header = "MeshVersionFormatted 2\nDimension\n3\n# comment\nTriangles 1\n1 2 3 7\n";
  CHECK_THROWS(read_tet_mesh(file_with(header)), InputError, "no tet");
  CHECK_THROWS(read_tet_mesh(file_with(header + "Cheese 3\n")), InputError, "unknown section 'Cheese'");
  CHECK_THROWS(read_tet_mesh(file_with(header + "Tetrahedra 1\n1 2 3 4 0\nEnd")), InputError, "vertex 0");
  const std::vector<Frame> frames{{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}};
  write_frames(scratch_path("t.fra"), frames);
  CHECK(read_frames(scratch_path("t.fra")) == frames);
  CHECK_THROWS(read_frames(file_with("FRA 2\n")), InputError, "the format version");
  CHECK_THROWS(read_frames(file_with("FRA 1\n1 2 1\n0 0 0 0 0 0 0 0 0")), InputError, "vectors per tet");
}

static void test_atomic_writer() {
  const std::string path = scratch_path("kept.txt");
  std::ofstream(path) << "old";
  {
    TextWriter(path) << "new, but not committed";
  }
  CHECK(read_file(path) == "old");
  TextWriter out(path);
  out << "new " << 0.1 << ' ' << std::int64_t{-7};
  out.commit();
  CHECK(read_file(path) == "new 0.1 -7");
  CHECK_THROWS(TextWriter("/nonexistent folder/x"), InputError, "cannot be written");
}

static void test_hex_writers() {
  const HexMesh cube{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}},
                     {{0, 1, 2, 3, 4, 5, 6, 7}}};
  write_hex_mesh(scratch_path("cube.mesh"), cube);
  CHECK(read_file(scratch_path("cube.mesh")).find("Hexahedra\n1\n1 2 3 4 5 6 7 8 0\nEnd") !=
        std::string::npos);
  write_hex_mesh(scratch_path("cube.vtk"), cube);
  CHECK(read_file(scratch_path("cube.vtk")).find("CELLS 1 9\n8 0 1 2 3 4 5 6 7\nCELL_TYPES 1\n12") !=
        std::string::npos);
  CHECK_THROWS(write_hex_mesh(scratch_path("cube.xyz"), cube), InputError, "unknown format");
}

// Two hexes that share the face 4 5 6 7: 20 edges, 11 faces, and the half-faces look inward: the first hex,
// whose outward face was added, has the back of it, the second one the front.
static void test_ovm() {
  HexMesh column;
  for (int z = 0; z < 3; ++z) {
    for (const auto& [x, y] : {std::pair(0.0, 0.0), {1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}}) {
      column.V.push_back({x, y, static_cast<double>(z)});
    }
  }
  column.H = {{0, 1, 2, 3, 4, 5, 6, 7}, {4, 5, 6, 7, 8, 9, 10, 11}};
  const detail::HexSkeleton skeleton = detail::hex_skeleton(column);
  CHECK(skeleton.edges.size() == 20 && skeleton.faces.size() == 11);
  CHECK(skeleton.cells[0][1] == 3 && skeleton.cells[1][0] == 2);
  write_hex_mesh(scratch_path("column.ovm"), column);
  CHECK(read_file(scratch_path("column.ovm")).starts_with("OVM ASCII\nVertices\n12\n0 0 0\n"));
}

// A device has no size, so what is read counts; a file of nothing but a hole is refused before.
static void test_too_large() {
  const std::string path = scratch_path("huge.hexex");
  std::ofstream(path).put('1');
  std::filesystem::resize_file(path, most_file_bytes + 1);
  CHECK_THROWS(read_hex_map(path), InputError, "more than 8 GiB");
  std::filesystem::remove(path);
}

// The temporary name can be guessed: a link of that name must not be written through.
static void test_planted_link() {
  const std::string path = scratch_path("out.txt");
  const std::string victim = scratch_path("victim.txt");
  std::ofstream(victim) << "untouched";
  std::filesystem::create_symlink(victim, path + ".tmp" + std::to_string(::getpid()));
  TextWriter out(path);
  out << "result";
  out.commit();
  CHECK(read_file(victim) == "untouched" && read_file(path) == "result");
  CHECK(!std::filesystem::is_symlink(path));
}

int main() {
  test_hex_map();
  test_bad_hex_maps();
  test_quad_map();
  test_bad_quad_maps();
  test_tets_and_frames();
  test_atomic_writer();
  test_hex_writers();
  test_ovm();
  test_too_large();
  test_planted_link();
  std::filesystem::remove_all(std::filesystem::path(scratch_path("x")).parent_path());
  return test_result();
}
