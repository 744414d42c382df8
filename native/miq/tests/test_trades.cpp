// The energy of fields by their matchings, and the trade of quarter turns that it decides.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/testing.hpp"
#include "miq/field_energy.hpp"
#include "miq/field_topology.hpp"
#include "miq/map_problem.hpp"
#include "surfaces.hpp"

namespace neurframe {
namespace {

constexpr double kPi = std::numbers::pi;

CrossSurface matched(const test::CrossedMesh& input) {
  Json statistics;
  CrossSurface surface = build_cross_surface(input.mesh, input.crosses, {}, statistics);
  surface.feature.assign(static_cast<size_t>(surface.half_edge_count()), 0);
  compute_matchings(surface);
  return surface;
}

// without singularities, long way round 6.3
CrossSurface torus() {
  const auto position = [](double s, double t) {
    const double r = 1 + 0.4 * std::cos(2 * kPi * t);
    return Point3{r * std::cos(2 * kPi * s), r * std::sin(2 * kPi * s), 0.4 * std::sin(2 * kPi * t)};
  };
  return matched(
      test::with_crosses(test::parametric_grid(40, 16, true, true, position),
                         [](const auto& p, const auto&) { return Eigen::Vector3d(-p[1], p[0], 0); }));
}

int singular_count(const std::vector<Sector>& sectors) {
  return static_cast<int>(std::count_if(sectors.begin(), sectors.end(),
                                        [](const Sector& sector) { return sector.quarter_turns != 4; }));
}

ShiftPath path_of_length(FieldTopology& topology, double length) {
  return topology.nearest(topology.sectors().front(), 2 * length,
                          [&](const Sector&, double distance) { return distance >= length; });
}

// by relaxing all crosses
double least_energy(CrossSurface surface) {
  std::vector<int> all(surface.positions.size());
  for (size_t v = 0; v < all.size(); ++v) all[v] = static_cast<int>(v);
  relax_field(surface, all, 100);
  double total = 0;
  for (int h = 0; h < surface.half_edge_count(); ++h) {
    if (surface.twin(h) < h) continue;
    const double residual = rotation_residual(surface, h);
    total += dual_weight(surface, h) * residual * residual;
  }
  return total;
}

void test_change_is_the_difference_of_least_energies() {
  CrossSurface surface = torus();
  std::vector<Sector> sectors = measure_sectors(surface);
  FieldTopology topology(surface, sectors);
  const ShiftPath path = path_of_length(topology, 0.8);
  FieldEnergy energy(surface);
  const double own = energy.own_energy(path);
  const double change = energy.change(path, 1, own);
  const double before = least_energy(surface);
  CHECK(change > 0.1);
  topology.move_turn(path, sectors.front());
  // both systems hold the common turn by 1e-9 on the diagonal
  CHECK_NEAR(change, least_energy(surface) - before, 1e-6);
  energy.shift(path, 1);
  CHECK_NEAR(energy.change(path, -1, own), -change, 1e-9);
}

// opposite singularities `length` apart; returns how many are left after trading
int left_of_a_pair(double length, double reach) {
  CrossSurface surface = torus();
  std::vector<Sector> sectors = measure_sectors(surface);
  FieldTopology topology(surface, sectors);
  topology.move_turn(path_of_length(topology, length), sectors.front());
  relax_field(surface, topology.shifted(), 100);
  CHECK(singular_count(measure_sectors(surface)) == 2);
  const int traded = trade_singularities(surface, sectors, {reach, 0});
  const int left = singular_count(measure_sectors(surface));
  CHECK(traded == (left == 0 ? 1 : 0));
  return left;
}

void test_a_pair_within_reach_goes() {
  CHECK(left_of_a_pair(0.8, 1.2) == 0);
  CHECK(left_of_a_pair(0.8, 0.4) == 2);
}

// eight corners have nothing to trade with, however much their number costs
void test_curvature_keeps_what_it_needs() {
  TriangleMesh mesh = test::cube(8);
  for (Point3& p : mesh.V) {
    const Eigen::Vector3d q = (test::vector(p) - Eigen::Vector3d::Constant(0.5)).normalized();
    p = {q[0], q[1], q[2]};
  }
  CrossSurface surface = matched(test::with_crosses(std::move(mesh), test::cube_direction));
  std::vector<Sector> sectors = measure_sectors(surface);
  CHECK(singular_count(sectors) == 8);
  CHECK(trade_singularities(surface, sectors, {10, 100}) == 0);
  CHECK(singular_count(measure_sectors(surface)) == 8);
}

}  // namespace
}  // namespace neurframe

int main() {
  neurframe::test_change_is_the_difference_of_least_energies();
  neurframe::test_a_pair_within_reach_goes();
  neurframe::test_curvature_keeps_what_it_needs();
  return neurframe::test_result();
}
