#include "cubecover/parametrize.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "core/errors.hpp"
#include "cubecover/line_repair.hpp"

namespace neurframe {

namespace {

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

constexpr double feature_worth = 2;  // a tenth of the features is worth a fifth of the distortion

// Distortion, dearer for every feature of the input that the map does not follow.
double cost_of(const Parametrization& result, const FieldMesh& input) {
  if (input.features.empty()) return result.distortion;
  std::vector<EdgeKey> followed;
  std::set_intersection(input.features.begin(), input.features.end(), result.field.mesh.features.begin(),
                        result.field.mesh.features.end(), std::back_inserter(followed));
  const double lost = 1 - static_cast<double>(followed.size()) / static_cast<double>(input.features.size());
  return result.distortion * (1 + feature_worth * lost);
}

bool is_better(const Parametrization& one, const Parametrization& other, const FieldMesh& input) {
  const std::size_t failures = failure_count(one);
  const std::size_t others = failure_count(other);
  return failures < others || (failures == others && cost_of(one, input) < cost_of(other, input));
}

// With more of the mesh wrong than this, the field is at fault and refining is in vain.
constexpr double hopeless_share = 0.02;
// Of the foldover-free energy: a polycube map that is no more distorted needs no rival.
constexpr double hardly_distorted = 6;

constexpr double same_distortion = 0.02;  // maps that differ by less are hardly two

constexpr double most_doubtful = 10;              // defect score of a polycube that is worth a try
constexpr std::int64_t polycube_budget = 200000;  // tets to solve for, all polycubes together

bool is_hopeless(std::size_t failed_tets, const FieldMesh& mesh) {
  return static_cast<double>(failed_tets) > hopeless_share * mesh.tet_count();
}

// It is in the shape of the solid: no other frames and no moves of lines give it room.
bool has_cusp(const PreparedField& prepared) {
  return std::any_of(prepared.defects.begin(), prepared.defects.end(),
                     [](const Defect& defect) { return defect.kind == Defect::Kind::cusp; });
}

// Tries one preparation after the other until a map is valid, and keeps the best one.
class Search {
 public:
  Search(const FieldMesh& mesh, const ParametrizeOptions& options, Steps& steps)
      : mesh_(mesh), options_(options), steps_(steps) {}

  // A preparation without defects is solved at once.  A defect is a proof that there is no map: what has one
  // is solved, in the order of the defects, where nothing else is left to try.
  void try_preparations() {
    for (const Preparation& preparation : usual_preparations()) {
      waiting_.push_back(prepared([&] { return prepare(mesh_, preparation); }));
      if (waiting_.back().score() == 0) try_waiting();
      if (done()) return;
    }
    if (waiting_.empty()) return;
    const auto soundest = std::min_element(
        waiting_.begin(), waiting_.end(),
        [](const PreparedField& a, const PreparedField& b) { return a.score() < b.score(); });
    if (!is_hopeless(soundest->defects.size(), soundest->framed) && !has_cusp(*soundest))
      *soundest = prepared([&] { return with_line_repairs(with_local_restarts(std::move(*soundest))); });
    try_waiting();
  }

  // Lines that touch spoil a map, though nothing is wrong with either of them: once more with lines parted,
  // for the field without defects whose map failed least.
  void try_lines_parted() {
    if (done() || !failed_with_nodes_) return;
    auto [mesh, preparation, failures] = std::move(*failed_with_nodes_);
    PreparedField parted =
        steps_.run(0.0, "prepare", [&] { return with_lines_parted(std::move(mesh), preparation); });
    if (parted.preparation.line_moves == preparation.line_moves) return;
    judged_.push_back(parted.judged());
    try_field(std::move(parted));
  }

  // Whether a field of frames was without a defect that is known, as its frames have it: where lines had to
  // be moved, retries on a finer mesh never gave a map.
  bool has_sound_field() const { return lowest_score_ == 0; }

  // Where nothing could be tried, the soundest of the fields with defects, for what it can give.
  void try_defective() {
    if (!best_ && defective_) try_field(std::move(*defective_));
  }

  // Where no field of frames carries a map: a polycube has no singular lines that could stand in its way. Its
  // labels decide how bent the cells are, so the least distorted of the valid maps is taken.
  void try_polycubes() {
    if (done()) return;
    PolycubeSequence sequence(mesh_);
    std::optional<PreparedField> doubtful;  // the soundest of those that are hardly worth a try
    for (std::int64_t work = 0; work < polycube_budget && !is_content();) {
      if (waiting_.empty()) {
        std::optional<PreparedField> next = steps_.run(0.0, "prepare", [&] { return sequence.next(); });
        if (!next) break;
        judged_.push_back(next->judged());
        if (next->score() > most_doubtful) {
          if (!doubtful || next->score() < doubtful->score()) doubtful = std::move(next);
          continue;
        }
        waiting_.push_back(std::move(*next));
      }
      PreparedField field = std::move(waiting_.back());
      waiting_.pop_back();
      work += field.field.mesh.tet_count();
      try_field(std::move(field));  // where it fails, it may wait again with fewer features
    }
    waiting_.clear();
    if (!done() && doubtful) try_field(std::move(*doubtful));
  }

  void retry_around_failures() {
    for (int retry = 0; retry < options_.retries && best_ && !done(); ++retry) {
      const std::vector<int> failed = failed_tets(*best_);
      if (is_hopeless(failed.size(), best_->field.mesh)) return;
      const std::size_t failures = failure_count(*best_);
      waiting_.push_back(
          prepared([&] { return refined_around(best_->field.mesh, best_->preparation, failed); }));
      try_waiting();
      if (failure_count(*best_) >= failures) return;
    }
  }

