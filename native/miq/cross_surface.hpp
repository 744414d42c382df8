// Oriented triangle surface with a cross per triangle, feature edges and integer matchings, by half-edges.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <numbers>
#include <vector>

namespace neurframe {

inline constexpr double kQuarterTurn = std::numbers::pi / 2;  // radians

// Half-edge 3 f + i runs from corner i to corner i+1 of triangle f; the same number names corner i itself.
struct CrossSurface {
  std::vector<Eigen::Vector3d> positions;
  std::vector<std::array<int, 3>> triangles;
  std::vector<Eigen::Vector3d> axis;  // per triangle: first axis of the cross, tangent, unit length
  std::vector<double> size;           // per triangle: relative target edge length, 1 without a sizing
  std::vector<int> source;            // per triangle: the input triangle that it lies in
  std::vector<int> opposite;          // per half-edge; -1 on the boundary
  std::vector<char> feature;          // per half-edge: to become an integer isoline, boundary edges included
  // per half-edge from triangle f to g: the first axis of f is the first axis of g after this many quarter
  // turns
  std::vector<int> matching;

  int triangle_count() const { return static_cast<int>(triangles.size()); }
  int half_edge_count() const { return 3 * triangle_count(); }
  int vertex_count() const { return static_cast<int>(positions.size()); }
  int from(int h) const { return triangles[static_cast<size_t>(h / 3)][static_cast<size_t>(h % 3)]; }
  static int next(int h) { return h % 3 == 2 ? h - 2 : h + 1; }
  static int previous(int h) { return h % 3 == 0 ? h + 2 : h - 1; }
  int to(int h) const { return from(next(h)); }
  int twin(int h) const { return opposite[static_cast<size_t>(h)]; }
  bool is_feature(int h) const { return feature[static_cast<size_t>(h)] != 0; }
  const Eigen::Vector3d& at(int v) const { return positions[static_cast<size_t>(v)]; }
  Eigen::Vector3d along(int h) const { return at(to(h)) - at(from(h)); }
  Eigen::Vector3d normal(int f) const;  // unit length
  double area(int f) const;
  double corner_angle(int h) const;          // radians, at from(h)
  Eigen::Vector3d second_axis(int f) const;  // normal x axis
};

// Pairs the half-edges.  Raises InputError where more than two triangles, or two of opposite orientation,
// share an edge.
void pair_half_edges(CrossSurface& surface);

// Gives every fan of triangles at a vertex a vertex of its own; returns how many vertices were added.
int split_nonmanifold_vertices(CrossSurface& surface);

// One outgoing half-edge per vertex, the most clockwise one where the vertex is on the boundary; -1 if
// unused.
std::vector<int> outgoing_half_edges(const CrossSurface& surface);

// The outgoing half-edges of a vertex counter-clockwise from `start`, which must be one of them; at a
// boundary vertex `start` must be the most clockwise one.
std::vector<int> fan(const CrossSurface& surface, int start);

double total_area(const CrossSurface& surface);
double bounding_box_diagonal(const std::vector<Eigen::Vector3d>& positions);

}  // namespace neurframe
