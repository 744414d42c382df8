// The flat metric of a seamless map as an intrinsic triangulation: no positions, only edge vectors.
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "core/fixed_point.hpp"
#include "miq/integer_combination.hpp"

namespace neurframe {

// A half-edge in the chart of its triangle.  Vectors are exact: they are only added, negated and turned.
struct IntrinsicEdge {
  int from = -1;  // vertex
  int twin = -1;
  int turns = 0;         // x in the chart of the twin's triangle = x after this many quarter turns
  bool feature = false;  // not to be flipped; boundary edges too
  std::array<Vector2<Fixed>, 2> along;         // in the seamless map, and where the motion goes
  std::array<IntegerCombination, 2> symbolic;  // the same in the unknowns of the map
};

// Half-edge 3 f + i runs from corner i to corner i + 1 of triangle f.  Triangles that were removed keep their
// numbers and have no vertices.
class IntrinsicTriangulation {
 public:
  IntrinsicTriangulation(std::vector<IntrinsicEdge> edges, int vertex_count);

  int half_edge_count() const { return static_cast<int>(edges_.size()); }
  int triangle_count() const { return half_edge_count() / 3; }
  IntrinsicEdge& edge(int h) { return edges_[static_cast<size_t>(h)]; }
  const IntrinsicEdge& edge(int h) const { return edges_[static_cast<size_t>(h)]; }
  static int next(int h) { return h % 3 == 2 ? h - 2 : h + 1; }
  static int previous(int h) { return h % 3 == 0 ? h + 2 : h - 1; }
  bool alive(int f) const { return edge(3 * f).from >= 0; }
  int to(int h) const { return edge(next(h)).from; }

  // vectors at time t of the motion, 0 the seamless map and 1 where it goes
  Vector2<double> along_at(int h, double t) const;
  // exact sign of the triangle's area at the start (0) or at the end (1)
  int area_sign(int f, size_t end) const;

  // Replaces the edge by the other diagonal of its two triangles, which must differ.
  void flip(int h);

  // Removes an interior vertex without cone angle, or one inside a straight feature line, by flips with
  // triangles of positive area; false, perhaps after some flips, where that cannot be done.
  bool remove_vertex(int v);

  // the same without the numbers of removed triangles
  IntrinsicTriangulation compacted() const;

 private:
  std::vector<int> star(int v) const;
  void turn_chart(int f, int turns);
  void relocate(const std::vector<std::pair<int, int>>& moved, const std::vector<IntrinsicEdge>& data);
  bool may_flip_away(int h) const;
  bool remove_interior(const std::vector<int>& spokes);
  bool remove_straight(int out, int back);

  std::vector<IntrinsicEdge> edges_;
  std::vector<int> outgoing_;
};

}  // namespace neurframe
