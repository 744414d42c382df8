// Triangle meshes in plain arrays, and their half-edge adjacency.
//
// Corner c = 3 f + i is corner i of triangle f; half-edge c runs from corner i to corner i + 1 of f.
#pragma once

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "core/errors.hpp"
#include "core/octahedral_rotation.hpp"

namespace neurframe {

using Point3 = Vector3<double>;
using Triangle = std::array<int, 3>;

struct TriangleMesh {
  std::vector<Point3> V;
  std::vector<Triangle> F;
};

inline constexpr std::size_t most_triangles = std::size_t{1} << 29;  // half-edge numbers must fit an int

inline constexpr int next_corner(int c) {
  return c % 3 == 2 ? c - 2 : c + 1;
}
inline constexpr int previous_corner(int c) {
  return c % 3 == 0 ? c + 2 : c - 1;
}

inline int corner_vertex(const std::vector<Triangle>& F, int corner) {
  return F[static_cast<std::size_t>(corner / 3)][static_cast<std::size_t>(corner % 3)];
}

// Raises InputError for an index outside [0, vertices) or a triangle that repeats a vertex.
inline void check_triangles(const std::vector<Triangle>& F, std::size_t vertices) {
  if (F.size() > most_triangles)
    throw InputError("more than " + std::to_string(most_triangles) + " triangles");
  for (std::size_t f = 0; f < F.size(); ++f) {
    for (const int v : F[f]) {
      if (v < 0 || static_cast<std::size_t>(v) >= vertices) {
        throw InputError("triangle " + std::to_string(f) + ": vertex " + std::to_string(v) +
                         ", allowed are 0 to " + std::to_string(static_cast<long>(vertices) - 1));
      }
    }
    if (F[f][0] == F[f][1] || F[f][1] == F[f][2] || F[f][2] == F[f][0]) {
      throw InputError("triangle " + std::to_string(f) + " repeats a vertex");
    }
  }
}

namespace detail {

// The half-edges sorted by smaller end (counting sort: linear): first[v] .. first[v+1] in `order`.
struct HalfEdgeBuckets {
  std::vector<int> first;
  std::vector<int> order;
};

inline HalfEdgeBuckets bucket_half_edges(const std::vector<Triangle>& F, std::size_t vertices) {
  const int corners = static_cast<int>(3 * F.size());
  const auto smaller_end = [&](int c) {
    return static_cast<std::size_t>(std::min(corner_vertex(F, c), corner_vertex(F, next_corner(c))));
  };
  HalfEdgeBuckets buckets{std::vector<int>(vertices + 1, 0), std::vector<int>(3 * F.size())};
  for (int c = 0; c < corners; ++c) ++buckets.first[smaller_end(c) + 1];
  for (std::size_t v = 0; v < vertices; ++v) buckets.first[v + 1] += buckets.first[v];
  std::vector<int> cursor(buckets.first.begin(), buckets.first.end() - 1);
  for (int c = 0; c < corners; ++c) buckets.order[static_cast<std::size_t>(cursor[smaller_end(c)]++)] = c;
  return buckets;
}

}  // namespace detail

// twin[c] is the half-edge opposite to half-edge c, or -1 on the boundary.  Linear time.
// Raises InputError where an edge has more than two triangles, or two that run along it the same way.
inline std::vector<int> half_edge_twins(const std::vector<Triangle>& F, std::size_t vertices) {
  check_triangles(F, vertices);
  const detail::HalfEdgeBuckets buckets = detail::bucket_half_edges(F, vertices);
  const auto larger_end = [&](int c) {
    return std::max(corner_vertex(F, c), corner_vertex(F, next_corner(c)));
  };
  std::vector<int> twin(3 * F.size(), -1);
  std::vector<int> same;
  for (std::size_t v = 0; v < vertices; ++v) {
    same.assign(buckets.order.begin() + buckets.first[v], buckets.order.begin() + buckets.first[v + 1]);
    std::sort(same.begin(), same.end(),
              [&](int a, int b) { return std::pair(larger_end(a), a) < std::pair(larger_end(b), b); });
    for (std::size_t i = 0; i < same.size();) {
      std::size_t j = i + 1;
      while (j < same.size() && larger_end(same[j]) == larger_end(same[i])) ++j;
      const std::string edge = "edge " + std::to_string(v) + "-" + std::to_string(larger_end(same[i]));
      if (j - i > 2)
        throw InputError(edge + " has " + std::to_string(j - i) + " triangles, allowed are 1 or 2");
      if (j - i == 2 && corner_vertex(F, same[i]) == corner_vertex(F, same[i + 1])) {
        throw InputError(edge + ": the triangles " + std::to_string(same[i] / 3) + " and " +
                         std::to_string(same[i + 1] / 3) + " are oriented against each other");
      }
      if (j - i == 2) {
        twin[static_cast<std::size_t>(same[i])] = same[i + 1];
        twin[static_cast<std::size_t>(same[i + 1])] = same[i];
      }
      i = j;
    }
  }
  return twin;
}

}  // namespace neurframe
