// The edges of a tet mesh, each with the tets around it in order.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/tet_mesh.hpp"

namespace neurframe {

// Local corner pairs of the six edges of a tet.
inline constexpr std::array<std::array<int, 2>, 6> tet_edges{
    {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};

inline int local_edge(int corner_a, int corner_b) {
  constexpr std::array<std::array<int, 4>, 4> table{
      {{-1, 0, 1, 2}, {0, -1, 3, 4}, {1, 3, -1, 5}, {2, 4, 5, -1}}};
  return table[static_cast<std::size_t>(corner_a)][static_cast<std::size_t>(corner_b)];
}

// The walk round edge e crosses the half-faces items[first[e]] .. items[first[e+1]-1] in this order: item h
// leaves tet h / 4 into tet twin[h] / 4.  For an interior edge the last item leads back to the first tet.
// For a boundary edge the walk starts in the tet behind one boundary face and the last item is the other
// boundary half-face (its twin is -1), so the number of items is the number of tets in both cases.
// In positively oriented tets the walk turns counter-clockwise about the direction from vertices[e][0] to
// [1].
struct EdgeRings {
  std::vector<std::array<int, 2>> vertices;
  std::vector<int> first{0};
  std::vector<int> items;
  std::vector<char> on_boundary;
  std::vector<std::array<int, 6>> edge_of_tet;  // by tet_edges

  std::span<const int> ring(std::size_t edge) const {
    return {items.data() + first[edge], static_cast<std::size_t>(first[edge + 1] - first[edge])};
  }
};

namespace detail {

// The half-face of tet t at the edge (corners a, b) that a counter-clockwise walk about a -> b leaves
// through.
inline int leaving_half_face(int t, int a, int b) {
  for (int i = 0; i < 4; ++i) {
    if (i == a || i == b) continue;
    const auto& face = face_corners[static_cast<std::size_t>(i)];
    for (std::size_t k = 0; k < 3; ++k) {
      if (face[k] == a && face[(k + 1) % 3] == b) return 4 * t + i;
    }
  }
  return -1;
}

// The half-face at the same tet and edge, other than `half_face`.
inline int other_half_face(const Tet& tet, int half_face, int u, int v) {
  const int a = corner_of(tet, u);
  const int b = corner_of(tet, v);
  return half_face - half_face % 4 + (6 - a - b - half_face % 4);
}

inline void append_ring(const std::vector<Tet>& T, const std::vector<int>& twin, int start,
                        EdgeRings& rings) {
  const auto [u, v] = rings.vertices.back();
  const int edge = static_cast<int>(rings.vertices.size()) - 1;
  const auto tet_of = [&](int h) -> const Tet& { return T[static_cast<std::size_t>(h / 4)]; };
  bool boundary = false;
  // back to the first tet of an open fan
  int h = other_half_face(tet_of(start), start, u, v);
  while (true) {
    const int across = twin[static_cast<std::size_t>(h)];
    if (across < 0) boundary = true;
    if (across < 0 || across == start) break;
    h = other_half_face(tet_of(across), across, u, v);
  }
  h = boundary ? other_half_face(tet_of(h), h, u, v) : start;
  const int begin = h;
  do {
    rings.items.push_back(h);
    const Tet& tet = tet_of(h);
    const auto local = static_cast<std::size_t>(local_edge(corner_of(tet, u), corner_of(tet, v)));
    rings.edge_of_tet[static_cast<std::size_t>(h / 4)][local] = edge;
    const int across = twin[static_cast<std::size_t>(h)];
    if (across < 0) break;
    h = other_half_face(tet_of(across), across, u, v);
  } while (h != begin);
  rings.on_boundary.push_back(boundary ? 1 : 0);
  rings.first.push_back(static_cast<int>(rings.items.size()));
}

}  // namespace detail

// All edges in the order of their first appearance in T.  An edge whose tets form several fans (a
// non-manifold edge) appears once per fan.  Linear time.
inline EdgeRings edge_rings(const std::vector<Tet>& T, const std::vector<int>& twin) {
  EdgeRings rings;
  rings.edge_of_tet.assign(T.size(), {-1, -1, -1, -1, -1, -1});
  for (std::size_t t = 0; t < T.size(); ++t) {
    for (std::size_t k = 0; k < 6; ++k) {
      if (rings.edge_of_tet[t][k] >= 0) continue;
      const auto [a, b] = tet_edges[k];
      rings.vertices.push_back({T[t][static_cast<std::size_t>(a)], T[t][static_cast<std::size_t>(b)]});
      detail::append_ring(T, twin, detail::leaving_half_face(static_cast<int>(t), a, b), rings);
    }
  }
  return rings;
}

}  // namespace neurframe
