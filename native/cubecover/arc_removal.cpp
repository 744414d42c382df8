#include "cubecover/arc_removal.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "cubecover/boundary_axes.hpp"

namespace neurframe {

namespace {

constexpr double widening = 0.75;  // of the ball round the arc, in lengths of its longest edge
constexpr int unknown = std::numeric_limits<int>::max();

// How often every face turns: a cochain on the dual graph whose sum round every edge is zero, but for the
// arc's.
class TurnSurface {
 public:
  TurnSurface(FieldMesh& mesh, const EdgeRings& rings, const SingularGraph& graph, const SingularArc& arc)
      : mesh_(mesh),
        rings_(rings),
        graph_(graph),
        arc_(arc),
        inside_(mesh.tets.size(), 0),
        turn_(mesh.tets.size()),
        times_(mesh.twin.size(), 0) {}

  std::vector<int> remove() {
    choose_tets();
    if (!carry_turn()) return {};
    fix_charts();
    demand_sums();
    if (!propagate()) return {};
    return change_matchings();
  }

 private:
  // The tets in a ball round the arc, without those at other singular lines.
  void choose_tets() {
    Eigen::AlignedBox3d box;
    double longest = 0;
    std::vector<char> other(mesh_.points.size(), 0);
    for (const SingularEdge& edge : graph_.edges)
      at(other, edge.vertices[0]) = at(other, edge.vertices[1]) = 1;
    for (const int v : arc_.vertices) {
      box.extend(at(mesh_.points, v));
      at(other, v) = 0;
    }
    for (const int e : arc_.edges)
      longest = std::max(longest, edge_length(mesh_, at(graph_.edges, e).vertices));
    const double radius = box.diagonal().norm() / 2 + widening * longest;
    for (int t = 0; t < mesh_.tet_count(); ++t) {
      const Tet& corners = at(mesh_.tets, t);
      at(inside_, t) = (tet_center(mesh_, t) - box.center()).norm() < radius &&
                       std::none_of(corners.begin(), corners.end(), [&](int v) { return at(other, v); });
    }
  }

  // The arc's turn in the chart of every tet inside; false where it is not the same on all ways there.
  bool carry_turn() {
    const SingularEdge& first = at(graph_.edges, arc_.edges.front());
    std::vector<int> queue = {first.tet};
    if (!at(inside_, first.tet)) return false;
    at(turn_, first.tet) = first.holonomy;
    for (std::size_t i = 0; i < queue.size(); ++i) {
      for (int h = 4 * queue[i]; h < 4 * queue[i] + 4; ++h) {
        const int twin = at(mesh_.twin, h);
        if (twin < 0 || !at(inside_, twin / 4)) continue;
        const OctahedralRotation across = at(mesh_.matchings, h);
        const OctahedralRotation turn = across * at(turn_, queue[i]) * across.inverse();
        if (at(turn_, twin / 4).is_identity()) {
          at(turn_, twin / 4) = turn;
          queue.push_back(twin / 4);
        } else if (!(at(turn_, twin / 4) == turn)) {
          return false;
        }
      }
    }
    for (int t = 0; t < mesh_.tet_count(); ++t)
      at(inside_, t) = at(inside_, t) && !at(turn_, t).is_identity();
    return true;
  }

  // Up to a change of charts the faces of a spanning tree of the dual graph, all outside being its root, do
  // not turn.
  void fix_charts() {
    std::vector<int> queue;
    std::vector<char> met(mesh_.tets.size(), 0);
    for (int t = 0; t < mesh_.tet_count(); ++t) {
      if (at(inside_, t)) continue;
      at(met, t) = 1;
      queue.push_back(t);
    }
    for (int t = 0; t < mesh_.tet_count(); ++t) {
      for (int h = 4 * t; h < 4 * t + 4; ++h)
        if (at(inside_, t) && at(mesh_.twin, h) >= 0) at(times_, h) = at(times_, at(mesh_.twin, h)) = unknown;
    }
    if (queue.empty()) queue.push_back(0), met[0] = 1;
    for (std::size_t i = 0; i < queue.size(); ++i) {
      for (int h = 4 * queue[i]; h < 4 * queue[i] + 4; ++h) {
        const int twin = at(mesh_.twin, h);
        if (twin < 0 || at(met, twin / 4)) continue;
        at(met, twin / 4) = 1;
        at(times_, h) = at(times_, twin) = 0;
        queue.push_back(twin / 4);
      }
    }
  }

