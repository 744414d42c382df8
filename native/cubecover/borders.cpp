#include "cubecover/borders.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace neurframe {

namespace {

constexpr double least_bend_of_mean_edge = 0.35;  // 20 degrees

// Signed angle between the outward normals times the length.
double bend_at(const FieldMesh& mesh, const BoundaryEdge& edge) {
  const Eigen::Vector3d along = at(mesh.points, edge.vertices[1]) - at(mesh.points, edge.vertices[0]);
  const Eigen::Vector3d begin = area_vector(mesh, edge.begin_face).normalized();
  const Eigen::Vector3d end = area_vector(mesh, edge.end_face).normalized();
  return -std::atan2(begin.cross(end).dot(along.normalized()), begin.dot(end)) * along.norm();
}

class BorderTracer {
 public:
  BorderTracer(const FieldMesh& mesh, const std::vector<BoundaryEdge>& edges,
               const std::vector<SignedAxis>& labels)
      : mesh_(mesh), edges_(edges), labels_(labels), used_(edges.size(), 0) {
    for (int e = 0; e < static_cast<int>(edges.size()); ++e) {
      const BoundaryEdge& edge = at(edges, e);
      if (at(labels_, edge.begin_face) == at(labels_, edge.end_face)) continue;
      for (const int v : edge.vertices) edges_of_vertex_[v].push_back(e);
    }
  }

  std::vector<Border> trace_all() {
    std::vector<Border> borders;
    for (const auto& [vertex, around] : edges_of_vertex_) {
      if (around.size() == 2) continue;
      for (const int e : around) {
        if (!at(used_, e)) borders.push_back(trace(vertex, e));
      }
    }
    return borders;
  }

 private:
  // From a corner along the border to the next corner.
  Border trace(int vertex, int e) {
    Border steps;
    const SignedAxis first_side = at(labels_, at(edges_, e).begin_face);
    while (true) {
      at(used_, e) = 1;
      const BoundaryEdge& edge = at(edges_, e);
      steps.push_back({e, at(labels_, edge.begin_face) == first_side, bend_at(mesh_, edge)});
      vertex = edge.vertices[0] == vertex ? edge.vertices[1] : edge.vertices[0];
      const std::vector<int>& around = edges_of_vertex_.at(vertex);
      if (around.size() != 2) return steps;
      e = around[0] == e ? around[1] : around[0];
      if (at(used_, e)) return steps;
    }
  }

  const FieldMesh& mesh_;
  const std::vector<BoundaryEdge>& edges_;
  const std::vector<SignedAxis>& labels_;
  std::vector<char> used_;
  std::map<int, std::vector<int>> edges_of_vertex_;
};

}  // namespace

std::vector<Border> find_borders(const FieldMesh& mesh, const std::vector<BoundaryEdge>& edges,
                                 const std::vector<SignedAxis>& labels) {
  return BorderTracer(mesh, edges, labels).trace_all();
}

double least_bend(const FieldMesh& mesh, const std::vector<BoundaryEdge>& edges) {
  double length = 0;
  for (const BoundaryEdge& edge : edges) length += edge_length(mesh, edge.vertices);
  return least_bend_of_mean_edge * length / static_cast<double>(std::max<std::size_t>(1, edges.size()));
}

double bend_of(const Border& border) {
  double sum = 0;
  for (const BorderStep& step : border) sum += step.bend;
  return sum;
}

}  // namespace neurframe
