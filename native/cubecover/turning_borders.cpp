#include "cubecover/turning_borders.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace neurframe {

namespace {

// A part of a border bends if it has this much of its bend times its length: 20 degrees over a mean edge.
constexpr double least_bend = 0.35;

struct Step {
  int edge;       // index of the boundary edge
  bool forwards;  // begin_face is on the first side
  double bend;    // radians, positive where convex, times the length
};

// Signed angle between the outward normals times the length.
double bend_of(const FieldMesh& mesh, const BoundaryEdge& edge) {
  const Eigen::Vector3d along = at(mesh.points, edge.vertices[1]) - at(mesh.points, edge.vertices[0]);
  const Eigen::Vector3d begin = area_vector(mesh, edge.begin_face).normalized();
  const Eigen::Vector3d end = area_vector(mesh, edge.end_face).normalized();
  return -std::atan2(begin.cross(end).dot(along.normalized()), begin.dot(end)) * along.norm();
}

class Borders {
 public:
  Borders(const FieldMesh& mesh, const std::vector<BoundaryEdge>& edges,
          const std::vector<SignedAxis>& labels)
      : mesh_(mesh), edges_(edges), labels_(labels), used_(edges.size(), 0) {
    double length = 0;
    for (int e = 0; e < static_cast<int>(edges.size()); ++e) {
      length += edge_length(mesh, at(edges, e).vertices);
      if (!is_border(e)) continue;
      for (const int v : at(edges, e).vertices) edges_of_vertex_[v].push_back(e);
    }
    mean_length_ = length / static_cast<double>(std::max<std::size_t>(1, edges.size()));
  }

  std::vector<TurningBorder> find() {
    std::vector<TurningBorder> found;
    for (const auto& [vertex, around] : edges_of_vertex_) {
      if (around.size() == 2) continue;
      for (const int e : around) {
        if (!at(used_, e)) add_if_turning(trace(vertex, e), found);
      }
    }
    return found;
  }

 private:
  bool is_border(int e) const {
    return !(at(labels_, at(edges_, e).begin_face) == at(labels_, at(edges_, e).end_face));
  }

  // From a corner along the border to the next corner.
  std::vector<Step> trace(int vertex, int e) {
    std::vector<Step> steps;
    const SignedAxis first_side = at(labels_, at(edges_, e).begin_face);
    while (true) {
      at(used_, e) = 1;
      const BoundaryEdge& edge = at(edges_, e);
      steps.push_back({e, at(labels_, edge.begin_face) == first_side, bend_of(mesh_, edge)});
      vertex = edge.vertices[0] == vertex ? edge.vertices[1] : edge.vertices[0];
      const std::vector<int>& around = edges_of_vertex_.at(vertex);
      if (around.size() != 2) return steps;
      e = around[0] == e ? around[1] : around[0];
      if (at(used_, e)) return steps;
    }
  }

  // The step after which the bends before and behind differ most.
  static std::size_t turn_of(const std::vector<Step>& steps, double& before, double& behind) {
    double total = 0;
    for (const Step& step : steps) total += step.bend;
    std::size_t best = 0;
    double sum = 0, most = -1;
    for (std::size_t i = 0; i + 1 < steps.size(); ++i) {
      sum += steps[i].bend;
      if (std::abs(sum - (total - sum)) <= most) continue;
      most = std::abs(sum - (total - sum));
      best = i + 1;
      before = sum;
      behind = total - sum;
    }
    return best;
  }

  void add_if_turning(const std::vector<Step>& steps, std::vector<TurningBorder>& found) const {
    double before = 0, behind = 0;
    const std::size_t turn = turn_of(steps, before, behind);
    const double enough = least_bend * mean_length_;
    if (before * behind >= 0 || std::min(std::abs(before), std::abs(behind)) < enough) return;
    const BoundaryEdge& edge = at(edges_, steps.front().edge);
    const int begin = at(labels_, edge.begin_face).axis;
    const int end = at(labels_, edge.end_face).axis;
    if (begin == end) return;
    TurningBorder border{{begin, end}, {}};
    for (std::size_t i = 0; i < steps.size(); ++i) {
      const std::size_t part = (i < turn) == (before > 0) ? 0 : 2;
      const BoundaryEdge& at_step = at(edges_, steps[i].edge);
      border.parts[part].push_back(steps[i].forwards ? at_step.begin_face : at_step.end_face);
      border.parts[part + 1].push_back(steps[i].forwards ? at_step.end_face : at_step.begin_face);
    }
    found.push_back(std::move(border));
  }

  const FieldMesh& mesh_;
  const std::vector<BoundaryEdge>& edges_;
  const std::vector<SignedAxis>& labels_;
  std::vector<char> used_;
  std::map<int, std::vector<int>> edges_of_vertex_;
  double mean_length_ = 0;
};

}  // namespace

std::vector<TurningBorder> find_turning_borders(const FieldMesh& mesh, const std::vector<BoundaryEdge>& edges,
                                                const std::vector<SignedAxis>& labels) {
  return Borders(mesh, edges, labels).find();
}

}  // namespace neurframe