  int first_inside(std::span<const int> ring) const {
    const auto found = std::find_if(ring.begin(), ring.end(), [&](int h) { return at(inside_, h / 4); });
    return found == ring.end() ? -1 : *found / 4;
  }

  // What the sum round each edge has to be; unknown where the surface may end, on the boundary whose normal
  // is the axis.
  void demand_sums() {
    sum_.assign(rings_.vertices.size(), 0);
    for (const int e : arc_.edges) {
      const SingularEdge& edge = at(graph_.edges, e);
      at(sum_, edge.ring) = edge.holonomy == at(turn_, edge.tet) ? -1 : 1;
    }
    const std::vector<BoundaryEdge> edges = find_boundary_edges(mesh_, rings_);
    const std::vector<SignedAxis> axes = boundary_axes(mesh_, edges);
    for (const BoundaryEdge& edge : edges) {
      const OctahedralRotation turn = at(turn_, edge.begin_face / 4);
      if (!at(inside_, edge.begin_face / 4) ||
          is_feature(mesh_, edge_key(edge.vertices[0], edge.vertices[1])))
        continue;
      if (turn.fixed_axis() == at(axes, edge.begin_face).axis) at(sum_, edge.ring) = unknown;
    }
  }

  bool propagate() {
    std::vector<int> queue;
    for (int e = 0; e < static_cast<int>(rings_.vertices.size()); ++e) {
      if (first_inside(rings_.ring(static_cast<std::size_t>(e))) >= 0) queue.push_back(e);
    }
    for (bool changed = true; changed;) {
      changed = false;
      for (const int e : queue) changed = solve_at(e) || changed;
    }
    return std::all_of(queue.begin(), queue.end(), [&](int e) { return is_solved(e); });
  }

  // The half-faces that a walk round the edge crosses.
  std::span<const int> crossed(int edge) const {
    const std::span<const int> ring = rings_.ring(static_cast<std::size_t>(edge));
    return at(rings_.on_boundary, edge) ? ring.first(ring.size() - 1) : ring;
  }

  bool solve_at(int edge) {
    if (at(sum_, edge) == unknown) return false;
    int rest = at(sum_, edge);
    int open = -1;
    for (const int h : crossed(edge)) {
      if (at(times_, h) != unknown) {
        rest -= at(times_, h);
      } else if (open >= 0) {
        return false;
      } else {
        open = h;
      }
    }
    if (open < 0) return false;
    at(times_, open) = rest;
    at(times_, at(mesh_.twin, open)) = -rest;
    return true;
  }

  bool is_solved(int edge) const {
    int sum = 0;
    for (const int h : crossed(edge)) {
      if (at(times_, h) == unknown) return false;
      sum += at(times_, h);
    }
    return at(sum_, edge) == unknown || sum == at(sum_, edge);
  }

  std::vector<int> change_matchings() {
    std::vector<int> changed;
    for (int h = 0; h < mesh_.half_face_count(); ++h) {
      if (at(mesh_.twin, h) < h || at(times_, h) == 0) continue;
      const int from = at(inside_, h / 4) ? h : at(mesh_.twin, h);
      OctahedralRotation turn;
      for (int k = 0; k < std::abs(at(times_, from)); ++k) turn = turn * at(turn_, from / 4);
      set_matching(mesh_, from, at(mesh_.matchings, from) * (at(times_, from) < 0 ? turn.inverse() : turn));
      changed.push_back(h);
    }
    return changed;
  }

  FieldMesh& mesh_;
  const EdgeRings& rings_;
  const SingularGraph& graph_;
  const SingularArc& arc_;
  std::vector<char> inside_;              // per tet
  std::vector<OctahedralRotation> turn_;  // per tet inside
  std::vector<int> times_;                // per half-face; its twin's is the negative
  std::vector<int> sum_;                  // per edge
};

}  // namespace

std::vector<int> remove_arc(FieldMesh& mesh, const EdgeRings& rings, const SingularGraph& graph,
                            const SingularArc& arc) {
  return TurnSurface(mesh, rings, graph, arc).remove();
}

}  // namespace neurframe
