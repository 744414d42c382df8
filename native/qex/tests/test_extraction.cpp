// Whole extractions on maps whose quad mesh is known: squares, turned charts, singular vertices, folds, open
// boundaries.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <set>

#include "core/extraction/extract_cells.hpp"
#include "core/testing.hpp"
#include "qex/build_quad_grid_map.hpp"

using namespace neurframe;

struct Result {
  Extraction<2> mesh;
  MapReport report;
  bool mirrored = false;
};

static Result extracted(const QuadMap& map, int threads = 1) {
  Result result;
  const GridMap<2> grid = build_quad_grid_map(map, threads, result.mirrored, result.report);
  result.mesh = extract_cells(grid, threads, [](double, const std::string&) {});
  return result;
}

// `sectors` squares [0, 1]^2 of n x n cells of two triangles around a common corner, each with u = cells x;
// one sector is a plain square.  cells^2 quads per sector.
static QuadMap sector_map(int sectors, int n, double cells) {
  QuadMap map;
  std::map<std::array<int, 3>, int> numbers;
  const double pi = std::acos(-1.0);
  const bool closed = sectors > 1;
  const auto vertex = [&](int sector, int x, int y) {
    if (closed && x == 0 && y == 0) sector = 0;
    if (closed && x == 0 && y > 0) {  // the side x = 0 is the side y = 0 of the next sector
      sector = (sector + 1) % sectors;
      std::swap(x, y);
    }
    const auto [found, added] = numbers.try_emplace({sector, x, y}, static_cast<int>(map.mesh.V.size()));
    if (added) {
      const double a = closed ? 2.0 * pi * sector / sectors : 0.0;
      const double b = closed ? 2.0 * pi * (sector + 1) / sectors : pi / 2.0;
      map.mesh.V.push_back(
          {(x * std::cos(a) + y * std::cos(b)) / n, (x * std::sin(a) + y * std::sin(b)) / n, 0.0});
    }
    return found->second;
  };
  const auto add = [&](int sector, const std::array<std::array<int, 2>, 3>& g) {
    Triangle F{};
    std::array<Vector2<double>, 3> P{};
    for (std::size_t k = 0; k < 3; ++k) {
      F[k] = vertex(sector, g[k][0], g[k][1]);
      P[k] = {g[k][0] * cells / n, g[k][1] * cells / n};
    }
    map.mesh.F.push_back(F);
    map.parameters.push_back(P);
  };
  for (int sector = 0; sector < sectors; ++sector) {
    for (int x = 0; x < n; ++x) {
      for (int y = 0; y < n; ++y) {
        add(sector, {{{x, y}, {x + 1, y}, {x + 1, y + 1}}});
        add(sector, {{{x, y}, {x + 1, y + 1}, {x, y + 1}}});
      }
    }
  }
  return map;
}

// Moves the parameters of the vertices inside a plain square: folds once the amplitude is large; rounds them
// to multiples of `step`: flat triangles.
static void fold_square(QuadMap& map, double amplitude, double step, std::mt19937& random) {
  std::uniform_real_distribution<double> offset(-amplitude, amplitude);
  std::vector<Vector2<double>> shift(map.mesh.V.size(), {0.0, 0.0});
  for (std::size_t v = 0; v < shift.size(); ++v) {
    const Point3& p = map.mesh.V[v];
    if (std::min(p[0], p[1]) < 1e-9 || std::max(p[0], p[1]) > 1.0 - 1e-9) continue;
    shift[v] = {offset(random), offset(random)};
  }
  for (std::size_t f = 0; f < map.mesh.F.size(); ++f) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Vector2<double>& d = shift[static_cast<std::size_t>(map.mesh.F[f][i])];
      if (d[0] == 0.0 && d[1] == 0.0) continue;
      for (std::size_t k = 0; k < 2; ++k) {
        double& u = map.parameters[f][i][k];
        u = std::nearbyint((u + d[k]) / step) * step;
      }
    }
  }
}

static void rechart(QuadMap& map, std::mt19937& random, double noise = 0.0) {
  std::uniform_int_distribution<int> turns(0, 3);
  std::uniform_int_distribution<int> shift(-8, 8);
  std::uniform_real_distribution<double> error(-noise, noise);
  for (auto& corners : map.parameters) {
    const GridTransition2 chart{QuarterTurn(turns(random)), {shift(random), shift(random)}};
    for (Vector2<double>& u : corners) {
      u = chart(u, 1.0);
      for (double& x : u) x += error(random);
    }
  }
}

