#include "cubecover/singular_graph.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace neurframe {

namespace {

Eigen::Vector3d edge_direction(const FieldMesh& mesh, const EdgeKey& edge) {
  return (at(mesh.points, edge[1]) - at(mesh.points, edge[0])).normalized();
}

// How far the frames turn once round the edge, about the edge's direction, in quarter turns: the sum of the
// small rotations between neighbours.  It tells valence 2 from valence 6, which have the same holonomy.
double field_turning(const FieldMesh& mesh, std::span<const int> ring, const Eigen::Vector3d& direction) {
  double turning = 0;
  for (const int h : ring) {
    const Eigen::Matrix3d& from = at(mesh.frames, h / 4);
    const Eigen::Matrix3d& to = at(mesh.frames, at(mesh.twin, h) / 4);
    const Eigen::AngleAxisd small(to * to_matrix(at(mesh.matchings, h)) * from.transpose());
    turning += small.angle() * small.axis().dot(direction);
  }
  return turning / (std::numbers::pi / 2);
}

// u -> H u turns by (4 - valence) quarter turns counter-clockwise about the image of the edge.
int valence_of(const SingularEdge& edge, double turning) {
  if (edge.axis < 0) return 0;
  if (edge.holonomy.kind() == RotationKind::half_turn) return turning > 0 ? 2 : 6;
  return edge.holonomy.quarter_turn_sign() * edge.orientation > 0 ? 3 : 5;
}

SingularEdge make_singular_edge(const FieldMesh& mesh, const EdgeRings& rings, int ring) {
  const std::span<const int> walk = rings.ring(static_cast<std::size_t>(ring));
  SingularEdge edge{at(rings.vertices, ring), ring, walk.front() / 4, holonomy(mesh, walk), -1, 1, 0, 0.0};
  const Eigen::Vector3d direction = edge_direction(mesh, edge.vertices);
  edge.axis = edge.holonomy.fixed_axis();
  if (edge.axis >= 0) {
    const double cosine = at(mesh.frames, edge.tet).col(edge.axis).dot(direction);
    edge.orientation = cosine < 0 ? -1 : 1;
    edge.off_axis_deg = std::acos(std::min(1.0, std::abs(cosine))) * 180 / std::numbers::pi;
  }
  edge.valence = valence_of(edge, field_turning(mesh, walk, direction));
  return edge;
}

class ArcTracer {
 public:
  ArcTracer(SingularGraph& graph, const std::vector<char>& on_boundary)
      : graph_(graph), on_boundary_(on_boundary), used_(graph.edges.size(), 0) {}

  void trace_all() {
    for (int e = 0; e < static_cast<int>(graph_.edges.size()); ++e) {
      for (const int end : at(graph_.edges, e).vertices) {
        if (ends_arc(end) && !at(used_, e)) trace(e, end);
      }
    }
    for (int e = 0; e < static_cast<int>(graph_.edges.size()); ++e) {
      if (!at(used_, e)) trace(e, at(graph_.edges, e).vertices[0]);  // loops
    }
  }

 private:
  bool ends_arc(int vertex) const {
    return at(on_boundary_, vertex) || at(graph_.edges_of_vertex, vertex).size() != 2;
  }

  void trace(int edge, int start) {
    SingularArc arc{{}, {start}, at(graph_.edges, edge).valence};
    while (edge >= 0 && !at(used_, edge)) {
      at(used_, edge) = 1;
      arc.edges.push_back(edge);
      const EdgeKey& ends = at(graph_.edges, edge).vertices;
      const int next = ends[0] == arc.vertices.back() ? ends[1] : ends[0];
      arc.vertices.push_back(next);
      if (ends_arc(next)) break;
      const std::vector<int>& around = at(graph_.edges_of_vertex, next);
      edge = around[0] == edge ? around[1] : around[0];
    }
    graph_.arcs.push_back(std::move(arc));
  }

  SingularGraph& graph_;
  const std::vector<char>& on_boundary_;
  std::vector<char> used_;
};

}  // namespace

SignedAxis axis_at(const SingularEdge& edge, int vertex, bool towards) {
  const bool edge_ends_here = edge.vertices[1] == vertex;
  return {edge.axis, edge_ends_here == towards ? edge.orientation : -edge.orientation};
}

SingularGraph find_singular_graph(const FieldMesh& mesh, const EdgeRings& rings) {
  SingularGraph graph;
  graph.edges_of_vertex.resize(mesh.points.size());
  for (int e = 0; e < static_cast<int>(rings.vertices.size()); ++e) {
    if (at(rings.on_boundary, e) || holonomy(mesh, rings.ring(static_cast<std::size_t>(e))).is_identity())
      continue;
    for (const int end : at(rings.vertices, e)) {
      at(graph.edges_of_vertex, end).push_back(static_cast<int>(graph.edges.size()));
    }
    graph.edges.push_back(make_singular_edge(mesh, rings, e));
  }
  const std::vector<char> on_boundary = boundary_vertices(mesh);
  for (int v = 0; v < mesh.point_count(); ++v) {
    const std::size_t degree = at(graph.edges_of_vertex, v).size();
    if (!at(on_boundary, v) && degree != 0 && degree != 2) graph.nodes.push_back(v);
  }
  ArcTracer(graph, on_boundary).trace_all();
  return graph;
}

}  // namespace neurframe
