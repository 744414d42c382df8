#include "miq/seamless_map.hpp"

#include "miq/stiffening.hpp"

namespace neurframe {
namespace {

// Folds are local: holding the integers keeps the systems sparse.  Only what stays folded then needs them
// free.
void untangle_seamless(const MapProblem& problem, MapSystem& free_system, int threads, SeamlessMap& map,
                       Json& statistics) {
  UntangleOptions options;
  options.threads = threads;
  options.most_iterations = 40;
  options.patience = 8;
  MapSystem held_system(problem.variables, problem.surface.triangle_count(), false);
  UntangleResult result = untangle(held_system, map.shapes, options, map.real, map.integer);
  statistics["held"] = untangle_json(result);
  if (result.folds_after == 0) return;
  statistics["free"] = untangle_json(untangle(free_system, map.shapes, options, map.real, map.integer));
}

}  // namespace

void SeamlessMap::rescale(double factor) {
  for (Matrix46& jacobian : shapes.jacobian) jacobian *= factor;
  for (double& weight : shapes.weight) weight /= factor * factor;
  real /= factor;
  integer /= factor;
}

Json untangle_json(const UntangleResult& result) {
  Json json;
  json["iterations"] = result.iterations;
  json["folds_before"] = result.folds_before;
  json["folds_after"] = result.folds_after;
  return json;
}

SeamlessMap solve_seamless_map(const MapProblem& problem, MapSystem& free_system, double edge_length,
                               const SeamlessOptions& options, Json& statistics) {
  SeamlessMap map;
  map.shapes = triangle_shapes(problem.surface, edge_length);
  map.stiffness.assign(problem.surface.triangles.size(), 1.0);
  map.real.setZero(problem.variables.real_count);
  map.integer.setZero(problem.variables.integer_count);
  for (int round = 1; round <= options.rounds; ++round) {
    const StiffeningResult stiffening = solve_with_stiffening(
        free_system, problem, map.shapes, options.stiffening_rounds, map.stiffness, map.real, map.integer);
    statistics["rounds"] = round;
    if (round == 1) statistics["defects_poisson"] = stiffening.defects_before;
    statistics["defects_stiffened"] = stiffening.defects_after;
    if (round > 1 || stiffening.defects_before > 0) {
      untangle_seamless(problem, free_system, options.threads, map, statistics);
    }
    map.check = check_map(problem.surface, problem.sectors,
                          fixed_point_map(problem.variables, map.real, map.integer));
    if (map.check.valid()) break;
    stiffen(problem.surface, defective_triangles(problem, map.check), map.stiffness);
  }
  statistics["folded"] = map.check.folded.size();
  statistics["overwound"] = map.check.overwound.size();
  return map;
}

}  // namespace neurframe
