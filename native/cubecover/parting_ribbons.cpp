#include "cubecover/parting_ribbons.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <queue>

namespace neurframe {

namespace {

constexpr double widest_fan = 1.25 * std::numbers::pi;

struct Fan {
  double angle;
  Ribbon moves;
};

// Paths in the link of a vertex, whose steps are faces at it.
class FanSearch {
 public:
  FanSearch(const FieldMesh& mesh, const EdgeRings& rings, const SingularGraph& graph)
      : mesh_(mesh),
        rings_(rings),
        graph_(graph),
        on_boundary_(boundary_vertices(mesh)),
        is_taken_(rings.on_boundary) {
    for (const SingularEdge& edge : graph.edges) at(is_taken_, edge.ring) = 1;
  }

  void add_fans(int node, std::vector<Fan>& found) {
    node_ = node;
    const std::vector<int>& around = at(graph_.edges_of_vertex, node);
    for (std::size_t i = 0; i < around.size(); ++i) {
      const SingularEdge& from = at(graph_.edges, around[i]);
      reach_from(from);
      for (std::size_t j = i + 1; j < around.size(); ++j) {
        const SingularEdge& to = at(graph_.edges, around[j]);
        if (to.valence != from.valence || !reached_.contains(other_end(to))) continue;
        Fan fan = fan_to(to);
        if (makes_regular(fan.moves, to)) found.push_back(std::move(fan));
      }
    }
  }

 private:
  struct Reached {
    double angle = 0;
    int before = -1;     // the vertex of the link
    int half_face = -1;  // between that one and this
    int ring = -1;       // of the edge to the node
  };
  using Front = std::pair<double, int>;

  int other_end(const SingularEdge& edge) const {
    return edge.vertices[0] == node_ ? edge.vertices[1] : edge.vertices[0];
  }

  double angle_between(int one, int other) const {
    const Eigen::Vector3d& center = at(mesh_.points, node_);
    const Eigen::Vector3d a = (at(mesh_.points, one) - center).normalized();
    const Eigen::Vector3d b = (at(mesh_.points, other) - center).normalized();
    return std::acos(std::clamp(a.dot(b), -1.0, 1.0));
  }

  void reach_from(const SingularEdge& edge) {
    const int start = other_end(edge);
    reached_ = {{start, {0, -1, -1, edge.ring}}};
    std::priority_queue<Front, std::vector<Front>, std::greater<>> front;
    front.push({0, start});
    while (!front.empty()) {
      const auto [angle, vertex] = front.top();
      front.pop();
      if (angle > reached_[vertex].angle) continue;
      // lines and the boundary are where a path ends, not where it goes on
      if (vertex != start && (at(on_boundary_, vertex) || !at(graph_.edges_of_vertex, vertex).empty()))
        continue;
      for (const int h : rings_.ring(static_cast<std::size_t>(reached_[vertex].ring))) step(vertex, h, front);
    }
  }

  template <class Queue>
  void step(int vertex, int half_face, Queue& front) {
    const int next = third_vertex(mesh_, half_face, node_, vertex);
    if (at(is_taken_, ring_of(mesh_, rings_, half_face / 4, vertex, next))) return;
    const double angle = reached_[vertex].angle + angle_between(vertex, next);
    if (angle > widest_fan) return;
    const auto [found, is_new] = reached_.try_emplace(next);
    if (!is_new && angle >= found->second.angle) return;
    found->second = {angle, vertex, half_face, ring_of(mesh_, rings_, half_face / 4, node_, next)};
    front.push({angle, next});
  }

  Fan fan_to(const SingularEdge& edge) {
    int vertex = other_end(edge);
    Fan fan{reached_[vertex].angle, {}};
    for (; reached_[vertex].before >= 0; vertex = reached_[vertex].before) {
      const Reached& here = reached_[vertex];
      fan.moves.push_back({here.half_face, reached_[here.before].ring});
    }
    std::reverse(fan.moves.begin(), fan.moves.end());
    return fan;
  }

  // Whether the moves, which end with a face at the edge, undo its turn.
  bool makes_regular(const Ribbon& moves, const SingularEdge& edge) {
    std::vector<OctahedralRotation> before;
    for (const LineMove& move : moves) {
      before.push_back(at(mesh_.matchings, move.half_face));
      move_line(mesh_, rings_, move);
    }
    const bool regular = holonomy(mesh_, rings_.ring(static_cast<std::size_t>(edge.ring))).is_identity();
    for (std::size_t i = moves.size(); i-- > 0;) set_matching(mesh_, moves[i].half_face, before[i]);
    return regular;
  }

  FieldMesh mesh_;  // its matchings are changed and changed back
  const EdgeRings& rings_;
  const SingularGraph& graph_;
  std::vector<char> on_boundary_;
  std::vector<char> is_taken_;  // per ring: singular, or on the boundary
  int node_ = -1;
  std::map<int, Reached> reached_;  // by vertex of the link
};

}  // namespace

std::vector<Ribbon> parting_ribbons(const FieldMesh& mesh, const EdgeRings& rings, const SingularGraph& graph,
                                    const std::vector<int>& nodes) {
  if (nodes.empty()) return {};
  std::vector<Fan> fans;
  FanSearch search(mesh, rings, graph);
  for (const int node : nodes) search.add_fans(node, fans);
  std::stable_sort(fans.begin(), fans.end(), [](const Fan& a, const Fan& b) { return a.angle < b.angle; });
  std::vector<Ribbon> ribbons;
  for (Fan& fan : fans) ribbons.push_back(std::move(fan.moves));
  return ribbons;
}

}  // namespace neurframe
