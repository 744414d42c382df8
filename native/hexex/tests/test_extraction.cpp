// Whole extractions on maps whose hex mesh is known: cubes, turned charts, singular edges, folds and flat
// tets.
#include <map>
#include <set>

#include "core/hex_io.hpp"
#include "core/testing.hpp"
#include "hexex/build_hex_grid_map.hpp"
#include "hexex/tests/sample_maps.hpp"

using namespace neurframe;

struct Result {
  HexMesh mesh;
  std::vector<LostCell<3>> lost;
  int folded_cells;
};

static Result extracted(const HexMap& map, int threads = 1) {
  OrientationReport orientation;
  MapReport report;
  const GridMap<3> grid = build_hex_grid_map(map, false, threads, orientation, report);
  const Extraction<3> found = extract_cells(grid, threads, [](double, const std::string&) {});
  return {{found.V, found.cells}, found.lost, found.folded_cells};
}

// Every face in one or two hexes, and those on opposite sides.
static bool is_manifold(const HexMesh& mesh) {
  std::map<std::array<int, 4>, std::set<std::array<int, 4>>> sides;
  for (const Hex& hex : mesh.H) {
    for (const auto& corners : hex_faces) {
      std::array<int, 4> face{};
      for (std::size_t k = 0; k < 4; ++k) face[k] = hex[static_cast<std::size_t>(corners[k])];
      std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
      std::array<int, 4> key = face;
      std::sort(key.begin(), key.end());
      if (!sides[key].insert(face).second) return false;
    }
  }
  return std::all_of(sides.begin(), sides.end(), [](const auto& side) { return side.second.size() <= 2; });
}

static std::size_t boundary_quads(const HexMesh& mesh) {
  std::map<std::array<int, 4>, int> hexes;
  for (const Hex& hex : mesh.H) {
    for (const auto& corners : hex_faces) {
      std::array<int, 4> key{};
      for (std::size_t k = 0; k < 4; ++k) key[k] = hex[static_cast<std::size_t>(corners[k])];
      std::sort(key.begin(), key.end());
      ++hexes[key];
    }
  }
  return static_cast<std::size_t>(
      std::count_if(hexes.begin(), hexes.end(), [](const auto& f) { return f.second == 1; }));
}

// Every hex is an upright cube of edge 1 / cells, its corners in VTK order up to rotation.
static bool is_cube_grid(const HexMesh& mesh, int cells) {
  for (const Hex& hex : mesh.H) {
    const auto at = [&](int i) { return mesh.V[static_cast<std::size_t>(hex[static_cast<std::size_t>(i)])]; };
    const Point3 a = difference(at(1), at(0));
    const Point3 b = difference(at(3), at(0));
    const Point3 c = difference(at(4), at(0));
    const double volume = a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
                          a[2] * (b[0] * c[1] - b[1] * c[0]);
    if (std::abs(volume * cells * cells * cells - 1.0) > 1e-6) return false;
    const Point3 diagonal = difference(at(6), at(0));
    for (std::size_t k = 0; k < 3; ++k) {
      if (std::abs(std::abs(diagonal[k]) * cells - 1.0) > 1e-6) return false;
      if (std::abs(a[k] + b[k] + c[k] - diagonal[k]) > 1e-6) return false;
    }
  }
  return true;
}

static void check_cube(const HexMap& map, int cells, int threads) {
  const Result result = extracted(map, threads);
  const auto n = static_cast<std::size_t>(cells);
  CHECK(result.lost.empty());
  CHECK(result.mesh.H.size() == n * n * n);
  CHECK(result.mesh.V.size() == (n + 1) * (n + 1) * (n + 1));
  CHECK(is_cube_grid(result.mesh, cells));
  CHECK(is_manifold(result.mesh));
  CHECK(boundary_quads(result.mesh) == 6 * n * n);
}

static void test_cubes() {
  std::mt19937 random(1);
  for (const int cells : {1, 2, 3, 7, 11}) {
    HexMap map = cube_map(3, cells);
    check_cube(map, cells, 1);
    jitter_cube(map, cells, 0.05, random);
    check_cube(map, cells, 1);
    rechart(map, random);
    check_cube(map, cells, 2);
  }
}

// Grid points and cell centres on vertices, edges and faces of the tets, in turned charts.
static void test_degenerate_alignment() {
  std::mt19937 random(2);
  for (const auto& [n, cells] : {std::pair(4, 4), {4, 8}, {4, 2}, {5, 5}, {3, 12}, {8, 4}}) {
    HexMap map = cube_map(n, cells);
    rechart(map, random);
    check_cube(map, cells, 1);
  }
}

static bool same_mesh(const HexMesh& a, const HexMesh& b) {
  return a.V == b.V && a.H == b.H;
}

static void test_threads_do_not_matter() {
  std::mt19937 random(3);
  HexMap map = cube_map(9, 12);
  fold_cube(map, 0.9, std::ldexp(1.0, -20), random);
  rechart(map, random);
  const Result one = extracted(map, 1);
  CHECK(same_mesh(one.mesh, extracted(map, 2).mesh));
  CHECK(same_mesh(one.mesh, extracted(map, 5).mesh));
}

static void test_singular_edges() {
  std::mt19937 random(4);
  for (const int sectors : {3, 5, 6, 7}) {
    for (const int cells : {1, 2, 5}) {
      HexMap map = sector_map(sectors, 3, cells);
      rechart(map, random, 1e-6);
      const Result result = extracted(map);
      CHECK(result.lost.empty());
      CHECK(result.mesh.H.size() == static_cast<std::size_t>(sectors * cells * cells * cells));
      CHECK(result.mesh.V.size() ==
            static_cast<std::size_t>((cells + 1) * (1 + sectors * cells * (cells + 1))));
      CHECK(is_manifold(result.mesh));
      CHECK(boundary_quads(result.mesh) == static_cast<std::size_t>(4 * sectors * cells * cells));
    }
  }
}

// Inner parameters moved at random: folds.  The cells are all still there, some of them seen three times.
static void test_folds() {
  std::mt19937 random(5);
  int folded = 0;
  for (int round = 0; round < 10; ++round) {
    HexMap map = cube_map(6, 9);
    fold_cube(map, 1.0, std::ldexp(1.0, -20), random);
    rechart(map, random);
    const Result result = extracted(map);
    CHECK(result.mesh.H.size() == 729 && result.mesh.V.size() == 1000);
    CHECK(is_manifold(result.mesh));
    folded += result.folded_cells;
  }
  CHECK(folded > 20);
}

// Inner parameters rounded to halves: a sixth of the tets is flat or flipped, and nearly every decision is a
// tie.
static void test_flat_tets() {
  std::mt19937 random(6);
  for (int round = 0; round < 10; ++round) {
    HexMap map = cube_map(6, 6);
    fold_cube(map, 0.4, 0.5, random);
    rechart(map, random);
    const Result result = extracted(map);
    CHECK(is_manifold(result.mesh));
    CHECK(result.mesh.H.size() == 216 && result.mesh.V.size() == 343);
  }
}

// Memory for what a wrong number spans is not asked for.
static void test_refusals() {
  CHECK_THROWS(extracted(cube_map(1, 100000)), StageError, "columns of cells, allowed are");
}

int main() {
  test_cubes();
  test_degenerate_alignment();
  test_threads_do_not_matter();
  test_singular_edges();
  test_folds();
  test_refusals();
  test_flat_tets();
  return test_result();
}
