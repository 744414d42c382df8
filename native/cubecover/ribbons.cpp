#include "cubecover/ribbons.hpp"

#include <algorithm>
#include <limits>
#include <queue>
#include <set>

#include "cubecover/arc_orientation.hpp"
#include "cubecover/vertex_star.hpp"

namespace neurframe {

namespace {

constexpr double off_axis_cost = 3;  // of a line's length times (1 - cosine)
constexpr double rung_cost = 0.3;    // of the ribbon's width: it is to be narrow
constexpr double normal_cosine = 0.8;
constexpr std::size_t turn_edges = 2;  // on either side of a turning point

// An edge of an arc near a turning point, and the axis in the direction in which the turn points.
struct Turn {
  int ring;
  int tet;
  SignedAxis outwards;
};

// Rungs are edges between the two sides of a ribbon; a step crosses a face to the next rung and adds an edge
// to one side.
class RibbonSearch {
 public:
  RibbonSearch(const FieldMesh& mesh, const EdgeRings& rings, const SingularGraph& graph)
      : mesh_(mesh),
        rings_(rings),
        on_boundary_(boundary_vertices(mesh)),
        taken_(mesh.points.size(), 0),
        on_feature_(mesh.points.size(), 0) {
    for (const auto& [a, b] : mesh.features) at(on_feature_, a) = at(on_feature_, b) = 1;
    for (const SingularEdge& edge : graph.edges)
      at(taken_, edge.vertices[0]) = at(taken_, edge.vertices[1]) = 1;
  }

  Ribbon cheapest(const Turn& turn) {
    reached_.assign(rings_.vertices.size(), {});
    at(reached_, turn.ring) = {0, -1, -1, turn.tet, turn.outwards};
    front_ = {};
    front_.push({0, turn.ring});
    while (!front_.empty()) {
      const auto [cost, rung] = front_.top();
      front_.pop();
      if (cost > at(reached_, rung).cost) continue;
      if (at(rings_.on_boundary, rung)) return ribbon_to(rung);
      step_from(rung);
    }
    return {};
  }

 private:
  struct Reached {
    double cost = std::numeric_limits<double>::infinity();
    int before = -1;     // the rung
    int half_face = -1;  // between that one and this
    int tet = -1;
    SignedAxis axis = {};  // along the ribbon, in the chart of the tet
  };
  using Front = std::pair<double, int>;

  void step_from(int rung) {
    const std::span<const int> ring = rings_.ring(static_cast<std::size_t>(rung));
    const Reached here = at(reached_, rung);
    const auto begin = std::find_if(ring.begin(), ring.end(), [&](int h) { return h / 4 == here.tet; });
    SignedAxis axis = here.axis;
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const std::size_t offset = static_cast<std::size_t>(begin - ring.begin()) + i;
      const int h = ring[offset % ring.size()];
      for (const bool first : {true, false}) step_across(rung, h, axis, first);
      axis = carried(at(mesh_.matchings, h), axis);
    }
  }

  // The next rung has one of the two ends of this one, and the face's third vertex.
  void step_across(int rung, int half_face, SignedAxis axis, bool keeps_first) {
    const EdgeKey& ends = at(rings_.vertices, rung);
    const int kept = keeps_first ? ends[0] : ends[1];
    const int left = keeps_first ? ends[1] : ends[0];
    const int next = third_vertex(mesh_, half_face, kept, left);
    if (at(taken_, next) || at(on_boundary_, left)) return;
    const int next_rung = ring_of(mesh_, rings_, half_face / 4, kept, next);
    const Eigen::Vector3d along = direction_of(at(mesh_.frames, half_face / 4), axis);
    if (at(on_boundary_, next) && (at(on_feature_, next) || !is_normal_at(next, along))) return;
    const Eigen::Vector3d side = at(mesh_.points, next) - at(mesh_.points, left);
    const double cost = at(reached_, rung).cost + side.norm() +
                        off_axis_cost * (side.norm() - side.dot(along)) +
                        rung_cost * (at(mesh_.points, next) - at(mesh_.points, kept)).norm();
    if (cost >= at(reached_, next_rung).cost) return;
    at(reached_, next_rung) = {cost, rung, half_face, half_face / 4, axis};
    front_.push({cost, next_rung});
  }

