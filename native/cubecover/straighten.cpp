#include "cubecover/straighten.hpp"

#include <algorithm>
#include <cmath>

#include "cubecover/boundary_axes.hpp"
#include "cubecover/matching.hpp"

namespace neurframe {

namespace {

// Costs per unit of length of a singular edge.
constexpr double off_axis_factor = 1.75;
constexpr double half_turn_cost = 2.5;  // dearer than two quarter turns side by side
constexpr double compound_cost = 9;
constexpr int most_straightenings = 50;

class Straightener {
 public:
  explicit Straightener(FieldMesh& mesh)
      : mesh_(mesh),
        rings_(edge_rings(mesh.tets, mesh.twin)),
        on_boundary_(boundary_vertices(mesh)),
        on_feature_(mesh.points.size(), 0),
        normal_(mesh.points.size(), Eigen::Vector3d::Zero()) {
    for (const auto& [a, b] : mesh.features) at(on_feature_, a) = at(on_feature_, b) = 1;
    for (int h = 0; h < mesh.half_face_count(); ++h) {
      if (at(mesh.twin, h) >= 0) continue;
      for (const int vertex : half_face_vertices(mesh.tets, h)) at(normal_, vertex) += area_vector(mesh, h);
    }
  }

  int run() {
    int total = 0;
    for (int pass = 0; pass < most_straightenings; ++pass) {
      const int changed = pass_over_faces();
      total += changed;
      if (changed == 0) break;
    }
    return total;
  }

 private:
  int pass_over_faces() {
    int changed = 0;
    for (int h = 0; h < mesh_.half_face_count(); ++h) {
      if (at(mesh_.twin, h) > h && is_free(h) && has_singular_edge(h)) changed += improve(h) ? 1 : 0;
    }
    return changed;
  }

  // None of its vertices is on the boundary, or one is, where the boundary is smooth.
  bool is_free(int half_face) const {
    int touching = 0;
    for (const int vertex : half_face_vertices(mesh_.tets, half_face)) {
      if (!at(on_boundary_, vertex)) continue;
      ++touching;
      if (at(on_feature_, vertex)) return false;
    }
    return touching <= 1;
  }

  // Whether a new matching keeps the axis that is normal to the boundary at the face's boundary vertex: a
  // singular line must go on leaving the boundary along the normal.
  bool keeps_normal(int half_face, OctahedralRotation before, OctahedralRotation after) const {
    for (const int vertex : half_face_vertices(mesh_.tets, half_face)) {
      if (!at(on_boundary_, vertex)) continue;
      SignedAxis normal;
      (at(mesh_.frames, half_face / 4).transpose() * at(normal_, vertex)).cwiseAbs().maxCoeff(&normal.axis);
      if (!(carried(before, normal) == carried(after, normal))) return false;
    }
    return true;
  }

  std::array<int, 3> edges_of(int half_face) const {
    const auto& corners = at(face_corners, half_face % 4);
    std::array<int, 3> edges{};
    for (std::size_t k = 0; k < 3; ++k) {
      edges[k] = at(at(rings_.edge_of_tet, half_face / 4), local_edge(corners[k], corners[(k + 1) % 3]));
    }
    return edges;
  }

  OctahedralRotation holonomy_of(int edge) const {
    return holonomy(mesh_, rings_.ring(static_cast<std::size_t>(edge)));
  }

  bool has_singular_edge(int half_face) const {
    const auto edges = edges_of(half_face);
    return std::any_of(edges.begin(), edges.end(), [&](int e) { return !holonomy_of(e).is_identity(); });
  }

  // Mean cosine between the edge and the holonomy's axis, over the tets of the ring.
  double alignment(int edge, SignedAxis axis) const {
    const EdgeKey& ends = at(rings_.vertices, edge);
    const Eigen::Vector3d direction = (at(mesh_.points, ends[1]) - at(mesh_.points, ends[0])).normalized();
    const std::span<const int> ring = rings_.ring(static_cast<std::size_t>(edge));
    double sum = 0;
    for (const int h : ring) {
      sum += direction_of(at(mesh_.frames, h / 4), axis).dot(direction);
      axis = carried(at(mesh_.matchings, h), axis);
    }
    return std::abs(sum) / static_cast<double>(ring.size());
  }

  double edge_cost(int edge) const {
    const OctahedralRotation turn = holonomy_of(edge);
    if (turn.is_identity()) return 0;
    const double length = edge_length(mesh_, at(rings_.vertices, edge));
    if (turn.kind() == RotationKind::compound) return compound_cost * length;
    const double cost = 1 + off_axis_factor * (1 - alignment(edge, {turn.fixed_axis(), 1}));
    return (turn.kind() == RotationKind::half_turn ? half_turn_cost : 1) * cost * length;
  }

  double cost(int half_face) const {
    const Eigen::Matrix3d& from = at(mesh_.frames, half_face / 4);
    const Eigen::Matrix3d& to = at(mesh_.frames, at(mesh_.twin, half_face) / 4);
    const double size = std::sqrt(area_vector(mesh_, half_face).norm());
    double sum = size * mismatch(from, to, at(mesh_.matchings, half_face));
    for (const int edge : edges_of(half_face)) sum += edge_cost(edge);
    return sum;
  }

  bool improve(int half_face) {
    const OctahedralRotation before = at(mesh_.matchings, half_face);
    OctahedralRotation best = before;
    double best_cost = cost(half_face) * (1 - 1e-9);  // only real gains, so that the passes end
    for (int i = 0; i < OctahedralRotation::count; ++i) {
      if (!keeps_normal(half_face, before, OctahedralRotation(i))) continue;
      set_matching(mesh_, half_face, OctahedralRotation(i));
      const double candidate = cost(half_face);
      if (candidate >= best_cost) continue;
      best = OctahedralRotation(i);
      best_cost = candidate;
    }
    set_matching(mesh_, half_face, best);
    return !(best == before);
  }

  FieldMesh& mesh_;
  EdgeRings rings_;
  std::vector<char> on_boundary_;
  std::vector<char> on_feature_;
  std::vector<Eigen::Vector3d> normal_;  // per vertex: sum of the area vectors of its boundary faces
};

}  // namespace

int straighten_singular_lines(FieldMesh& mesh) {
  return Straightener(mesh).run();
}

}  // namespace neurframe
