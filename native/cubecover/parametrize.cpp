#include "cubecover/parametrize.hpp"

#include <algorithm>
#include <ctime>
#include <utility>

#include "cubecover/quantize.hpp"
#include "cubecover/separation.hpp"
#include "cubecover/untangle.hpp"

namespace neurframe {

namespace {

// Runs the steps, says so, and adds up their CPU seconds.
class Steps {
 public:
  explicit Steps(const ProgressCallback& progress) : progress_(progress) {}

  template <class Body>
  auto run(double fraction, const std::string& name, const Body& body) {
    progress_(fraction, name);
    const Timer timer{times_, name, std::clock()};
    return body();
  }

  const std::vector<StepTime>& times() const { return times_; }

 private:
  struct Timer {
    std::vector<StepTime>& times;
    std::string name;
    std::clock_t start;
    ~Timer() {
      const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
      const auto found =
          std::find_if(times.begin(), times.end(), [&](const StepTime& t) { return t.step == name; });
      if (found != times.end()) {
        found->cpu_seconds += seconds;
      } else {
        times.push_back({name, seconds});
      }
    }
  };

  const ProgressCallback& progress_;
  std::vector<StepTime> times_;
};

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

Parametrization solve(PreparedField prepared, const ParametrizeOptions& options, Steps& steps) {
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
  result.real_unknowns = map.real_count;
  result.integer_unknowns = map.integer_count;
  result.basis_changes = prepared.elimination.basis_changes();
  result.preparation = prepared.preparation;
  result.defects = std::move(prepared.defects);
  result.field = std::move(prepared.field);
  return result;
}

std::vector<int> failed_tets(const Parametrization& result) {
  std::vector<int> tets = result.verification.folded_tets;
  for (const Verification::WoundEdge& wound : result.verification.wound_edges) {
    for (const int h : result.field.rings.ring(static_cast<std::size_t>(wound.ring))) tets.push_back(h / 4);
  }
  std::sort(tets.begin(), tets.end());
  tets.erase(std::unique(tets.begin(), tets.end()), tets.end());
  return tets;
}

std::size_t failure_count(const Parametrization& result) {
  const Verification& found = result.verification;
  return found.folded_tets.size() + found.wound_edges.size() + found.open_seams.size() +
         found.unaligned_faces.size();
}

// With more of the mesh wrong than this, the field is at fault and refining is in vain.
constexpr double hopeless_share = 0.02;

}  // namespace

Parametrization parametrize(const FieldMesh& mesh, const ParametrizeOptions& options,
                            const ProgressCallback& progress) {
  Steps steps(progress);
  PreparedField prepared = steps.run(0.0, "prepare", [&] { return best_preparation(mesh); });
  const std::vector<PreparationScore> judged = prepared.judged;
  Parametrization best = solve(std::move(prepared), options, steps);
  int tries = 1;
  for (; tries <= options.retries && !best.verification.valid(); ++tries) {
    const std::vector<int> failed = failed_tets(best);
    if (static_cast<double>(failed.size()) > hopeless_share * best.field.mesh.tet_count()) break;
    PreparedField refined = steps.run(0.1, "prepare", [&] {
      return prepare(refined_around(best.field.mesh, failed),
                     {0, best.preparation.smoothing_sweeps, best.preparation.straighten});
    });
    Parametrization next = solve(std::move(refined), options, steps);
    next.preparation = best.preparation;
    if (failure_count(next) >= failure_count(best)) break;
    best = std::move(next);
  }
  best.input_tets = mesh.tet_count();
  best.tries = tries;
  best.preparations_judged = judged;
  best.times = steps.times();
  return best;
}

}  // namespace neurframe