  Parametrization result() {
    const std::vector<int> distinct = distinct_valid_maps();
    if (options_.alternative > std::max(1, static_cast<int>(distinct.size())))
      throw InputError("there are " + std::to_string(distinct.size()) + " valid maps, no number " +
                       std::to_string(options_.alternative));
    if (options_.alternative > 1) best_ = std::move(at(valid_, at(distinct, options_.alternative - 1)).map);
    best_->valid_maps = static_cast<int>(distinct.size());
    best_->input_tets = mesh_.tet_count();
    best_->attempts = attempts_;
    best_->preparations_judged = judged_;
    best_->times = steps_.times();
    return std::move(*best_);
  }

 private:
  bool done() const { return best_ && best_->verification.valid(); }
  bool is_content() const { return done() && cost_of(*best_, mesh_) <= hardly_distorted; }

  template <class Make>
  PreparedField prepared(const Make& make) {
    PreparedField field = steps_.run(0.0, "prepare", make);
    judged_.push_back(field.judged());
    if (!field.preparation.has_matchings()) lowest_score_ = std::min(lowest_score_, field.score());
    return field;
  }

  // The soundest first.  What fails may wait again with fewer features, so the list grows meanwhile.
  void try_waiting() {
    while (!waiting_.empty() && !done()) {
      const auto soundest = std::min_element(
          waiting_.begin(), waiting_.end(),
          [](const PreparedField& a, const PreparedField& b) { return a.score() < b.score(); });
      PreparedField field = std::move(*soundest);
      waiting_.erase(soundest);
      const bool may_work = field.score() == 0 || field.preparation.is_polycube();
      if (may_work || options_.polycubes == Polycubes::never) {
        try_field(std::move(field));
      } else if (!defective_ || field.score() < defective_->score()) {
        defective_ = std::move(field);
      }
    }
    waiting_.clear();
  }

  void try_field(PreparedField field) {
    const bool sound = field.score() == 0 && !field.preparation.is_polycube();
    Parametrization next = solve_map(std::move(field), options_, steps_);
    attempts_.push_back(
        {next.preparation, next.field.mesh.features.size(), failure_count(next), next.distortion});
    if (next.verification.valid()) remember(next);
    if (next.preparation.is_polycube() && failure_count(next) > 0) try_with_fewer_features(next);
    if (sound) remember_nodes(next);
    if (best_ && !is_better(next, *best_, mesh_)) return;
    best_ = std::move(next);
  }

  struct ValidMap {
    double cost;
    double distortion;
    std::optional<Parametrization> map;  // held only where another than the best may be asked for
  };

  void remember(const Parametrization& found) {
    valid_.push_back({cost_of(found, mesh_), found.distortion, {}});
    if (options_.alternative > 1) valid_.back().map = found;
  }

  struct FailedField {
    FieldMesh mesh;
    Preparation preparation;
    std::size_t failures;
  };

  void remember_nodes(const Parametrization& found) {
    const std::size_t failures = failure_count(found);
    if (failures == 0 || found.field.singular.nodes.empty()) return;
    if (failed_with_nodes_ && failed_with_nodes_->failures <= failures) return;
    failed_with_nodes_ = {found.field.mesh, found.preparation, failures};
  }

  // Indices of the valid maps, the best one first, without those that are hardly different from a better one.
  std::vector<int> distinct_valid_maps() {
    std::stable_sort(valid_.begin(), valid_.end(),
                     [](const ValidMap& a, const ValidMap& b) { return a.cost < b.cost; });
    std::vector<int> distinct;
    for (int i = 0; i < static_cast<int>(valid_.size()); ++i) {
      const double here = at(valid_, i).distortion;
      const bool is_new = std::all_of(distinct.begin(), distinct.end(), [&](int other) {
        return std::abs(here / at(valid_, other).distortion - 1) > same_distortion;
      });
      if (is_new) distinct.push_back(i);
    }
    return distinct;
  }

  // A feature inside a label may be what a polycube fails at: it waits for a try without those at its
  // failures.
  void try_with_fewer_features(const Parametrization& failed) {
    const std::vector<int> tets = failed_tets(failed);
    if (is_hopeless(tets.size(), failed.field.mesh)) return;
    FieldMesh released = without_inner_features_at(failed.field.mesh, tets);
    if (released.features.size() == failed.field.mesh.features.size()) return;
    waiting_.push_back(prepared([&] { return prepare_again(std::move(released), failed.preparation); }));
  }

  const FieldMesh& mesh_;
  const ParametrizeOptions& options_;
  Steps& steps_;
  std::vector<PreparedField> waiting_;
  std::vector<PreparationScore> judged_;
  std::optional<Parametrization> best_;
  std::optional<PreparedField> defective_;
  std::optional<FailedField> failed_with_nodes_;
  double lowest_score_ = std::numeric_limits<double>::infinity();
  std::vector<Attempt> attempts_;
  std::vector<ValidMap> valid_;
};

}  // namespace

Parametrization solve_prepared(PreparedField prepared, const ParametrizeOptions& options,
                               const ProgressCallback& progress) {
  Steps steps(progress);
  return solve_map(std::move(prepared), options, steps);
}

Parametrization parametrize(const FieldMesh& mesh, const ParametrizeOptions& options,
                            const ProgressCallback& progress) {
  Steps steps(progress);
  Search search(mesh, options, steps);
  if (options.polycubes != Polycubes::only) {
    search.try_preparations();
    search.try_lines_parted();
    if (search.has_sound_field()) search.retry_around_failures();
  }
  if (options.polycubes != Polycubes::never) search.try_polycubes();
  search.try_defective();
  search.retry_around_failures();
  return search.result();
}

}  // namespace neurframe
