#include "cubecover/preparation.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "cubecover/alignment.hpp"
#include "cubecover/matching.hpp"
#include "cubecover/refine.hpp"
#include "cubecover/smoothing.hpp"
#include "cubecover/split.hpp"
#include "cubecover/straighten.hpp"

namespace neurframe {

namespace {

FieldMesh matched_mesh(FieldMesh mesh, const Preparation& preparation) {
  if (preparation.longest_edge > 0) bound_edge_lengths(mesh, preparation.longest_edge);
  separate_boundary(mesh);
  align_boundary_layer(mesh);
  smooth_frames(mesh, preparation.smoothing_sweeps);
  match_faces(mesh);
  if (preparation.straighten) straighten_singular_lines(mesh);
  while (separate_critical_edges(mesh) + separate_boundary(mesh) > 0) {
  }
  return mesh;
}

double mean_edge_length(const FieldMesh& mesh) {
  const EdgeRings rings = edge_rings(mesh.tets, mesh.twin);
  double sum = 0;
  for (const EdgeKey& edge : rings.vertices) sum += edge_length(mesh, edge);
  return sum / static_cast<double>(rings.vertices.size());
}

}  // namespace

PreparedField prepare(FieldMesh mesh, const Preparation& preparation) {
  PreparedField prepared;
  prepared.preparation = preparation;
  prepared.field = comb_field(matched_mesh(std::move(mesh), preparation));
  prepared.elimination = constrain(prepared.field);
  prepared.map = reduce(prepared.field, prepared.elimination);
  prepared.defects = field_defects(prepared.field);
  for (Defect& defect : degenerate_tets(prepared.field, prepared.map))
    prepared.defects.push_back(std::move(defect));
  return prepared;
}

PreparedField best_preparation(const FieldMesh& mesh) {
  // a mesh bounded by its mean edge length has three to five times the tets, and costs as much more to solve
  const Preparation candidates[] = {
      {0, 0, true}, {0, 10, true}, {0, 0, false}, {mean_edge_length(mesh), 20, true}};
  std::optional<PreparedField> best;
  std::vector<PreparationScore> judged;
  for (const Preparation& candidate : candidates) {
    PreparedField prepared = prepare(mesh, candidate);
    const double score = defect_score(prepared.defects);
    judged.push_back({candidate, prepared.field.mesh.tet_count(), score});
    const double worth = candidate.longest_edge > 0 ? 0.5 : 1;
    if (!best || score < worth * defect_score(best->defects)) best = std::move(prepared);
    if (defect_score(best->defects) == 0) break;
  }
  best->judged = std::move(judged);
  return std::move(*best);
}

FieldMesh refined_around(const FieldMesh& mesh, const std::vector<int>& tets) {
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
  return refined;
}

}  // namespace neurframe