  bool is_normal_at(int vertex, const Eigen::Vector3d& direction) {
    if (normal_.empty()) {
      normal_.assign(mesh_.points.size(), Eigen::Vector3d::Zero());
      for (int h = 0; h < mesh_.half_face_count(); ++h) {
        if (at(mesh_.twin, h) >= 0) continue;
        for (const int v : half_face_vertices(mesh_.tets, h)) at(normal_, v) += area_vector(mesh_, h);
      }
    }
    return at(normal_, vertex).normalized().dot(direction) > normal_cosine;
  }

  // Empty where a side meets itself or the other one.
  Ribbon ribbon_to(int rung) const {
    Ribbon ribbon;
    std::set<int> met;
    for (; at(reached_, rung).before >= 0; rung = at(reached_, rung).before) {
      const Reached& step = at(reached_, rung);
      const EdgeKey& before = at(rings_.vertices, step.before);
      for (const int vertex : at(rings_.vertices, rung)) {
        if (vertex != before[0] && vertex != before[1] && !met.insert(vertex).second) return {};
      }
      ribbon.push_back({step.half_face, step.before});
    }
    std::reverse(ribbon.begin(), ribbon.end());
    return ribbon;
  }

  const FieldMesh& mesh_;
  const EdgeRings& rings_;
  std::vector<char> on_boundary_;
  std::vector<char> taken_;  // vertices on singular edges
  std::vector<char> on_feature_;
  std::vector<Eigen::Vector3d> normal_;
  std::vector<Reached> reached_;  // per rung
  std::priority_queue<Front, std::vector<Front>, std::greater<>> front_;
};

// The edges of an arc next to its vertex number i, where it turns.
void add_turns(const FieldMesh& mesh, const SingularGraph& graph, const SingularArc& arc, std::size_t i,
               std::vector<Turn>& turns) {
  const auto edge_at = [&](std::size_t k) -> const SingularEdge& { return at(graph.edges, arc.edges[k]); };
  const SingularEdge& arriving = edge_at(i - 1);
  const int towards = arriving.vertices[1] == arc.vertices[i] ? arriving.orientation : -arriving.orientation;
  SignedAxis backward{arriving.axis, towards};
  SignedAxis forward =
      carried(transport_in_star(mesh, arc.vertices[i], arriving.tet, edge_at(i).tet), backward);
  for (std::size_t k = 0; k < turn_edges && i + k < arc.edges.size(); ++k) {
    if (k > 0)
      forward = carried(
          transport_in_star(mesh, arc.vertices[i + k], edge_at(i + k - 1).tet, edge_at(i + k).tet), forward);
    turns.push_back({edge_at(i + k).ring, edge_at(i + k).tet, forward});
  }
  for (std::size_t k = 0; k < turn_edges && k < i; ++k) {
    if (k > 0)
      backward = carried(
          transport_in_star(mesh, arc.vertices[i - k], edge_at(i - k).tet, edge_at(i - k - 1).tet), backward);
    turns.push_back({edge_at(i - k - 1).ring, edge_at(i - k - 1).tet, backward});
  }
}

bool turns_at(const SingularGraph& graph, const SingularArc& arc, std::size_t i) {
  const SingularEdge& before = at(graph.edges, arc.edges[i - 1]);
  const SingularEdge& after = at(graph.edges, arc.edges[i]);
  return before.valence != after.valence && before.axis >= 0 && after.axis >= 0;
}

}  // namespace

std::vector<Ribbon> unzipping_ribbons(const FieldMesh& mesh, const EdgeRings& rings) {
  const SingularGraph graph = oriented_singular_graph(mesh, rings);
  std::vector<Turn> turns;
  for (const SingularArc& arc : graph.arcs) {
    for (std::size_t i = 1; i < arc.edges.size(); ++i) {
      if (turns_at(graph, arc, i)) add_turns(mesh, graph, arc, i, turns);
    }
  }
  std::vector<Ribbon> ribbons;
  RibbonSearch search(mesh, rings, graph);
  for (const Turn& turn : turns) {
    Ribbon ribbon = search.cheapest(turn);
    if (!ribbon.empty()) ribbons.push_back(std::move(ribbon));
  }
  return ribbons;
}

}  // namespace neurframe