// The number of boundary edges, or -1 where an edge has three quads or two on one side.
static int boundary_edges(const Extraction<2>& mesh) {
  std::set<std::array<int, 2>> directed;
  for (const auto& quad : mesh.cells) {
    for (std::size_t k = 0; k < 4; ++k) {
      if (!directed.insert({quad[k], quad[(k + 1) % 4]}).second) return -1;
    }
  }
  return static_cast<int>(std::count_if(directed.begin(), directed.end(),
                                        [&](const auto& e) { return directed.count({e[1], e[0]}) == 0; }));
}

static double quad_area(const Extraction<2>& mesh, const std::array<int, 4>& quad) {
  const Point3& a = mesh.V[static_cast<std::size_t>(quad[0])];
  const Point3& b = mesh.V[static_cast<std::size_t>(quad[1])];
  const Point3& c = mesh.V[static_cast<std::size_t>(quad[2])];
  const Point3& d = mesh.V[static_cast<std::size_t>(quad[3])];
  return ((c[0] - a[0]) * (d[1] - b[1]) - (c[1] - a[1]) * (d[0] - b[0])) / 2.0;
}

static void check_sectors(const QuadMap& map, int sectors, int cells, int threads = 1) {
  const Result result = extracted(map, threads);
  const auto& mesh = result.mesh;
  CHECK(mesh.lost.empty() && result.report.whole_volume);
  CHECK(mesh.cells.size() == static_cast<std::size_t>(sectors * cells * cells));
  const int vertices = sectors == 1 ? (cells + 1) * (cells + 1) : 1 + sectors * cells * (cells + 1);
  CHECK(mesh.V.size() == static_cast<std::size_t>(vertices));
  CHECK(boundary_edges(mesh) == (sectors == 1 ? 4 : 2 * sectors) * cells);
  const double area = sectors == 1 ? 1.0 : std::sin(2.0 * std::acos(-1.0) / sectors);
  for (const auto& quad : mesh.cells) CHECK_NEAR(quad_area(mesh, quad), area / (cells * cells), 1e-5);
}

static void test_squares_and_singular_vertices() {
  std::mt19937 random(1);
  for (const int sectors : {1, 3, 5, 6}) {
    for (const auto& [n, cells] : {std::pair(3, 1), {3, 2}, {3, 7}, {4, 4}, {4, 8}, {4, 2}}) {
      QuadMap map = sector_map(sectors, n, cells);
      check_sectors(map, sectors, cells);
      rechart(map, random, 1e-7);
      check_sectors(map, sectors, cells, 2);
    }
  }
}

static void test_folds_and_flat_triangles() {
  std::mt19937 random(2);
  int folded = 0;
  for (int round = 0; round < 20; ++round) {
    QuadMap map = sector_map(1, 8, 12);
    fold_square(map, round % 2 == 0 ? 1.2 : 0.9, round % 2 == 0 ? std::ldexp(1.0, -20) : 0.5, random);
    rechart(map, random);
    const Result result = extracted(map);
    CHECK(result.report.flipped > 0);
    CHECK(result.mesh.cells.size() == 144 && result.mesh.V.size() == 169);
    CHECK(boundary_edges(result.mesh) == 48);
    folded += result.mesh.folded_cells;
  }
  CHECK(folded > 10);
}

// A square whose sides lie between isolines: only the complete quads, and the rest counted.
static void test_open_boundary() {
  const Result result = extracted(sector_map(1, 5, 4.75));
  CHECK(result.report.unaligned_boundary_facets == 10);
  CHECK(result.mesh.cells.size() == 16 && result.mesh.V.size() == 25);
  CHECK(result.mesh.lost.size() == 9);
  CHECK(std::all_of(result.mesh.lost.begin(), result.mesh.lost.end(),
                    [](const auto& lost) { return lost.loss == CellLoss::leaves_mesh; }));
}

static void test_mirrored_map() {
  QuadMap map = sector_map(3, 3, 4);
  for (auto& corners : map.parameters) {
    for (Vector2<double>& u : corners) u[1] = -u[1];
  }
  CHECK(extracted(map).mirrored);
  check_sectors(map, 3, 4);
}

static void test_locations() {
  const QuadMap map = sector_map(3, 3, 5);
  const Extraction<2> mesh = extracted(map).mesh;
  for (std::size_t v = 0; v < mesh.V.size(); ++v) {
    const Location<2>& at = mesh.locations[v];
    Point3 p{0, 0, 0};
    for (std::size_t i = 0; i < 3; ++i) {
      CHECK(at.weights[i] >= 0.0);
      const int corner = map.mesh.F[static_cast<std::size_t>(at.simplex)][i];
      for (std::size_t k = 0; k < 3; ++k)
        p[k] += at.weights[i] * map.mesh.V[static_cast<std::size_t>(corner)][k];
    }
    CHECK(p == mesh.V[v]);
  }
}

