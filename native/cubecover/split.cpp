#include "cubecover/split.hpp"

#include <algorithm>
#include <utility>

namespace neurframe {

namespace {

bool has_vertices(const Tet& tet, const std::vector<int>& vertices) {
  return std::all_of(vertices.begin(), vertices.end(), [&](int v) { return corner_of(tet, v) >= 0; });
}

// All tets that contain the target's vertices: found by walking across the faces that contain them.
std::vector<int> star_of(const FieldMesh& mesh, const SplitTarget& target) {
  std::vector<int> star = {target.tet};
  for (std::size_t i = 0; i < star.size(); ++i) {
    for (int corner = 0; corner < 4; ++corner) {
      const int twin = at(mesh.twin, 4 * star[i] + corner);
      if (twin < 0 || !has_vertices(at(mesh.tets, twin / 4), target.vertices)) continue;
      if (std::find(star.begin(), star.end(), twin / 4) == star.end()) star.push_back(twin / 4);
    }
  }
  return star;
}

struct Refinement {
  std::vector<Tet> tets;
  std::vector<int> parent;
};

// The tet, or its children around the new vertex: one for each split corner, which the new vertex replaces.
void append_children(const Tet& tet, int index, const SplitTarget* target, int new_vertex,
                     Refinement& refined) {
  if (target == nullptr) {
    refined.tets.push_back(tet);
    refined.parent.push_back(index);
    return;
  }
  for (const int vertex : target->vertices) {
    Tet child = tet;
    at(child, corner_of(tet, vertex)) = new_vertex;
    refined.tets.push_back(child);
    refined.parent.push_back(index);
  }
}

// Children of one tet match by the identity, children of neighbours as their parents did.
std::vector<OctahedralRotation> inherited_matchings(const FieldMesh& mesh, const Refinement& refined,
                                                    const std::vector<int>& twin) {
  std::vector<OctahedralRotation> matchings(twin.size());
  for (std::size_t h = 0; h < twin.size(); ++h) {
    if (twin[h] < 0) continue;
    const int from = refined.parent[h / 4];
    const int to = at(refined.parent, twin[h] / 4);
    for (int corner = 0; corner < 4 && from != to; ++corner) {
      const int across = at(mesh.twin, 4 * from + corner);
      if (across >= 0 && across / 4 == to) matchings[h] = at(mesh.matchings, 4 * from + corner);
    }
  }
  return matchings;
}

void split_feature(std::vector<EdgeKey>& features, const std::vector<int>& vertices, int new_vertex) {
  if (vertices.size() != 2) return;
  const auto found = std::lower_bound(features.begin(), features.end(), edge_key(vertices[0], vertices[1]));
  if (found == features.end() || *found != edge_key(vertices[0], vertices[1])) return;
  features.erase(found);
  for (const int end : vertices) {
    const EdgeKey half = edge_key(end, new_vertex);
    features.insert(std::lower_bound(features.begin(), features.end(), half), half);
  }
}

Eigen::Vector3d centroid(const FieldMesh& mesh, const std::vector<int>& vertices) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const int vertex : vertices) sum += at(mesh.points, vertex);
  return sum / static_cast<double>(vertices.size());
}

}  // namespace

int split_independent(FieldMesh& mesh, const std::vector<SplitTarget>& targets) {
  std::vector<const SplitTarget*> target_of(mesh.tets.size(), nullptr);
  std::vector<int> new_vertex(mesh.tets.size(), -1);
  int split_count = 0;
  for (const SplitTarget& target : targets) {
    const std::vector<int> star = star_of(mesh, target);
    if (std::any_of(star.begin(), star.end(), [&](int t) { return at(target_of, t) != nullptr; })) continue;
    for (const int tet : star) {
      at(target_of, tet) = &target;
      at(new_vertex, tet) = mesh.point_count();
    }
    split_feature(mesh.features, target.vertices, mesh.point_count());
    mesh.points.push_back(centroid(mesh, target.vertices));
    ++split_count;
  }
  if (split_count == 0) return 0;
  Refinement refined;
  for (int t = 0; t < mesh.tet_count(); ++t) {
    append_children(at(mesh.tets, t), t, at(target_of, t), at(new_vertex, t), refined);
  }
  std::vector<int> twin = half_face_twins(refined.tets, mesh.points.size());
  mesh.matchings = inherited_matchings(mesh, refined, twin);
  mesh.twin = std::move(twin);
  std::vector<Eigen::Matrix3d> frames;
  for (const int parent : refined.parent) frames.push_back(at(mesh.frames, parent));
  mesh.frames = std::move(frames);
  mesh.tets = std::move(refined.tets);
  return split_count;
}

}  // namespace neurframe
