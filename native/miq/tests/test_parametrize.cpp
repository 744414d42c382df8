// The whole program on surfaces whose integer-grid maps are known.
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <string>

#include "core/testing.hpp"
#include "miq/parametrize.hpp"
#include "surfaces.hpp"

namespace neurframe {
namespace {

using test::CrossedMesh;

constexpr double kPi = std::numbers::pi;

Parametrization run(const CrossedMesh& input, double edge_length, std::string* statistics = nullptr,
                    int faces = 0) {
  ParametrizeOptions options;
  options.edge_length = edge_length;
  options.integer_grid.target_faces = faces;
  Json json;
  Parametrization result = parametrize(input.mesh, input.crosses, {}, options, json);
  if (statistics) *statistics = json.dump();
  return result;
}

CrossedMesh patch() {
  return test::with_crosses(
      test::parametric_grid(5, 5, false, false, [](double s, double t) { return Point3{s, t, 0}; }),
      [](const auto&, const auto&) { return Eigen::Vector3d(1, 0, 0); });
}

CrossedMesh cube() {
  return test::with_crosses(test::cube(4), test::cube_direction);
}

CrossedMesh cylinder() {
  const auto position = [](double s, double t) {
    return Point3{std::cos(2 * kPi * s), std::sin(2 * kPi * s), 2 * t};
  };
  return test::with_crosses(test::parametric_grid(24, 8, true, false, position),
                            [](const auto&, const auto&) { return Eigen::Vector3d(0, 0, 1); });
}

CrossedMesh torus() {
  const auto position = [](double s, double t) {
    const double r = 1 + 0.4 * std::cos(2 * kPi * t);
    return Point3{r * std::cos(2 * kPi * s), r * std::sin(2 * kPi * s), 0.4 * std::sin(2 * kPi * t)};
  };
  return test::with_crosses(test::parametric_grid(40, 16, true, true, position),
                            [](const auto& p, const auto&) { return Eigen::Vector3d(-p[1], p[0], 0); });
}

CrossedMesh sphere() {
  TriangleMesh mesh = test::cube(8);
  for (Point3& p : mesh.V) {
    const Eigen::Vector3d q = (test::vector(p) - Eigen::Vector3d::Constant(0.5)).normalized();
    p = {q[0], q[1], q[2]};
  }
  return test::with_crosses(std::move(mesh), test::cube_direction);
}

// every transition line holds exactly on both ends of its edge, and every other edge has none
void check_seams(const QuadMap& map) {
  const std::vector<int> twin = half_edge_twins(map.mesh.F, map.mesh.V.size());
  const auto at = [&](int c) {
    return map.parameters[static_cast<size_t>(c / 3)][static_cast<size_t>(c % 3)];
  };
  std::map<std::pair<int, int>, GridTransition2> given;
  for (const GivenTransition2& line : map.transitions) {
    given[{line.f, line.g}] = line.transition;
    given[{line.g, line.f}] = line.transition.inverse();
  }
  int wrong = 0;
  for (int h = 0; h < static_cast<int>(twin.size()); ++h) {
    const int o = twin[static_cast<size_t>(h)];
    if (o < 0) continue;
    const GridTransition2 transition = given[{h / 3, o / 3}];
    wrong += transition(at(h), 1.0) != at(next_corner(o));
    wrong += transition(at(next_corner(h)), 1.0) != at(o);
  }
  CHECK(wrong == 0);
}

void check_valid(const Parametrization& result) {
  CHECK(result.check.folded.empty());
  CHECK(result.check.overwound.empty());
  CHECK(result.complete);
  CHECK(result.source.size() == result.map.mesh.F.size());
  check_seams(result.map);
}

void test_flat_patch_has_exact_cells() {
  const Parametrization result = run(patch(), 1.0 / 8);
  check_valid(result);
  CHECK_NEAR(result.check.cells, 64.0, 1e-9);
}

void test_cube_has_exact_cells() {
  std::string statistics;
  const Parametrization result = run(cube(), 1.0 / 8, &statistics);
  check_valid(result);
  CHECK_NEAR(result.check.cells, 6 * 64.0, 1e-9);
  CHECK(statistics.find("\"feature_sectors\": 24") != std::string::npos);
}

void test_cylinder_closes_with_whole_cells() {
  const Parametrization result = run(cylinder(), 0.25);
  check_valid(result);
  CHECK_NEAR(result.check.cells, 8.0 * 25, 1e-6);
}

void test_torus_has_no_singularity() {
  std::string statistics;
  const Parametrization result = run(torus(), 0.1, &statistics);
  check_valid(result);
  CHECK(statistics.find("\"singularities\": {\"feature_sectors\": 0}") != std::string::npos);
  CHECK_NEAR(result.check.cells, std::round(result.check.cells), 1e-9);
}

void test_sphere_has_eight_singularities() {
  std::string statistics;
  const Parametrization result = run(sphere(), 0.15, &statistics);
  check_valid(result);
  CHECK(statistics.find("\"3\": 8") != std::string::npos);
}

void test_components_do_not_mix() {
  const CrossedMesh far = test::moved(cube(), Eigen::Matrix3d::Identity(), {3, 0, 0});
  const Parametrization result = run(test::joined(cube(), far), 1.0 / 8);
  check_valid(result);
  CHECK_NEAR(result.check.cells, 2 * 6 * 64.0, 1e-9);
}

// no symmetry, so that no rounding is a tie
CrossedMesh ellipsoid() {
  CrossedMesh mesh = sphere();
  for (Point3& p : mesh.mesh.V) p = {p[0], 0.83 * p[1], 0.61 * p[2]};
  return test::with_crosses(mesh.mesh, test::cube_direction);
}

void test_rotation_changes_nothing() {
  const Eigen::Matrix3d rotation = Eigen::Quaterniond(0.3, -0.5, 0.7, 0.41).normalized().toRotationMatrix();
  const Parametrization at_rest = run(ellipsoid(), 0.13);
  const Parametrization turned = run(test::moved(ellipsoid(), rotation, {5, -2, 1}), 0.13);
  CHECK_NEAR(at_rest.check.cells, turned.check.cells, 1e-9);
  double largest = 0;
  for (size_t f = 0; f < at_rest.map.parameters.size(); ++f) {
    for (size_t i = 0; i < 3; ++i) {
      for (size_t k = 0; k < 2; ++k) {
        largest =
            std::max(largest, std::abs(at_rest.map.parameters[f][i][k] - turned.map.parameters[f][i][k]));
      }
    }
  }
  CHECK(largest < 1e-5);
}

void test_target_faces_are_reached() {
  const Parametrization result = run(sphere(), 0, nullptr, 500);
  check_valid(result);
  CHECK_NEAR(result.check.cells, 500.0, 25.0);
}

// A singularity beside each tip left no room for the cells between the two features there.
void test_sharp_tips_have_room() {
  const Parametrization result =
      run(test::with_crosses(test::right_tetrahedron(12), test::cube_direction), 0.08);
  check_valid(result);
}

// far coarser than the shape: as many cells as it takes
void test_coarse_scale_ends_in_a_mesh() {
  const Parametrization result = run(sphere(), 3.0);
  check_valid(result);
  CHECK(result.check.cells >= 6);
}

void test_bad_input_is_refused() {
  CrossedMesh bad = patch();
  bad.crosses[3] = {0, 0, 1, 0, 0, 1};
  CHECK_THROWS(run(bad, 0.1), InputError, "triangle 3 is not tangent");
  CrossedMesh flat = patch();
  flat.mesh.V[1] = flat.mesh.V[0];
  CHECK_THROWS(run(flat, 0.1), InputError, "has no area");
  CHECK_THROWS(run(patch(), 1e-300), StageError, "choose a longer one");
}

}  // namespace
}  // namespace neurframe

int main() {
  neurframe::test_flat_patch_has_exact_cells();
  neurframe::test_cube_has_exact_cells();
  neurframe::test_cylinder_closes_with_whole_cells();
  neurframe::test_torus_has_no_singularity();
  neurframe::test_sphere_has_eight_singularities();
  neurframe::test_components_do_not_mix();
  neurframe::test_rotation_changes_nothing();
  neurframe::test_target_faces_are_reached();
  neurframe::test_sharp_tips_have_room();
  neurframe::test_coarse_scale_ends_in_a_mesh();
  neurframe::test_bad_input_is_refused();
  return neurframe::test_result();
}