static void test_given_transitions() {
  QuadMap map = sector_map(1, 2, 2);
  for (Vector2<double>& u : map.parameters[1]) u = {-u[1] + 3.0, u[0]};  // a quarter turn and a shift
  map.transitions = {{0, 1, {QuarterTurn(1), {3, 0}}}};
  CHECK(extracted(map).mesh.cells.size() == 4);
  map.transitions = {{0, 1, {QuarterTurn(2), {3, 0}}}};
  CHECK_THROWS(extracted(map), InputError, "transition 0 1: it leaves the parameters");
  map.transitions = {{0, 7, {}}};
  CHECK_THROWS(extracted(map), InputError, "share no edge");
  map.transitions = {{0, 8, {}}};
  CHECK_THROWS(extracted(map), InputError, "the mesh has 8 triangles");
}

static void test_refusals() {
  QuadMap map = sector_map(1, 2, 2);
  for (Vector2<double>& u : map.parameters[0]) u[0] += 0.3;
  CHECK_THROWS(extracted(map), InputError, "translation (-0.3, 0), allowed are integers");
  map = sector_map(1, 2, 2);
  for (Vector2<double>& u : map.parameters[0]) u[1] *= 1.5;
  CHECK_THROWS(extracted(map), InputError, "no rotation of the grid");
  map = sector_map(1, 2, 1e8);
  CHECK_THROWS(extracted(map), InputError, "allowed are parameters below 2^24");
  CHECK_THROWS(extracted(sector_map(1, 16, 1.6e7)), StageError, "columns of cells, allowed are");
}

// One cell whose centre is a vertex with very many triangles.
static void test_centre_on_a_large_star() {
  constexpr int side = 100;
  QuadMap map;
  map.mesh.V.push_back({0.5, 0.5, 0.0});
  for (int i = 0; i < 4 * side; ++i) {
    const double along = static_cast<double>(i % side) / side;
    const std::array<Vector2<double>, 4> places{
        {{along, 0.0}, {1.0, along}, {1.0 - along, 1.0}, {0.0, 1.0 - along}}};
    const Vector2<double>& u = places[static_cast<std::size_t>(i / side)];
    map.mesh.V.push_back({u[0], u[1], 0.0});
  }
  for (int i = 0; i < 4 * side; ++i) {
    map.mesh.F.push_back({0, 1 + i, 1 + (i + 1) % (4 * side)});
    std::array<Vector2<double>, 3>& corners = map.parameters.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      const Point3& p = map.mesh.V[static_cast<std::size_t>(map.mesh.F.back()[k])];
      corners[k] = {p[0], p[1]};
    }
  }
  const Result result = extracted(map);
  CHECK(result.mesh.cells.size() == 1 && result.mesh.lost.empty());
}

// Thin triangles round long columns of integer points: billions of points, and not one cell.
static void test_points_without_cells() {
  QuadMap map;
  const double height = 1 << 23;
  for (int i = 0; i < 80; ++i) {
    map.mesh.F.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    for (const Point3& p : {Point3{-0.4, 0, 0}, Point3{0.4, 0, 0}, Point3{0, 1, 0}}) map.mesh.V.push_back(p);
    map.parameters.push_back({{{-0.4, 0.0}, {0.4, 0.0}, {0.0, height}}});
  }
  CHECK_THROWS(extracted(map), StageError, "grid points");
}

static void test_threads_do_not_matter() {
  std::mt19937 random(3);
  QuadMap map = sector_map(1, 30, 40);
  fold_square(map, 1.2, std::ldexp(1.0, -20), random);
  const Result one = extracted(map, 1);
  CHECK(one.report.flipped > 0);
  for (const int threads : {2, 4, 7}) {
    const Result many = extracted(map, threads);
    CHECK(many.mesh.V == one.mesh.V && many.mesh.cells == one.mesh.cells);
  }
}

int main() {
  test_squares_and_singular_vertices();
  test_folds_and_flat_triangles();
  test_open_boundary();
  test_mirrored_map();
  test_locations();
  test_given_transitions();
  test_refusals();
  test_centre_on_a_large_star();
  test_points_without_cells();
  test_threads_do_not_matter();
  return test_result();
}
