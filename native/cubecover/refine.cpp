#include "cubecover/refine.hpp"

#include <algorithm>
#include <string>

#include "core/errors.hpp"
#include "cubecover/matching.hpp"
#include "cubecover/split.hpp"

namespace neurframe {

namespace {

constexpr int most_passes = 200;  // each pass splits a maximal independent set; ten are usual

// Calls find_targets and splits until it finds none; returns how many it split.
template <class FindTargets>
int split_until_none(FieldMesh& mesh, const char* what, const FindTargets& find_targets) {
  int total = 0;
  for (int pass = 0; pass < most_passes; ++pass) {
    const int split_count = split_independent(mesh, find_targets(mesh));
    if (split_count == 0) return total;
    total += split_count;
  }
  throw StageError(std::string("splitting ") + what + " does not end; the mesh is too tangled to prepare");
}

SplitTarget edge_target(const EdgeRings& rings, std::size_t edge) {
  return {{rings.vertices[edge][0], rings.vertices[edge][1]}, rings.ring(edge).front() / 4};
}

std::vector<SplitTarget> chords(const FieldMesh& mesh, const std::vector<char>& on_boundary) {
  const EdgeRings rings = edge_rings(mesh.tets, mesh.twin);
  std::vector<SplitTarget> targets;
  for (std::size_t e = 0; e < rings.vertices.size(); ++e) {
    const auto [a, b] = rings.vertices[e];
    if (!rings.on_boundary[e] && at(on_boundary, a) && at(on_boundary, b))
      targets.push_back(edge_target(rings, e));
  }
  return targets;
}

std::vector<SplitTarget> spanning_faces(const FieldMesh& mesh, const std::vector<char>& on_boundary) {
  std::vector<SplitTarget> targets;
  for (int h = 0; h < mesh.half_face_count(); ++h) {
    if (at(mesh.twin, h) < h) continue;  // boundary, or seen from the other side
    const auto [a, b, c] = half_face_vertices(mesh.tets, h);
    if (at(on_boundary, a) && at(on_boundary, b) && at(on_boundary, c)) targets.push_back({{a, b, c}, h / 4});
  }
  return targets;
}

std::vector<SplitTarget> corner_tets(const FieldMesh& mesh) {
  std::vector<SplitTarget> targets;
  for (int t = 0; t < mesh.tet_count(); ++t) {
    int boundary_faces = 0;
    for (int corner = 0; corner < 4; ++corner) boundary_faces += at(mesh.twin, 4 * t + corner) < 0 ? 1 : 0;
    const Tet& tet = at(mesh.tets, t);
    if (boundary_faces >= 2) targets.push_back({{tet.begin(), tet.end()}, t});
  }
  return targets;
}

struct CriticalEdges {
  EdgeRings rings;
  std::vector<char> edge;    // singular, or a feature
  std::vector<char> vertex;  // on such an edge
};

CriticalEdges find_critical_edges(const FieldMesh& mesh) {
  CriticalEdges critical{edge_rings(mesh.tets, mesh.twin), {}, std::vector<char>(mesh.points.size(), 0)};
  for (std::size_t e = 0; e < critical.rings.vertices.size(); ++e) {
    const auto [a, b] = critical.rings.vertices[e];
    const bool singular =
        !critical.rings.on_boundary[e] && !holonomy(mesh, critical.rings.ring(e)).is_identity();
    critical.edge.push_back(singular || is_feature(mesh, edge_key(a, b)));
    if (critical.edge.back()) at(critical.vertex, a) = at(critical.vertex, b) = 1;
  }
  return critical;
}

std::vector<SplitTarget> bridges(const CriticalEdges& critical) {
  std::vector<SplitTarget> targets;
  for (std::size_t e = 0; e < critical.rings.vertices.size(); ++e) {
    const auto [a, b] = critical.rings.vertices[e];
    if (!critical.edge[e] && at(critical.vertex, a) && at(critical.vertex, b)) {
      targets.push_back(edge_target(critical.rings, e));
    }
  }
  return targets;
}

std::vector<SplitTarget> enclosed_faces(const FieldMesh& mesh, const CriticalEdges& critical) {
  const auto edge_between = [&](int tet, int a, int b) { return ring_of(mesh, critical.rings, tet, a, b); };
  std::vector<SplitTarget> targets;
  for (int h = 0; h < mesh.half_face_count(); ++h) {
    if (at(mesh.twin, h) > h) continue;
    const auto [a, b, c] = half_face_vertices(mesh.tets, h);
    if (at(critical.edge, edge_between(h / 4, a, b)) && at(critical.edge, edge_between(h / 4, b, c)) &&
        at(critical.edge, edge_between(h / 4, c, a))) {
      targets.push_back({{a, b, c}, h / 4});
    }
  }
  return targets;
}

}  // namespace

int separate_boundary(FieldMesh& mesh) {
  return split_until_none(mesh, "interior simplices that span the boundary", [](const FieldMesh& current) {
    const std::vector<char> on_boundary = boundary_vertices(current);
    std::vector<SplitTarget> targets = chords(current, on_boundary);
    if (targets.empty()) targets = spanning_faces(current, on_boundary);
    return targets.empty() ? corner_tets(current) : targets;
  });
}

int separate_critical_edges(FieldMesh& mesh) {
  return split_until_none(mesh, "edges between singular lines", [](const FieldMesh& current) {
    const CriticalEdges critical = find_critical_edges(current);
    std::vector<SplitTarget> targets = bridges(critical);
    return targets.empty() ? enclosed_faces(current, critical) : targets;
  });
}

}  // namespace neurframe
