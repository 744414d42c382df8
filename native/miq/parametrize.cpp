#include "miq/parametrize.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <map>

#include "core/program.hpp"
#include "miq/map_problem.hpp"
#include "miq/map_system.hpp"
#include "miq/quantization.hpp"
#include "miq/separation.hpp"
#include "miq/stiffening.hpp"
#include "miq/untangle.hpp"

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

Json untangle_json(const UntangleResult& result) {
  Json json;
  json["iterations"] = result.iterations;
  json["folds_before"] = result.folds_before;
  json["folds_after"] = result.folds_after;
  return json;
}

double parametric_area(const MapProblem& problem, const MapSystem& system, const Eigen::VectorXd& real,
                       const Eigen::VectorXd& integer) {
  double area = 0;
  for (int f = 0; f < problem.surface.triangle_count(); ++f) {
    const Vector6 x = system.corner_parameters(f, real, integer);
    area += ((x[2] - x[0]) * (x[5] - x[1]) - (x[4] - x[0]) * (x[3] - x[1])) / 2;
  }
  return area;
}

// The real-valued seamless map, and what quantisation needs of it; all of it scales with the edge length.
struct Seamless {
  TriangleShapes shapes;
  PoissonSystem poisson;
  std::vector<double> stiffness;
  Eigen::VectorXd real, integer;

  // the real variables after the least deformation that takes the integers to whole numbers
  Eigen::VectorXd moved_to(const Eigen::VectorXd& whole) const {
    return real + poisson.real_response(whole - integer);
  }

  // to edge length times factor
  void rescale(double factor) {
    for (Matrix46& jacobian : shapes.jacobian) jacobian *= factor;
    for (double& weight : shapes.weight) weight /= factor * factor;
    real /= factor;
    integer /= factor;
  }
};

Quantization quantize_at_scale(const MapProblem& problem, const MapSystem& system, const Seamless& seamless,
                               const ParametrizeOptions& options, Json& statistics) {
  const std::vector<SeparationRow> rows =
      separation_rows(problem.surface, problem.variables, problem.singular, system, seamless.real,
                      seamless.integer, options.separation_reach);
  Quantization quantization = quantize(seamless.poisson.schur, seamless.integer, rows);
  statistics["quantization"]["separation_rows"] = rows.size();
  statistics["quantization"]["violated_rows"] = quantization.violated_rows;
  statistics["quantization"]["energy"] = quantization.energy;
  statistics["quantization"]["local_moves"] = quantization.local_moves;
  return quantization;
}

// Repeats the quantisation at corrected edge lengths until the parametric area is within 2 % of the target.
Quantization quantize_to_target(const MapProblem& problem, const MapSystem& system, Seamless& seamless,
                                const ParametrizeOptions& options, Json& statistics) {
  constexpr int kMostRounds = 8;
  for (int round = 1;; ++round) {
    Quantization quantization = quantize_at_scale(problem, system, seamless, options, statistics);
    if (options.target_faces <= 0 || round == kMostRounds) return quantization;
    const Eigen::VectorXd real = seamless.moved_to(quantization.values);
    const double ratio = parametric_area(problem, system, real, quantization.values) / options.target_faces;
    statistics["quantization"]["rounds"] = round;
    if (!(ratio > 0) || std::abs(ratio - 1) < 0.02) return quantization;
    seamless.rescale(std::sqrt(ratio));
  }
}

}  // namespace

Parametrization parametrize(const TriangleMesh& mesh, const std::vector<std::array<double, 6>>& crosses,
                            const std::vector<double>& sizing, const ParametrizeOptions& options,
                            Json& statistics) {
  StepClock clock(statistics);
  CrossSurface surface = build_cross_surface(mesh, crosses, sizing, statistics);
  double edge_length = options.edge_length;
  if (options.target_faces > 0) edge_length = std::sqrt(total_area(surface) / options.target_faces);
  const MapProblem problem =
      prepare_map_problem(std::move(surface), options.preparation, edge_length, statistics);
  clock.finish("preparation", 0.2);

  const int count = problem.surface.triangle_count();
  MapSystem free_system(problem.variables, count, true);
  Seamless seamless;
  seamless.shapes = triangle_shapes(problem.surface, edge_length);
  seamless.stiffness.assign(problem.surface.triangles.size(), 1.0);
  seamless.real.setZero(problem.variables.real_count);
  seamless.integer.setZero(problem.variables.integer_count);
  const StiffeningResult stiffening =
      solve_with_stiffening(free_system, problem.surface, seamless.shapes, options.stiffening_rounds,
                            seamless.stiffness, seamless.real, seamless.integer);
  statistics["seamless"]["stiffening_rounds"] = stiffening.rounds;
  statistics["seamless"]["folds_poisson"] = stiffening.folds_before;
  statistics["seamless"]["folds_stiffened"] = stiffening.folds_after;
  clock.finish("poisson", 0.4);

  if (stiffening.folds_before > 0) {
    UntangleOptions untangle_options;
    untangle_options.polish = options.seamless_polish;
    statistics["seamless"]["untangling"] = untangle_json(
        untangle(free_system, seamless.shapes, untangle_options, seamless.real, seamless.integer));
  }
  clock.finish("seamless_untangling", 0.6);

  seamless.poisson = poisson_system(problem.variables, free_system, seamless.shapes, seamless.stiffness);
  const Quantization quantization = quantize_to_target(problem, free_system, seamless, options, statistics);
  clock.finish("quantization", 0.75);

  MapSystem system(problem.variables, count, false);
  Eigen::VectorXd integer = quantization.values;
  Eigen::VectorXd real = seamless.moved_to(integer);
  statistics["integer_grid"] =
      untangle_json(untangle(system, seamless.shapes, UntangleOptions{}, real, integer));
  clock.finish("untangling", 0.9);

  const FixedPointMap fixed = fixed_point_map(problem.variables, real, integer);
  Parametrization out{quad_map(problem.surface, problem.variables, problem.graph, fixed, integer),
                      problem.surface.source, singular_points(problem),
                      check_map(problem.surface, problem.sectors, fixed)};
  statistics["fraction_bits"] = fixed.fraction_bits;
  statistics["folded_triangles"] = out.check.folded.size();
  statistics["overwound_vertices"] = out.check.overwound.size();
  statistics["cells"] = out.check.cells;
  statistics["folded_at"] = places(problem.surface, out.check.folded, true);
  statistics["overwound_at"] = places(problem.surface, out.check.overwound, false);
  statistics["valid"] = out.check.valid();
  clock.finish("fixed_point", 1.0);
  return out;
}

}  // namespace neurframe
