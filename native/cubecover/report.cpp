#include "cubecover/report.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace neurframe {

namespace {

constexpr std::size_t most_places = 200;  // of one kind; a broken map has thousands, which tell no more

Json place(const Eigen::Vector3d& point) {
  return Json(Json::Array{point.x(), point.y(), point.z()});
}

// {"count": n, "places": [[x, y, z], ...]}
Json counted_places(const std::vector<Eigen::Vector3d>& points) {
  Json::Array places;
  for (std::size_t i = 0; i < std::min(points.size(), most_places); ++i) places.push_back(place(points[i]));
  Json entry;
  entry["count"] = points.size();
  entry["places"] = Json(places);
  return entry;
}

Json describe_arcs(const CombedField& field) {
  Json::Array arcs;
  for (const SingularArc& arc : field.singular.arcs) {
    double length = 0;
    for (const int edge : arc.edges)
      length += edge_length(field.mesh, at(field.singular.edges, edge).vertices);
    Json entry;
    entry["valence"] = arc.valence;
    entry["edges"] = arc.edges.size();
    entry["length"] = length;
    entry["closed"] = arc.vertices.front() == arc.vertices.back();
    entry["from"] = place(at(field.mesh.points, arc.vertices.front()));
    entry["to"] = place(at(field.mesh.points, arc.vertices.back()));
    arcs.push_back(std::move(entry));
  }
  return Json(arcs);
}

Json describe_defects(const std::vector<Defect>& defects) {
  std::map<std::string, std::vector<Eigen::Vector3d>> by_kind;
  for (const Defect& defect : defects) by_kind[name_of(defect.kind)].push_back(defect.place);
  Json entry;
  for (const auto& [kind, places] : by_kind) entry[kind] = counted_places(places);
  return entry;
}

Json describe_verification(const CombedField& field, const Verification& verification) {
  std::vector<Eigen::Vector3d> folded, seams, faces, edges;
  for (const int t : verification.folded_tets) folded.push_back(tet_center(field.mesh, t));
  for (const int h : verification.open_seams) seams.push_back(tet_center(field.mesh, h / 4));
  for (const int h : verification.unaligned_faces) faces.push_back(tet_center(field.mesh, h / 4));
  Json::Array turns;
  for (const Verification::WoundEdge& wound : verification.wound_edges) {
    const EdgeKey& ends = at(field.rings.vertices, wound.ring);
    edges.push_back((at(field.mesh.points, ends[0]) + at(field.mesh.points, ends[1])) / 2);
    turns.push_back(Json(Json::Array{wound.quarter_turns, wound.expected}));
  }
  turns.resize(std::min(turns.size(), most_places));
  Json entry;
  entry["valid"] = verification.valid();
  entry["folded_tets"] = counted_places(folded);
  entry["open_seams"] = counted_places(seams);
  entry["unaligned_faces"] = counted_places(faces);
  entry["wrongly_wound_edges"] = counted_places(edges);
  entry["wrongly_wound_edges"]["quarter_turns_found_and_expected"] = Json(turns);
  return entry;
}

Json describe_preparation(const Preparation& preparation) {
  Json entry;
  entry["diffusion_rounds"] = preparation.diffusion_rounds;
  entry["polycube_compactness"] = preparation.polycube.compactness;
  entry["polycube_straightness"] = preparation.polycube.straightness;
  entry["restarts"] = preparation.restarts;
  entry["line_moves"] = preparation.line_moves;
  return entry;
}

Json describe_preparations(const std::vector<PreparationScore>& judged) {
  Json::Array entries;
  for (const PreparationScore& score : judged) {
    Json entry = describe_preparation(score.preparation);
    entry["tets"] = score.tets;
    entry["defect_score"] = score.defect_score;
    entries.push_back(std::move(entry));
  }
  return Json(entries);
}

Json describe_attempts(const std::vector<Attempt>& attempts) {
  Json::Array entries;
  for (const Attempt& attempt : attempts) {
    Json entry = describe_preparation(attempt.preparation);
    entry["feature_edges"] = attempt.features;
    entry["failures"] = attempt.failures;
    if (std::isfinite(attempt.distortion)) entry["distortion"] = attempt.distortion;
    entries.push_back(std::move(entry));
  }
  return Json(entries);
}

}  // namespace

void describe(const Parametrization& result, Json& statistics) {
  const CombedField& field = result.field;
  std::vector<Eigen::Vector3d> nodes;
  for (const int vertex : field.singular.nodes) nodes.push_back(at(field.mesh.points, vertex));
  statistics["valid"] = result.verification.valid();
  statistics["input_tets"] = result.input_tets;
  statistics["tets"] = field.mesh.tet_count();
  statistics["tries"] = result.attempts.size();
  statistics["valid_maps"] = result.valid_maps;
  statistics["attempts"] = describe_attempts(result.attempts);
  statistics["preparations_judged"] = describe_preparations(result.preparations_judged);
  statistics["polycube"] = result.preparation.is_polycube();
  statistics["feature_edges"] = field.mesh.features.size();
  statistics["singular_edges"] = field.singular.edges.size();
  statistics["singular_arcs"] = describe_arcs(field);
  statistics["singular_nodes"] = counted_places(nodes);
  statistics["defects"] = describe_defects(result.defects);
  statistics["real_unknowns"] = result.real_unknowns;
  statistics["integers"] = result.integer_unknowns;
  statistics["lattice_basis_changes"] = result.basis_changes;
  statistics["separation_rows"] = result.separation_rows;
  statistics["violated_separation_rows"] = result.violated_rows;
  Json& flips = statistics["flips"];
  flips["poisson"] = result.flips.poisson;
  flips["seamless"] = result.flips.seamless;
  flips["rounded"] = result.flips.rounded;
  flips["untangled"] = result.flips.untangled;
  flips["exact"] = result.flips.exact;
  statistics["untangling_iterations"]["seamless"] = result.seamless_iterations;
  statistics["untangling_iterations"]["integer_grid"] = result.final_iterations;
  statistics["map"] = describe_verification(field, result.verification);
  statistics["fraction_bits"] = result.map.fraction_bits;
  statistics["expected_hexes"] = result.parametric_volume;
  if (std::isfinite(result.distortion)) statistics["distortion"] = result.distortion;
  Json& seconds = statistics["cpu_seconds"];
  for (const StepTime& time : result.times) seconds[time.step] = time.cpu_seconds;
}

}  // namespace neurframe
