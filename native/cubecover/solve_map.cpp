#include <utility>

#include "cubecover/parametrize.hpp"
#include "cubecover/quantize.hpp"
#include "cubecover/separation.hpp"
#include "cubecover/untangle.hpp"

namespace neurframe {

namespace {

std::vector<Eigen::Matrix3d> relative_gradients(const TetTargets& targets, const ReducedMap& map,
                                                const Eigen::VectorXd& columns) {
  const Eigen::VectorXd rows = evaluate(map, columns);
  std::vector<Eigen::Matrix3d> gradients;
  for (int t = 0; t < static_cast<int>(targets.weight.size()); ++t) {
    gradients.push_back(relative_gradient(targets, map, rows, t));
  }
  return gradients;
}

// Integers for the seamless map, and the reals that follow them with the least change of its gradients.
Eigen::VectorXd with_integers(PreparedField& prepared, const TetTargets& targets,
                              const Eigen::VectorXd& seamless, Parametrization& result) {
  const ReducedMap& map = prepared.map;
  const QuadraticEnergy energy = quadratic_energy(targets, map, relative_gradients(targets, map, seamless));
  const std::vector<SeparationRow> rows =
      separation_rows(prepared.field, prepared.elimination, map, evaluate(map, seamless));
  const Quantization integers =
      quantize(schur_complement(energy, map.real_count), seamless.tail(map.integer_count), rows);
  result.separation_rows = static_cast<int>(rows.size());
  result.violated_rows = integers.violated_rows;
  Eigen::VectorXd columns = seamless;
  columns.tail(map.integer_count) = integers.integers;
  return minimise(energy, columns, map.real_count);
}

}  // namespace

Parametrization solve_map(PreparedField prepared, const ParametrizeOptions& options, Steps& steps) {
  Parametrization result;
  const ReducedMap& map = prepared.map;
  const TetTargets targets = make_targets(prepared.field.mesh, options.cell_length);
  const Eigen::VectorXd poisson = steps.run(0.2, "poisson", [&] {
    const Eigen::VectorXd start = Eigen::VectorXd::Zero(map.column_count());
    return minimise(quadratic_energy(targets, map, {}), start, map.column_count());
  });
  const UntangleResult seamless = steps.run(0.3, "untangle seamless map", [&] {
    return untangle(targets, map, poisson, map.column_count(), options.threads);
  });
  const Eigen::VectorXd rounded =
      steps.run(0.6, "quantize", [&] { return with_integers(prepared, targets, seamless.columns, result); });
  const UntangleResult unfolded = steps.run(0.7, "untangle integer-grid map", [&] {
    return untangle(targets, map, rounded, map.real_count, options.threads);
  });
  result.map = steps.run(0.95, "fixed-point grid", [&] { return round_to_grid(map, unfolded.columns); });
  result.verification = steps.run(0.97, "verify", [&] { return verify(prepared.field, result.map); });
  result.flips = {seamless.before.count, seamless.after.count, unfolded.before.count, unfolded.after.count,
                  static_cast<int>(result.verification.folded_tets.size())};
  result.seamless_iterations = seamless.iterations;
  result.final_iterations = unfolded.iterations;
  result.parametric_volume = parametric_volume(map, evaluate(map, unfolded.columns));
  result.distortion = mean_distortion(targets, map, evaluate(map, unfolded.columns));
  result.real_unknowns = map.real_count;
  result.integer_unknowns = map.integer_count;
  result.basis_changes = prepared.elimination.basis_changes();
  result.preparation = prepared.preparation;
  result.defects = std::move(prepared.defects);
  result.field = std::move(prepared.field);
  return result;
}

}  // namespace neurframe
