#include "miq/integer_grid.hpp"

#include <algorithm>
#include <cmath>

#include "miq/carry_map.hpp"
#include "miq/stiffening.hpp"

namespace neurframe {
namespace {

double parametric_area(const MapProblem& problem, const MapSystem& system, const Eigen::VectorXd& real,
                       const Eigen::VectorXd& integer) {
  double area = 0;
  for (int f = 0; f < problem.surface.triangle_count(); ++f) {
    const Vector6 x = system.corner_parameters(f, real, integer);
    area += ((x[2] - x[0]) * (x[5] - x[1]) - (x[4] - x[0]) * (x[3] - x[1])) / 2;
  }
  return area;
}

class IntegerGridSolver {
 public:
  IntegerGridSolver(const MapProblem& problem, SeamlessMap& seamless, const IntegerGridOptions& options)
      : problem_(problem),
        seamless_(seamless),
        options_(options),
        held_system_(problem.variables, problem.surface.triangle_count(), false) {
    MapSystem free_system(problem.variables, problem.surface.triangle_count(), true);
    poisson_ = poisson_system(problem.variables, free_system, seamless.shapes, seamless.stiffness);
  }

  // true if the triangulation of the critical vertices can follow the integers
  bool choose_integers(IntegerGrid& grid, Json& statistics);
  // repeats that at corrected edge lengths until there are as many cells as asked for
  bool choose_for_target(IntegerGrid& grid, Json& statistics);
  void solve_map(IntegerGrid& grid, Json& statistics);
  void rescale(IntegerGrid& grid, double factor) {
    seamless_.rescale(factor);
    grid.edge_length_factor *= factor;
  }

 private:
  void check(IntegerGrid& grid) const {
    grid.fixed = fixed_point_map(problem_.variables, grid.real, grid.integer);
    grid.check = check_map(problem_.surface, problem_.sectors, grid.fixed);
  }
  UntangleResult untangle_and_check(IntegerGrid& grid);
  void carry_and_check(IntegerGrid& grid, Json& statistics);

  // the real variables after the least deformation that takes the integers to whole numbers
  Eigen::VectorXd moved_to(const Eigen::VectorXd& whole) const {
    return seamless_.real + poisson_.real_response(whole - seamless_.integer);
  }

  const MapProblem& problem_;
  SeamlessMap& seamless_;
  const IntegerGridOptions& options_;
  MapSystem held_system_;
  PoissonSystem poisson_;  // in cells: the same at every edge length
};

bool IntegerGridSolver::choose_integers(IntegerGrid& grid, Json& statistics) {
  const CriticalTriangulation triangulation(problem_, seamless_.real, seamless_.integer);
  SeparationRows rows = triangulation.near_rows(options_.separation_reach);
  statistics["near_rows"] = rows.size();
  int collapsed = 0;
  int round = 0;
  bool fresh = true;
  for (; fresh && round < options_.most_row_rounds; ++round) {
    const Quantization found =
        quantize(poisson_.schur, seamless_.integer, std::vector<SeparationRow>(rows.begin(), rows.end()));
    grid.integer = found.values;
    grid.real = moved_to(grid.integer);
    statistics["violated_rows"] = found.violated_rows;
    statistics["energy"] = found.energy;
    statistics["local_moves"] = found.local_moves;
    SeparationRows broken = triangulation.broken_rows(grid.real, grid.integer, collapsed);
    const size_t before = rows.size();
    rows.merge(broken);
    fresh = rows.size() > before;
    if (collapsed == 0) break;
  }
  statistics["separation_rows"] = rows.size();
  statistics["row_rounds"] = round + 1;
  statistics["collapsed"] = collapsed;
  statistics["vertices_left"] = triangulation.vertices_left();
  return collapsed == 0;
}

bool IntegerGridSolver::choose_for_target(IntegerGrid& grid, Json& statistics) {
  constexpr int kMostRounds = 8;
  constexpr double kTolerance = 0.02;
  for (int round = 1;; ++round) {
    const bool found = choose_integers(grid, statistics);
    if (options_.target_faces <= 0 || round == kMostRounds) return found;
    const double cells = parametric_area(problem_, held_system_, grid.real, grid.integer);
    const double ratio = cells / options_.target_faces;
    statistics["rounds"] = round;
    if (!(ratio > 0) || std::abs(ratio - 1) < kTolerance) return found;
    rescale(grid, std::sqrt(ratio));
  }
}

UntangleResult IntegerGridSolver::untangle_and_check(IntegerGrid& grid) {
  UntangleOptions options;
  options.threads = options_.threads;
  const UntangleResult result = untangle(held_system_, seamless_.shapes, options, grid.real, grid.integer);
  check(grid);
  return result;
}

// What the jump to the integers has wound twice has no fold to be untangled by; the seamless map is not wound
// so, and is taken there step by step.
void IntegerGridSolver::carry_and_check(IntegerGrid& grid, Json& statistics) {
  UntangleOptions options;
  options.threads = options_.threads;
  IntegerGrid carried = grid;
  carried.real = seamless_.real;
  carried.integer = seamless_.integer;
  const bool arrived = seamless_.check.valid() && carry_map(held_system_, seamless_.shapes, poisson_, options,
                                                            grid.integer, carried.real, carried.integer);
  statistics["arrived"] = arrived;
  if (!arrived) return;
  check(carried);
  if (carried.check.defects() < grid.check.defects()) grid = std::move(carried);
}

void IntegerGridSolver::solve_map(IntegerGrid& grid, Json& statistics) {
  constexpr int kStiffeningRounds = 10;
  statistics = untangle_json(untangle_and_check(grid));
  if (!grid.check.valid()) carry_and_check(grid, statistics["carried"]);
  if (!grid.check.valid()) {
    IntegerGrid again = grid;
    std::vector<double> stiffness = seamless_.stiffness;
    solve_with_stiffening(held_system_, problem_, seamless_.shapes, kStiffeningRounds, stiffness, again.real,
                          again.integer);
    statistics["stiffened"] = untangle_json(untangle_and_check(again));
    if (again.check.defects() < grid.check.defects()) grid = std::move(again);
  }
  grid.lost = {};
  if (!grid.check.valid()) return;
  grid.lost =
      lost_quads(quad_map(problem_.surface, problem_.variables, problem_.graph, grid.fixed, grid.integer),
                 options_.threads);
}

}  // namespace

IntegerGrid solve_integer_grid(const MapProblem& problem, SeamlessMap& seamless,
                               const IntegerGridOptions& options, Json& statistics) {
  IntegerGridSolver solver(problem, seamless, options);
  IntegerGrid grid;
  Json& quantization = statistics["quantization"];
  bool found = solver.choose_for_target(grid, quantization);
  std::vector<Json> reasons;
  double step = options.first_refinement;
  const auto refine = [&](const char* reason) {
    reasons.emplace_back(reason);
    solver.rescale(grid, step);
    step = std::max(options.refinement, 2 * step - 1);
    return solver.choose_integers(grid, quantization);
  };
  // a map that is not valid to begin with does not become so
  const size_t most = seamless.check.valid() ? static_cast<size_t>(options.most_refinements) : 0;
  while (!found && reasons.size() < most) found = refine("no integers");
  solver.solve_map(grid, statistics["integer_grid"]);
  while (!grid.complete() && reasons.size() < most) {
    refine(grid.check.valid() ? "lost quads" : "folded");
    solver.solve_map(grid, statistics["integer_grid"]);
  }
  quantization["refined_because"] = reasons;
  quantization["edge_length_factor"] = grid.edge_length_factor;
  return grid;
}

}  // namespace neurframe
