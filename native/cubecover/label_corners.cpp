#include "cubecover/label_corners.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace neurframe {

namespace {

// One label round a vertex.
struct Sector {
  SignedAxis label;
  int side;               // where it ends, counter-clockwise: 1 convex, -1 concave, 0 for either
  int quarter_turns = 0;  // its angle
};
using Corner = std::vector<Sector>;

Eigen::Vector3i half_axis(int index) {
  return (index % 2 == 0 ? 1 : -1) * Eigen::Vector3i::Unit(index / 2);
}

SignedAxis label_along(const Eigen::Vector3i& normal) {
  SignedAxis label;
  normal.cwiseAbs().maxCoeff(&label.axis);
  label.sign = normal(label.axis);
  return label;
}

// The boundary round the origin of a union of octants, as the half-axes that follow each other
// counter-clockwise seen from outside; empty unless it is one disc.
std::vector<Eigen::Vector3i> outline(unsigned octants) {
  const auto is_solid = [&](const Eigen::Vector3i& inside) {
    const unsigned index = (inside(0) > 0 ? 1U : 0U) | (inside(1) > 0 ? 2U : 0U) | (inside(2) > 0 ? 4U : 0U);
    return (octants >> index & 1U) != 0;
  };
  std::array<int, 6> next;
  next.fill(-1);
  int arcs = 0, start = -1;
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) {
      const Eigen::Vector3i from = half_axis(i), to = half_axis(j), normal = from.cross(to);
      if (normal.isZero() || is_solid(from + to + normal) || !is_solid(from + to - normal)) continue;
      if (at(next, i) >= 0) return {};
      at(next, i) = j;
      start = i;
      ++arcs;
    }
  }
  std::vector<Eigen::Vector3i> around;
  for (int i = start; around.empty() || i != start; i = at(next, i)) around.push_back(half_axis(i));
  return static_cast<int>(around.size()) == arcs ? around : std::vector<Eigen::Vector3i>{};
}

Corner corner_of_outline(const std::vector<Eigen::Vector3i>& around) {
  const std::size_t count = around.size();
  const auto normal = [&](std::size_t i) { return around[i % count].cross(around[(i + 1) % count]).eval(); };
  std::size_t first = 0;  // quarter turn after which the label changes
  while (first + 1 < count && normal(first) == normal(first + 1)) ++first;
  Corner corner;
  int quarter_turns = 0;
  for (std::size_t i = first + 1; i <= first + count; ++i) {
    ++quarter_turns;
    if (normal(i) == normal(i + 1)) continue;
    const bool convex = around[(i + 1) % count] == normal(i + 1).cross(normal(i));
    corner.push_back({label_along(normal(i)), convex ? 1 : -1, quarter_turns});
    quarter_turns = 0;
  }
  return corner;
}

// All corners of unions of octants, which are those of polycubes.
std::vector<Corner> possible_corners() {
  std::vector<Corner> corners;
  for (unsigned octants = 1; octants < 255; ++octants) {
    const std::vector<Eigen::Vector3i> around = outline(octants);
    if (!around.empty()) corners.push_back(corner_of_outline(around));
  }
  return corners;
}

bool agree(const Corner& found, const Corner& possible, std::size_t shift) {
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Sector& other = possible[(i + shift) % possible.size()];
    if (!(found[i].label == other.label)) return false;
    if (found[i].side != 0 && found[i].side != other.side) return false;
  }
  return true;
}

void admit(LabelCorner& corner, const Corner& possible, std::size_t shift) {
  double stretch = 0;
  for (std::size_t i = 0; i < corner.fans.size(); ++i) {
    LabelCorner::Fan& fan = corner.fans[i];
    const int turns = possible[(i + shift) % possible.size()].quarter_turns;
    fan.least_quarter_turns = corner.is_possible ? std::min(fan.least_quarter_turns, turns) : turns;
    fan.most_quarter_turns = std::max(fan.most_quarter_turns, turns);
    stretch += std::abs(turns * std::numbers::pi / 2 - fan.angle);
  }
  corner.stretch = corner.is_possible ? std::min(corner.stretch, stretch) : stretch;
  corner.is_possible = true;
}

void compare_with_polycubes(LabelCorner& corner, const Corner& found) {
  static const std::vector<Corner> corners = possible_corners();
  for (const Corner& possible : corners) {
    if (possible.size() != found.size()) continue;
    for (std::size_t shift = 0; shift < possible.size(); ++shift) {
      if (agree(found, possible, shift)) admit(corner, possible, shift);
    }
  }
}

// What lies round one vertex.
struct Star {
  std::map<int, int> side_of_border;  // by the vertex at its other end
  std::map<int, int> face_behind;     // the half-face counter-clockwise behind the edge to a vertex
};

std::map<int, Star> stars_of_corners(const FieldMesh& mesh, const std::vector<BoundaryEdge>& edges,
                                     const std::vector<SignedAxis>& labels) {
  std::map<int, Star> stars;
  const double enough = least_bend(mesh, edges);
  for (const Border& border : find_borders(mesh, edges, labels)) {
    const double bend = bend_of(border);
    const int side = std::abs(bend) < enough ? 0 : bend > 0 ? 1 : -1;
    for (const BorderStep& step : border) {
      const auto [a, b] = at(edges, step.edge).vertices;
      stars[a].side_of_border[b] = stars[b].side_of_border[a] = side;
    }
  }
  std::erase_if(stars, [](const auto& entry) { return entry.second.side_of_border.size() < 3; });
  for (int h = 0; h < mesh.half_face_count(); ++h) {
    if (at(mesh.twin, h) >= 0) continue;
    const auto vertices = half_face_vertices(mesh.tets, h);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto star = stars.find(vertices[k]);
      if (star != stars.end()) star->second.face_behind[vertices[(k + 1) % 3]] = h;
    }
  }
  return stars;
}

// The vertex that comes before this one round the face.
int vertex_before(const FieldMesh& mesh, int half_face, int vertex) {
  const auto vertices = half_face_vertices(mesh.tets, half_face);
  const auto found = std::find(vertices.begin(), vertices.end(), vertex);
  return vertices[static_cast<std::size_t>(found - vertices.begin() + 2) % 3];
}

double angle_at(const FieldMesh& mesh, int vertex, int one, int other) {
  const Eigen::Vector3d a = at(mesh.points, one) - at(mesh.points, vertex);
  const Eigen::Vector3d b = at(mesh.points, other) - at(mesh.points, vertex);
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace

std::vector<LabelCorner> find_label_corners(const FieldMesh& mesh, const std::vector<BoundaryEdge>& edges,
                                            const std::vector<SignedAxis>& labels) {
  std::vector<LabelCorner> corners;
  for (const auto& [vertex, star] : stars_of_corners(mesh, edges, labels)) {
    LabelCorner corner{vertex, {}};
    Corner sectors;
    int spoke = star.side_of_border.begin()->first;
    for (std::size_t i = 0; i < star.face_behind.size(); ++i) {
      const int half_face = star.face_behind.at(spoke);
      if (star.side_of_border.contains(spoke)) {
        corner.fans.emplace_back();
        sectors.push_back({at(labels, half_face), 0});
      }
      corner.fans.back().half_faces.push_back(half_face);
      const int next = vertex_before(mesh, half_face, vertex);
      corner.fans.back().angle += angle_at(mesh, vertex, spoke, next);
      spoke = next;
      if (star.side_of_border.contains(spoke)) sectors.back().side = star.side_of_border.at(spoke);
    }
    compare_with_polycubes(corner, sectors);
    corners.push_back(std::move(corner));
  }
  return corners;
}

}  // namespace neurframe
