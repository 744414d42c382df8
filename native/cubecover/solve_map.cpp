#include <algorithm>
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

// Each keeps apart what the one before has let collapse; a seamless map that is folded itself is rounded
// once, to have what can be had.
constexpr int most_roundings = 4;

// Integers for the seamless map, and reals that follow them, until no tet that they fold is seen to be
// squeezed between two equal integers.
class IntegerGrid {
 public:
  IntegerGrid(PreparedField& prepared, const TetTargets& targets, const std::vector<FaceTarget>& faces,
              const UntangleResult& seamless, const ParametrizeOptions& options, Steps& steps)
      : prepared_(prepared),
        targets_(targets),
        faces_(faces),
        seamless_(seamless.columns),
        roundings_(seamless.after.count == 0 ? most_roundings : 1),
        options_(options),
        steps_(steps) {}

  UntangleResult solve(Parametrization& result) {
    steps_.run(0.6, "quantize", [&] { prepare(); });
    UntangleResult unfolded;
    for (int rounding = 0; rounding < roundings_; ++rounding) {
      unfolded = round();
      result.map =
          steps_.run(0.95, "fixed-point grid", [&] { return round_to_grid(map_, unfolded.columns); });
      result.verification = steps_.run(0.97, "verify", [&] { return verify(prepared_.field, result.map); });
      if (!keep_apart(result.verification.folded_tets, unfolded.columns)) break;
    }
    result.separation_rows = static_cast<int>(rows_.size());
    result.violated_rows = violated_rows_;
    return unfolded;
  }

 private:
  void prepare() {
    energy_ = quadratic_energy(targets_, map_, relative_gradients(targets_, map_, seamless_));
    schur_ = schur_complement(energy_, map_.real_count);
    rows_ = separation_rows(prepared_.field, prepared_.elimination, map_, evaluate(map_, seamless_));
  }

  // The reals follow the integers with the least change of the seamless map's gradients, then unfold.
  UntangleResult round() {
    const Eigen::VectorXd rounded = steps_.run(0.6, "quantize", [&] {
      const Quantization integers = quantize(schur_, seamless_.tail(map_.integer_count), rows_);
      violated_rows_ = integers.violated_rows;
      Eigen::VectorXd columns = seamless_;
      columns.tail(map_.integer_count) = integers.integers;
      return minimise(energy_, columns, map_.real_count);
    });
    return steps_.run(0.7, "untangle integer-grid map", [&] {
      return untangle(targets_, faces_, map_, rounded, map_.real_count, options_.threads);
    });
  }

  bool keep_apart(const std::vector<int>& folded_tets, const Eigen::VectorXd& columns) {
    const std::size_t before = rows_.size();
    for (SeparationRow& row :
         collapsed_rows(prepared_.field, prepared_.elimination, map_, evaluate(map_, seamless_),
                        evaluate(map_, columns), folded_tets)) {
      if (std::find(rows_.begin(), rows_.end(), row) == rows_.end()) rows_.push_back(std::move(row));
    }
    return rows_.size() > before;
  }

  PreparedField& prepared_;
  const TetTargets& targets_;
  const std::vector<FaceTarget>& faces_;
  const Eigen::VectorXd& seamless_;
  int roundings_;
  const ParametrizeOptions& options_;
  Steps& steps_;
  const ReducedMap& map_ = prepared_.map;
  QuadraticEnergy energy_;
  Eigen::MatrixXd schur_;
  std::vector<SeparationRow> rows_;
  int violated_rows_ = 0;
};

}  // namespace

Parametrization solve_map(PreparedField prepared, const ParametrizeOptions& options, Steps& steps) {
  Parametrization result;
  const ReducedMap& map = prepared.map;
  const TetTargets targets = make_targets(prepared.field.mesh, options.cell_length);
  const std::vector<FaceTarget> faces = make_face_targets(prepared.field, targets);
  const Eigen::VectorXd poisson = steps.run(0.2, "poisson", [&] {
    const Eigen::VectorXd start = Eigen::VectorXd::Zero(map.column_count());
    return minimise(quadratic_energy(targets, map, {}), start, map.column_count());
  });
  const UntangleResult seamless = steps.run(0.3, "untangle seamless map", [&] {
    return untangle(targets, faces, map, poisson, map.column_count(), options.threads);
  });
  const UntangleResult unfolded =
      IntegerGrid(prepared, targets, faces, seamless, options, steps).solve(result);
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
