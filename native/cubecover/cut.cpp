#include "cubecover/cut.hpp"

#include <numeric>

#include "cubecover/matching.hpp"

namespace neurframe {

namespace {

struct SpanningForest {
  std::vector<OctahedralRotation> gauge;  // per tet: u_combed = gauge u
  std::vector<char> crossed;              // per half-face: on the forest
  std::vector<int> component;             // per tet
};

SpanningForest grow_forest(const FieldMesh& mesh) {
  SpanningForest forest{std::vector<OctahedralRotation>(mesh.tets.size()),
                        std::vector<char>(mesh.twin.size(), 0), std::vector<int>(mesh.tets.size(), -1)};
  std::vector<int> queue;
  int component_count = 0;
  for (int root = 0; root < mesh.tet_count(); ++root) {
    if (at(forest.component, root) >= 0) continue;
    at(forest.component, root) = component_count;
    queue.assign(1, root);
    for (std::size_t i = 0; i < queue.size(); ++i) {
      for (int h = 4 * queue[i]; h < 4 * queue[i] + 4; ++h) {
        const int twin = at(mesh.twin, h);
        if (twin < 0 || at(forest.component, twin / 4) >= 0) continue;
        at(forest.component, twin / 4) = component_count;
        at(forest.gauge, twin / 4) = at(forest.gauge, queue[i]) * at(mesh.matchings, h).inverse();
        at(forest.crossed, h) = at(forest.crossed, twin) = 1;
        queue.push_back(twin / 4);
      }
    }
    ++component_count;
  }
  return forest;
}

void change_charts(FieldMesh& mesh, const std::vector<OctahedralRotation>& gauge) {
  for (int h = 0; h < mesh.half_face_count(); ++h) {
    if (at(mesh.twin, h) < 0) continue;
    at(mesh.matchings, h) =
        at(gauge, at(mesh.twin, h) / 4) * at(mesh.matchings, h) * at(gauge, h / 4).inverse();
  }
  for (int t = 0; t < mesh.tet_count(); ++t) {
    at(mesh.frames, t) = at(mesh.frames, t) * to_matrix(at(gauge, t)).transpose();
  }
}

// Opens, one after the other, the only cut face of a regular interior edge: its transition must be the
// identity.
void open_forced_faces(const FieldMesh& mesh, std::vector<char>& cut) {
  const EdgeRings rings = edge_rings(mesh.tets, mesh.twin);
  std::vector<int> cut_faces(rings.vertices.size(), 0);
  std::vector<int> queue;
  for (int e = 0; e < static_cast<int>(rings.vertices.size()); ++e) {
    const std::span<const int> ring = rings.ring(static_cast<std::size_t>(e));
    for (const int h : ring) at(cut_faces, e) += at(cut, h);
    if (at(rings.on_boundary, e) || !holonomy(mesh, ring).is_identity()) at(cut_faces, e) = -1;
    if (at(cut_faces, e) == 1) queue.push_back(e);
  }
  for (std::size_t i = 0; i < queue.size(); ++i) {
    for (const int h : rings.ring(static_cast<std::size_t>(queue[i]))) {
      if (!at(cut, h)) continue;
      at(cut, h) = at(cut, at(mesh.twin, h)) = 0;
      for (const auto& [a, b] : tet_edges) {
        if (a == h % 4 || b == h % 4) continue;
        const int edge = at(at(rings.edge_of_tet, h / 4), local_edge(a, b));
        if (--at(cut_faces, edge) == 1) queue.push_back(edge);
      }
    }
  }
}

int find_root(std::vector<int>& parent, int item) {
  while (at(parent, item) != item) {
    at(parent, item) = at(parent, at(parent, item));
    item = at(parent, item);
  }
  return item;
}

}  // namespace

std::vector<char> comb_and_cut(FieldMesh& mesh) {
  const SpanningForest forest = grow_forest(mesh);
  change_charts(mesh, forest.gauge);
  std::vector<char> cut(mesh.twin.size(), 0);
  for (int h = 0; h < mesh.half_face_count(); ++h)
    at(cut, h) = at(mesh.twin, h) >= 0 && !at(forest.crossed, h);
  open_forced_faces(mesh, cut);
  return cut;
}

CornerClasses corner_classes(const FieldMesh& mesh, const std::vector<char>& cut) {
  std::vector<int> parent(4 * mesh.tets.size());
  std::iota(parent.begin(), parent.end(), 0);
  for (int h = 0; h < mesh.half_face_count(); ++h) {
    const int twin = at(mesh.twin, h);
    if (twin < h || at(cut, h)) continue;
    for (const int corner : at(face_corners, h % 4)) {
      const int opposite = corner_of(at(mesh.tets, twin / 4), at(at(mesh.tets, h / 4), corner));
      const int a = find_root(parent, 4 * (h / 4) + corner);
      const int b = find_root(parent, 4 * (twin / 4) + opposite);
      at(parent, std::max(a, b)) = std::min(a, b);
    }
  }
  CornerClasses classes;
  classes.of_corner.resize(mesh.tets.size());
  std::vector<int> number(parent.size(), -1);
  for (int c = 0; c < static_cast<int>(parent.size()); ++c) {
    int& of_root = at(number, find_root(parent, c));
    if (of_root < 0) {
      of_root = classes.count();
      classes.vertex.push_back(at(at(mesh.tets, c / 4), c % 4));
    }
    at(at(classes.of_corner, c / 4), c % 4) = of_root;
  }
  return classes;
}

std::vector<int> components(const FieldMesh& mesh) {
  return grow_forest(mesh).component;
}

}  // namespace neurframe
