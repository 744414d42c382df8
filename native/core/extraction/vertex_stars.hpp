// The corners ((N + 1) t + i) around each vertex of a triangle or tet mesh.
#pragma once

#include <span>
#include <vector>

#include "core/extraction/grid_map.hpp"

namespace neurframe {

struct VertexStars {
  std::vector<int> first;    // per vertex, one more than there are vertices
  std::vector<int> corners;  // ascending around each vertex
  std::vector<int> place;    // per corner, within the star of its vertex

  std::span<const int> of(std::size_t vertex) const {
    return {corners.data() + first[vertex], static_cast<std::size_t>(first[vertex + 1] - first[vertex])};
  }
};

template <int N>
VertexStars vertex_stars(const GridMap<N>& map) {
  constexpr std::size_t corners = N + 1;
  VertexStars stars{std::vector<int>(map.V.size() + 1, 0), std::vector<int>(corners * map.S.size()),
                    std::vector<int>(corners * map.S.size())};
  for (const Simplex<N>& simplex : map.S) {
    for (const int v : simplex) ++stars.first[static_cast<std::size_t>(v) + 1];
  }
  for (std::size_t v = 0; v < map.V.size(); ++v) stars.first[v + 1] += stars.first[v];
  std::vector<int> cursor(stars.first.begin(), stars.first.end() - 1);
  for (std::size_t t = 0; t < map.S.size(); ++t) {
    for (std::size_t i = 0; i < corners; ++i) {
      const auto v = static_cast<std::size_t>(map.S[t][i]);
      int& at = cursor[v];
      stars.place[corners * t + i] = at - stars.first[v];
      stars.corners[static_cast<std::size_t>(at++)] = static_cast<int>(corners * t + i);
    }
  }
  return stars;
}

}  // namespace neurframe
