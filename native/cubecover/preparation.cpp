#include "cubecover/preparation.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "cubecover/local_restart.hpp"
#include "cubecover/matching.hpp"
#include "cubecover/refine.hpp"
#include "cubecover/split.hpp"
#include "cubecover/straighten.hpp"

namespace neurframe {

namespace {

constexpr int diffusion_rounds = 20;
constexpr LabelCosts label_costs[] = {{1, 0}, {1, 3}, {0.5, 0}, {3, 0}, {3, 3}};
constexpr int restart_budget = 300000;           // tets that restarts may prepare again, all tries together
constexpr double restart_radii[] = {1.5, 3, 5};  // mean edge lengths
constexpr double restart_sources[] = {0, 0.4, 0.8};  // along the rim

FieldMesh framed_mesh(FieldMesh mesh, const Preparation& preparation) {
  separate_boundary(mesh);
  if (preparation.diffusion_rounds > 0) {
    diffuse_frames(mesh, boundary_alignments(mesh), {preparation.diffusion_rounds});
  } else {
    align_boundary_layer(mesh);
  }
  return mesh;
}

PreparedField matched_field(FieldMesh framed, const Preparation& preparation) {
  if (!preparation.has_matchings()) {
    match_faces(framed);
    straighten_singular_lines(framed);
  }
  return judged_field(std::move(framed), preparation);
}

}  // namespace

PreparedField judged_field(FieldMesh framed, const Preparation& preparation, double most_score) {
  PreparedField prepared;
  prepared.preparation = preparation;
  prepared.framed = framed;
  while (separate_critical_edges(framed) + separate_boundary(framed) > 0) {
  }
  prepared.field = comb_field(std::move(framed));
  prepared.defects = field_defects(prepared.field);
  if (prepared.score() > most_score) return prepared;
  prepared.elimination = constrain(prepared.field);
  prepared.map = reduce(prepared.field, prepared.elimination);
  for (Defect& defect : degenerate_tets(prepared.field, prepared.map))
    prepared.defects.push_back(std::move(defect));
  // a polycube's labels turn where the surface is smooth: there the frame says nothing of the turn
  if (preparation.is_polycube())
    std::erase_if(prepared.defects, [](const Defect& d) {
      return d.kind == Defect::Kind::crooked_sector || d.kind == Defect::Kind::empty_corner ||
             d.kind == Defect::Kind::cusp;
    });
  return prepared;
}

double mean_edge_length(const FieldMesh& mesh) {
  const EdgeRings rings = edge_rings(mesh.tets, mesh.twin);
  double sum = 0;
  for (const EdgeKey& edge : rings.vertices) sum += edge_length(mesh, edge);
  return sum / static_cast<double>(rings.vertices.size());
}

FieldSearch::FieldSearch(PreparedField& prepared, int budget)
    : prepared_(prepared),
      alignments_(boundary_alignments(prepared.framed)),
      edge_length_(mean_edge_length(prepared.framed)),
      tries_left_(budget / std::max(1, prepared.framed.tet_count())) {}

bool FieldSearch::keep_if_sounder(PreparedField candidate) {
  if (candidate.score() >= prepared_.score()) return false;
  prepared_ = std::move(candidate);
  return true;
}

PreparedField prepare(FieldMesh mesh, const Preparation& preparation) {
  return matched_field(framed_mesh(std::move(mesh), preparation), preparation);
}

std::vector<Preparation> usual_preparations() {
  return {{0}, {diffusion_rounds}};
}

PreparedField prepare_again(FieldMesh mesh, const Preparation& preparation) {
  return matched_field(std::move(mesh), preparation);
}

PolycubeSequence::PolycubeSequence(FieldMesh mesh) : mesh_(std::move(mesh)) {
  separate_boundary(mesh_);
}

// Of each setting of the costs first the one with all features.
FieldMesh PolycubeSequence::next_field() {
  const std::size_t taken = taken_++;
  if (taken % 2 == 1) return without_inner_features(with_features_);
  with_features_ = polycube_field(mesh_, label_costs[taken / 2]);
  return with_features_;
}

std::optional<PreparedField> PolycubeSequence::next() {
  while (taken_ < 2 * std::size(label_costs)) {
    const LabelCosts& costs = label_costs[taken_ / 2];
    FieldMesh field = next_field();
    if (seen_.insert(field.features).second) return matched_field(std::move(field), {0, costs});
  }
  return {};
}

std::vector<Eigen::Vector3d> grave_places(std::vector<Defect> defects) {
  std::stable_sort(defects.begin(), defects.end(),
                   [](const Defect& a, const Defect& b) { return weight_of(a.kind) > weight_of(b.kind); });
  std::vector<Eigen::Vector3d> places;
  for (const Defect& defect : defects) {
    if (weight_of(defect.kind) > 0) places.push_back(defect.place);
  }
  return places;
}

namespace {

// Tries restarts at places of defects until one lowers the score; a ball that failed is not tried again.
class RestartSearch : private FieldSearch {
 public:
  explicit RestartSearch(PreparedField& prepared) : FieldSearch(prepared, restart_budget) {}

  bool improve() {
    for (const Eigen::Vector3d& place : grave_places(prepared_.defects)) {
      if (was_tried(place)) continue;
      for (const double radius : restart_radii) {
        for (const double source : restart_sources) {
          if (!may_try()) return false;
          if (attempt({place, radius * edge_length_, source})) return true;
        }
      }
      tried_.push_back(place);
    }
    return false;
  }

 private:
  bool was_tried(const Eigen::Vector3d& place) const {
    return std::any_of(tried_.begin(), tried_.end(), [&](const Eigen::Vector3d& other) {
      return (other - place).norm() < restart_radii[0] * edge_length_;
    });
  }

  bool attempt(const LocalRestart& restart) {
    FieldMesh framed = prepared_.framed;
    if (!restart_frames(framed, alignments_, restart)) return false;
    PreparedField candidate = matched_field(std::move(framed), prepared_.preparation);
    ++candidate.preparation.restarts;
    return keep_if_sounder(std::move(candidate));
  }

  std::vector<Eigen::Vector3d> tried_;
};

}  // namespace

PreparedField with_local_restarts(PreparedField prepared) {
  RestartSearch search(prepared);
  while (prepared.score() > 0 && search.improve()) {
  }
  return prepared;
}

PreparedField refined_around(const FieldMesh& mesh, const Preparation& preparation,
                             const std::vector<int>& tets) {
  std::vector<std::pair<double, SplitTarget>> found;
  for (const int tet : tets) {
    for (const auto& [i, j] : tet_edges) {
      const EdgeKey edge = edge_key(at(at(mesh.tets, tet), i), at(at(mesh.tets, tet), j));
      found.emplace_back(edge_length(mesh, edge), SplitTarget{{edge[0], edge[1]}, tet});
    }
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<SplitTarget> targets;
  for (auto& [length, target] : found) targets.push_back(std::move(target));
  FieldMesh refined = mesh;
  split_independent(refined, targets);
  separate_boundary(refined);
  if (!preparation.is_polycube()) align_boundary_layer(refined);
  return matched_field(std::move(refined), preparation);
}

}  // namespace neurframe
