#include "cubecover/arc_orientation.hpp"

#include <algorithm>
#include <cmath>

#include "cubecover/vertex_star.hpp"

namespace neurframe {

namespace {

constexpr double turn_cost = 0.5;  // in mean edges of the arc that run backwards
constexpr double end_cost = 100;   // against the normal of the boundary

// A boundary face at every vertex where the boundary is smooth; -1 elsewhere.
std::vector<int> smooth_boundary_faces(const FieldMesh& mesh) {
  std::vector<int> face(mesh.points.size(), -1);
  for (int h = 0; h < mesh.half_face_count(); ++h) {
    if (at(mesh.twin, h) >= 0) continue;
    for (const int vertex : half_face_vertices(mesh.tets, h)) at(face, vertex) = h;
  }
  for (const auto& [a, b] : mesh.features) at(face, a) = at(face, b) = -1;
  return face;
}

class ArcOrientation {
 public:
  ArcOrientation(const FieldMesh& mesh, const std::vector<SignedAxis>& boundary_axis,
                 const std::vector<int>& boundary_face, SingularGraph& graph, const SingularArc& arc)
      : mesh_(mesh), boundary_axis_(boundary_axis), boundary_face_(boundary_face), graph_(graph), arc_(arc) {}

  void decide() {
    follow_axis();
    const std::vector<int> forward = cheapest_run();
    for (std::size_t i = 0; i < arc_.edges.size(); ++i) {
      SingularEdge& edge = at(graph_.edges, arc_.edges[i]);
      const int along_arc = forward[i] * axis_[i].sign;  // of the axis of the edge's own chart
      orient(edge, edge.vertices[0] == arc_.vertices[i] ? along_arc : -along_arc);
    }
  }

 private:
  static void orient(SingularEdge& edge, int orientation) {
    if (edge.orientation == orientation) return;
    edge.orientation = orientation;
    edge.off_axis_deg = 180 - edge.off_axis_deg;
    if (edge.holonomy.kind() == RotationKind::quarter_turn) edge.valence = 8 - edge.valence;
  }

  // One axis along the whole arc, in the chart of each edge, and how far the edges run along it.
  void follow_axis() {
    for (std::size_t i = 0; i < arc_.edges.size(); ++i) {
      const SingularEdge& edge = at(graph_.edges, arc_.edges[i]);
      axis_.push_back({edge.axis, 1});
      if (i > 0) {
        const SingularEdge& before = at(graph_.edges, arc_.edges[i - 1]);
        axis_[i] = carried(transport_in_star(mesh_, arc_.vertices[i], before.tet, edge.tet), axis_[i - 1]);
      }
      const Eigen::Vector3d way = at(mesh_.points, arc_.vertices[i + 1]) - at(mesh_.points, arc_.vertices[i]);
      length_.push_back(way.dot(direction_of(at(mesh_.frames, edge.tet), axis_[i])));
      mean_length_ += way.norm() / static_cast<double>(arc_.edges.size());
    }
  }

  // +1 where the arc's axis points out of the smooth boundary at its end, -1 into it, 0 for all other ends.
  int outwards(int vertex, std::size_t edge) const {
    const int face = at(boundary_face_, vertex);
    if (face < 0) return 0;
    const int tet = at(graph_.edges, arc_.edges[edge]).tet;
    const SignedAxis normal =
        carried(transport_in_star(mesh_, vertex, face / 4, tet), at(boundary_axis_, face));
    return normal.axis == axis_[edge].axis ? normal.sign * axis_[edge].sign : 0;
  }

  // Of the arc's first edges up to number i, the last of which runs along its axis (1) or against it (0).
  double edge_cost(std::size_t i, int forward) const {
    const int sign = forward == 1 ? 1 : -1;
    double cost = std::max(0.0, -sign * length_[i]) / mean_length_;
    if (i == 0 && outwards(arc_.vertices.front(), i) == sign) cost += end_cost;
    if (i + 1 == arc_.edges.size() && outwards(arc_.vertices.back(), i) == -sign) cost += end_cost;
    return cost;
  }

  std::vector<int> cheapest_run() const {
    const std::size_t count = arc_.edges.size();
    std::vector<std::array<double, 2>> cost(count);
    std::vector<std::array<int, 2>> before(count);
    for (std::size_t i = 0; i < count; ++i) {
      for (const int forward : {0, 1}) {
        const auto f = static_cast<std::size_t>(forward);
        cost[i][f] = edge_cost(i, forward);
        if (i == 0) continue;
        const bool turns = cost[i - 1][1 - f] + turn_cost < cost[i - 1][f];
        before[i][f] = turns ? 1 - forward : forward;
        cost[i][f] += turns ? cost[i - 1][1 - f] + turn_cost : cost[i - 1][f];
      }
    }
    std::vector<int> run(count);
    int forward = cost.back()[1] <= cost.back()[0] ? 1 : 0;
    for (std::size_t i = count; i-- > 0;) {
      run[i] = forward == 1 ? 1 : -1;
      forward = before[i][static_cast<std::size_t>(forward)];
    }
    return run;
  }

  const FieldMesh& mesh_;
  const std::vector<SignedAxis>& boundary_axis_;
  const std::vector<int>& boundary_face_;
  SingularGraph& graph_;
  const SingularArc& arc_;
  std::vector<SignedAxis> axis_;  // per edge of the arc
  std::vector<double> length_;
  double mean_length_ = 0;
};

bool has_axes(const SingularGraph& graph, const SingularArc& arc) {
  return std::all_of(arc.edges.begin(), arc.edges.end(),
                     [&](int edge) { return at(graph.edges, edge).axis >= 0; });
}

}  // namespace

void orient_arcs(const FieldMesh& mesh, const std::vector<SignedAxis>& boundary_axis, SingularGraph& graph) {
  const std::vector<int> boundary_face = smooth_boundary_faces(mesh);
  for (SingularArc& arc : graph.arcs) {
    if (!has_axes(graph, arc)) continue;
    ArcOrientation(mesh, boundary_axis, boundary_face, graph, arc).decide();
    arc.valence = at(graph.edges, arc.edges.front()).valence;
  }
}

SingularGraph oriented_singular_graph(const FieldMesh& mesh, const EdgeRings& rings) {
  SingularGraph graph = find_singular_graph(mesh, rings);
  orient_arcs(mesh, boundary_axes(mesh, find_boundary_edges(mesh, rings)), graph);
  return graph;
}

}  // namespace neurframe
