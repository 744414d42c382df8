// The corners (4 t + i) around each vertex of a tet mesh.
#pragma once

#include <span>
#include <vector>

#include "core/tet_mesh.hpp"

namespace neurframe {

struct VertexStars {
  std::vector<int> first;    // per vertex, one more than there are vertices
  std::vector<int> corners;  // ascending around each vertex

  std::span<const int> of(std::size_t vertex) const {
    return {corners.data() + first[vertex], static_cast<std::size_t>(first[vertex + 1] - first[vertex])};
  }
};

inline VertexStars vertex_stars(const TetMesh& mesh) {
  VertexStars stars{std::vector<int>(mesh.V.size() + 1, 0), std::vector<int>(4 * mesh.T.size())};
  for (const Tet& tet : mesh.T) {
    for (const int v : tet) ++stars.first[static_cast<std::size_t>(v) + 1];
  }
  for (std::size_t v = 0; v < mesh.V.size(); ++v) stars.first[v + 1] += stars.first[v];
  std::vector<int> cursor(stars.first.begin(), stars.first.end() - 1);
  for (std::size_t t = 0; t < mesh.T.size(); ++t) {
    for (std::size_t i = 0; i < 4; ++i) {
      int& at = cursor[static_cast<std::size_t>(mesh.T[t][i])];
      stars.corners[static_cast<std::size_t>(at++)] = static_cast<int>(4 * t + i);
    }
  }
  return stars;
}

}  // namespace neurframe
