#include "cubecover/parametrize.hpp"

#include <ctime>
#include <utility>

#include "cubecover/alignment.hpp"
#include "cubecover/matching.hpp"
#include "cubecover/quantize.hpp"
#include "cubecover/refine.hpp"
#include "cubecover/separation.hpp"
#include "cubecover/straighten.hpp"
#include "cubecover/untangle.hpp"

namespace neurframe {

namespace {

// Runs the steps, says so, and keeps their CPU seconds.
class Steps {
 public:
  Steps(Parametrization& result, const ProgressCallback& progress) : result_(result), progress_(progress) {}

  template <class Body>
  auto run(double fraction, const std::string& name, const Body& body) {
    progress_(fraction, name);
    const Timer timer{result_, name, std::clock()};
    return body();
  }

 private:
  struct Timer {
    Parametrization& result;
    std::string name;
    std::clock_t start;
    ~Timer() { result.times.push_back({name, static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC}); }
  };

  Parametrization& result_;
  const ProgressCallback& progress_;
};

FieldMesh prepare(FieldMesh mesh) {
  separate_boundary(mesh);
  align_boundary_layer(mesh);
  match_faces(mesh);
  straighten_singular_lines(mesh);
  while (separate_critical_edges(mesh) + separate_boundary(mesh) > 0) {
  }
  return mesh;
}

std::vector<Eigen::Matrix3d> relative_gradients(const TetTargets& targets, const ReducedMap& map,
                                                const Eigen::VectorXd& columns) {
  const Eigen::VectorXd rows = evaluate(map, columns);
  std::vector<Eigen::Matrix3d> gradients;
  for (int t = 0; t < static_cast<int>(targets.weight.size()); ++t) {
    gradients.push_back(relative_gradient(targets, map, rows, t));
  }
  return gradients;
}

}  // namespace

Parametrization parametrize(FieldMesh mesh, const ParametrizeOptions& options,
                            const ProgressCallback& progress) {
  Parametrization result;
  Steps steps(result, progress);
  result.input_tets = mesh.tet_count();
  mesh = steps.run(0.0, "split", [&] { return prepare(std::move(mesh)); });
  result.field = steps.run(0.1, "comb", [&] { return comb_field(std::move(mesh)); });
  const CombedField& field = result.field;
  result.defects = field_defects(field);
  Elimination elimination = steps.run(0.15, "eliminate", [&] { return constrain(field); });
  const ReducedMap map = reduce(field, elimination);
  for (Defect& defect : degenerate_tets(field, map)) result.defects.push_back(std::move(defect));
  result.real_unknowns = map.real_count;
  result.integer_unknowns = map.integer_count;
  result.basis_changes = elimination.basis_changes();

  const TetTargets targets = make_targets(field.mesh, options.cell_length);
  const Eigen::VectorXd poisson = steps.run(0.2, "poisson", [&] {
    return minimise(quadratic_energy(targets, map, {}), Eigen::VectorXd::Zero(map.column_count()),
                    map.column_count());
  });
  const UntangleResult seamless = steps.run(
      0.3, "untangle seamless map", [&] { return untangle(targets, map, poisson, map.column_count()); });
  result.flips.poisson = seamless.before.count;
  result.flips.seamless = seamless.after.count;
  result.seamless_iterations = seamless.iterations;

  const QuadraticEnergy around_seamless =
      quadratic_energy(targets, map, relative_gradients(targets, map, seamless.columns));
  Eigen::VectorXd rounded = steps.run(0.6, "quantize", [&] {
    const std::vector<SeparationRow> rows =
        separation_rows(field, elimination, map, evaluate(map, seamless.columns));
    const Quantization integers = quantize(schur_complement(around_seamless, map.real_count),
                                           seamless.columns.tail(map.integer_count), rows);
    result.separation_rows = static_cast<int>(rows.size());
    result.violated_rows = integers.violated_rows;
    Eigen::VectorXd columns = seamless.columns;
    columns.tail(map.integer_count) = integers.integers;
    return minimise(around_seamless, columns, map.real_count);
  });
  const UntangleResult final_map = steps.run(0.7, "untangle integer-grid map",
                                             [&] { return untangle(targets, map, rounded, map.real_count); });
  result.flips.rounded = final_map.before.count;
  result.flips.untangled = final_map.after.count;
  result.final_iterations = final_map.iterations;

  result.map =
      steps.run(0.95, "round to the fixed-point grid", [&] { return round_to_grid(map, final_map.columns); });
  result.verification = steps.run(0.97, "verify", [&] { return verify(field, result.map); });
  result.flips.exact = static_cast<int>(result.verification.folded_tets.size());
  result.parametric_volume = parametric_volume(map, evaluate(map, final_map.columns));
  return result;
}

}  // namespace neurframe
