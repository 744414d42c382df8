#include "miq/parametrize.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <map>

#include "core/program.hpp"
#include "miq/integer_grid.hpp"
#include "miq/map_problem.hpp"
#include "miq/map_system.hpp"
#include "miq/stiffening.hpp"

namespace neurframe {
namespace {

// CPU seconds of each step, in the statistics under "seconds".
class StepClock {
 public:
  explicit StepClock(Json& statistics) : statistics_(statistics) {}
  void finish(const char* step, double fraction) {
    const std::clock_t now = std::clock();
    statistics_["seconds"][step] = static_cast<double>(now - start_) / CLOCKS_PER_SEC;
    start_ = now;
    report_progress(fraction, step);
  }

 private:
  Json& statistics_;
  std::clock_t start_ = std::clock();
};

std::vector<SingularPoint> singular_points(const MapProblem& problem) {
  std::vector<SingularPoint> points;
  for (const Sector& sector : problem.sectors) {
    if (sector.quarter_turns == (sector.closed ? 4 : 2)) continue;
    const Eigen::Vector3d& p = problem.surface.at(sector.vertex);
    points.push_back({{p[0], p[1], p[2]}, sector.quarter_turns, !sector.closed});
  }
  return points;
}

// Positions of the first of these triangles or vertices, as lists of three numbers.
Json places(const CrossSurface& surface, const std::vector<int>& items, bool triangles) {
  constexpr size_t kMost = 50;
  std::vector<std::vector<double>> list;
  for (size_t i = 0; i < items.size() && i < kMost; ++i) {
    Eigen::Vector3d p = triangles ? Eigen::Vector3d::Zero() : Eigen::Vector3d(surface.at(items[i]));
    for (int k = 0; triangles && k < 3; ++k) p += surface.at(surface.from(3 * items[i] + k)) / 3;
    list.push_back({p[0], p[1], p[2]});
  }
  return list;
}

bool has_features(const CrossSurface& surface) {
  return std::any_of(surface.feature.begin(), surface.feature.end(), [](char on) { return on != 0; });
}

// A problem whose seamless map is valid, or the one with the fewest defects.
struct Attempt {
  MapProblem problem;
  SeamlessMap seamless;
};

// What the next attempt does differently: first only the shorter trades, then none (the long ones leave the
// koala no map, half as long ones leave it 30 irregular vertices fewer than none); then singularities are
// moved farther from the features, because no map that follows the crosses has one in the tip between two;
// then the feature lines beside the defects are left out.  False if nothing is left to try.
bool change_preparation(const Attempt& best, double edge_length, int attempt,
                        PreparationOptions& preparation) {
  constexpr double kFarther = 3;
  constexpr int kFarAttempts = 4;
  constexpr int kRings = 8;
  if (attempt <= 2) {
    preparation.trade_reach = attempt == 1 ? preparation.trade_reach / 2 : 0;
    return true;
  }
  if (!has_features(best.problem.surface)) return false;
  if (attempt <= kFarAttempts) {
    preparation.feature_clearance *= kFarther;
    return preparation.feature_clearance * edge_length <
           bounding_box_diagonal(best.problem.surface.positions);
  }
  const std::vector<Eigen::Vector3d> points = feature_points_near(
      best.problem.surface, defective_triangles(best.problem, best.seamless.check), kRings);
  std::vector<Eigen::Vector3d>& released = preparation.features.released_at;
  released.insert(released.end(), points.begin(), points.end());
  return !points.empty();
}

Attempt find_seamless_map(const CrossSurface& surface, const ParametrizeOptions& options, double edge_length,
                          Json& statistics) {
  constexpr int kMostAttempts = 8;
  Attempt best;
  PreparationOptions preparation = options.preparation;
  const Json before = statistics;
  for (int attempt = 1; attempt <= kMostAttempts; ++attempt) {
    Json trial = before;
    trial["attempts"] = attempt;
    trial["feature_clearance"] = preparation.feature_clearance;
    trial["trade_reach"] = preparation.trade_reach;
    Attempt now;
    now.problem = prepare_map_problem(surface, preparation, edge_length, trial);
    MapSystem system(now.problem.variables, now.problem.surface.triangle_count(), true);
    now.seamless = solve_seamless_map(now.problem, system, edge_length, options.seamless, trial["seamless"]);
    if (attempt == 1 || now.seamless.check.defects() < best.seamless.check.defects()) {
      best = std::move(now);
      statistics = trial;
    }
    if (best.seamless.check.valid()) break;
    if (!change_preparation(best, edge_length, attempt, preparation)) break;
  }
  return best;
}

void report_check(const CrossSurface& surface, const IntegerGrid& grid, Json& statistics) {
  statistics["fraction_bits"] = grid.fixed.fraction_bits;
  statistics["folded_triangles"] = grid.check.folded.size();
  statistics["overwound_vertices"] = grid.check.overwound.size();
  statistics["lost_quads"] = grid.lost.count;
  statistics["cells"] = grid.check.cells;
  statistics["folded_at"] = places(surface, grid.check.folded, true);
  statistics["overwound_at"] = places(surface, grid.check.overwound, false);
  std::vector<std::vector<double>> lost_at;
  for (const Point3& p : grid.lost.places) lost_at.push_back({p[0], p[1], p[2]});
  statistics["lost_at"] = lost_at;
  statistics["valid"] = grid.complete();
}

}  // namespace

Parametrization parametrize(const TriangleMesh& mesh, const std::vector<std::array<double, 6>>& crosses,
                            const std::vector<double>& sizing, const ParametrizeOptions& options,
                            Json& statistics) {
  StepClock clock(statistics);
  const CrossSurface surface = build_cross_surface(mesh, crosses, sizing, statistics);
  double edge_length = options.edge_length;
  if (options.integer_grid.target_faces > 0) {
    edge_length = std::sqrt(total_area(surface) / options.integer_grid.target_faces);
  }
  Attempt attempt = find_seamless_map(surface, options, edge_length, statistics);
  const MapProblem& problem = attempt.problem;
  clock.finish("seamless", 0.5);
  const IntegerGrid grid = solve_integer_grid(problem, attempt.seamless, options.integer_grid, statistics);
  statistics["edge_length"] = edge_length * grid.edge_length_factor;
  clock.finish("integer_grid", 1.0);
  report_check(problem.surface, grid, statistics);
  return {quad_map(problem.surface, problem.variables, problem.graph, grid.fixed, grid.integer),
          problem.surface.source, singular_points(problem), grid.check, grid.complete()};
}

}  // namespace neurframe
