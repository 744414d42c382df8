// The seamless map reduced to its critical vertices, and the rows that keep these apart; maps carried to
// integers.
#include <limits>

#include "core/testing.hpp"
#include "miq/carry_map.hpp"
#include "miq/critical_triangulation.hpp"
#include "miq/seamless_map.hpp"
#include "surfaces.hpp"

namespace neurframe {
namespace {

struct Solved {
  MapProblem problem;
  SeamlessMap map;
};

Solved solve(const test::CrossedMesh& input, double edge_length) {
  Json statistics;
  Solved out;
  out.problem = prepare_map_problem(build_cross_surface(input.mesh, input.crosses, {}, statistics), {},
                                    edge_length, statistics);
  MapSystem system(out.problem.variables, out.problem.surface.triangle_count(), true);
  out.map = solve_seamless_map(out.problem, system, edge_length, {}, statistics);
  return out;
}

double value(const SeparationRow& row, const Eigen::VectorXd& integer) {
  double total = static_cast<double>(row.constant);
  for (const auto& [index, factor] : row.terms) total += static_cast<double>(factor) * integer[index];
  return total;
}

// a box of cells: its eight corners are all that is critical
void test_only_corners_stay() {
  const Solved cube = solve(test::with_crosses(test::cube(4), test::cube_direction), 1.0 / 8);
  CHECK(cube.map.check.valid());
  const CriticalTriangulation triangulation(cube.problem, cube.map.real, cube.map.integer);
  CHECK(triangulation.vertices_left() == 0);
  CHECK(triangulation.triangle_count() == 12);
  int collapsed = -1;
  CHECK(triangulation.broken_rows(cube.map.real, cube.map.integer, collapsed).empty());
  CHECK(collapsed == 0);
}

// all integers zero collapse everything; the rows that come back say so and hold in the seamless map
void test_collapse_is_found_and_prevented() {
  const Solved cube = solve(test::with_crosses(test::cube(4), test::cube_direction), 1.0 / 8);
  const CriticalTriangulation triangulation(cube.problem, cube.map.real, cube.map.integer);
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(cube.map.integer.size());
  int collapsed = 0;
  const SeparationRows rows = triangulation.broken_rows(cube.map.real, zero, collapsed);
  CHECK(collapsed > 0);
  CHECK(!rows.empty());
  for (const SeparationRow& row : rows) {
    CHECK(value(row, zero) < 1);
    CHECK(value(row, cube.map.integer) > 1);
  }
}

// edges of 8 cells are not near; at a scale where they have one cell every one of the three directions is
void test_near_rows_depend_on_scale() {
  const test::CrossedMesh cube = test::with_crosses(test::cube(4), test::cube_direction);
  const Solved fine = solve(cube, 1.0 / 8);
  CHECK(CriticalTriangulation(fine.problem, fine.map.real, fine.map.integer).near_rows(1.5).empty());
  const Solved coarse = solve(cube, 1.0);
  CHECK(CriticalTriangulation(coarse.problem, coarse.map.real, coarse.map.integer).near_rows(1.5).size() >=
        3);
}

double least_area(const Solved& solved, const MapSystem& system, const Eigen::VectorXd& real,
                  const Eigen::VectorXd& integer) {
  double least = std::numeric_limits<double>::infinity();
  for (int f = 0; f < solved.problem.surface.triangle_count(); ++f) {
    const Vector6 x = system.corner_parameters(f, real, integer);
    least = std::min(least, (x[2] - x[0]) * (x[5] - x[1]) - (x[4] - x[0]) * (x[3] - x[1]));
  }
  return least;
}

// A cube of 8 cells an edge becomes a box of whole cells, but not one that is flat: there it stops before a
// triangle has no area left.
void test_a_map_is_carried_to_integers_that_leave_it_room() {
  const Solved cube = solve(test::with_crosses(test::cube(4), test::cube_direction), 1.0 / 8);
  const int triangles = cube.problem.surface.triangle_count();
  MapSystem held(cube.problem.variables, triangles, false);
  MapSystem free(cube.problem.variables, triangles, true);
  const PoissonSystem poisson =
      poisson_system(cube.problem.variables, free, cube.map.shapes, cube.map.stiffness);
  for (const double share : {3.0, 0.125, 0.0}) {
    const Eigen::VectorXd goal = (share * cube.map.integer).array().round();
    Eigen::VectorXd real = cube.map.real, integer = cube.map.integer;
    const bool arrived = carry_map(held, cube.map.shapes, poisson, {}, goal, real, integer);
    CHECK(arrived == (share > 0));
    CHECK((integer == goal) == arrived);
    CHECK(least_area(cube, held, real, integer) > 0);
  }
}

}  // namespace
}  // namespace neurframe

int main() {
  neurframe::test_only_corners_stay();
  neurframe::test_collapse_is_found_and_prevented();
  neurframe::test_near_rows_depend_on_scale();
  neurframe::test_a_map_is_carried_to_integers_that_leave_it_room();
  return neurframe::test_result();
}
