// Tet meshes in plain arrays, and their adjacency across faces.
//
// Half-face h = 4 t + i is the face of tet t opposite its corner i; face_corners[i] lists it so that its
// normal points out of a positively oriented tet (det(v1 - v0, v2 - v0, v3 - v0) > 0).
#pragma once

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "core/errors.hpp"
#include "core/octahedral_rotation.hpp"
#include "core/triangle_mesh.hpp"

namespace neurframe {

using Tet = std::array<int, 4>;

struct TetMesh {
  std::vector<Point3> V;
  std::vector<Tet> T;
};

inline constexpr std::array<std::array<int, 3>, 4> face_corners{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};
// half-face numbers must fit an int, and so must the number after the last one
inline constexpr std::size_t most_tets = (std::size_t{1} << 29) - 1;

inline int corner_of(const Tet& tet, int vertex) {
  for (int i = 0; i < 4; ++i) {
    if (tet[static_cast<std::size_t>(i)] == vertex) return i;
  }
  return -1;
}

inline std::array<int, 3> half_face_vertices(const std::vector<Tet>& T, int half_face) {
  const Tet& tet = T[static_cast<std::size_t>(half_face / 4)];
  const auto& corners = face_corners[static_cast<std::size_t>(half_face % 4)];
  return {tet[static_cast<std::size_t>(corners[0])], tet[static_cast<std::size_t>(corners[1])],
          tet[static_cast<std::size_t>(corners[2])]};
}

// Raises InputError for an index outside [0, vertices) or a tet that repeats a vertex.
inline void check_tets(const std::vector<Tet>& T, std::size_t vertices) {
  if (T.size() > most_tets) throw InputError("more than " + std::to_string(most_tets) + " tets");
  for (std::size_t t = 0; t < T.size(); ++t) {
    for (const int v : T[t]) {
      if (v < 0 || static_cast<std::size_t>(v) >= vertices) {
        throw InputError("tet " + std::to_string(t) + ": vertex " + std::to_string(v) +
                         ", allowed are 0 to " + std::to_string(static_cast<long>(vertices) - 1));
      }
      if (std::count(T[t].begin(), T[t].end(), v) != 1) {
        throw InputError("tet " + std::to_string(t) + " repeats vertex " + std::to_string(v));
      }
    }
  }
}

namespace detail {

struct SortedHalfFace {
  int middle;
  int largest;
  int half_face;
  bool operator<(const SortedHalfFace& other) const {
    if (middle != other.middle) return middle < other.middle;
    return largest != other.largest ? largest < other.largest : half_face < other.half_face;
  }
  bool same_face(const SortedHalfFace& other) const {
    return middle == other.middle && largest == other.largest;
  }
};

// All half-faces in buckets by their smallest vertex (counting sort): first[v] .. first[v+1] in `items`.
struct HalfFaceBuckets {
  std::vector<std::size_t> first;
  std::vector<SortedHalfFace> items;
};

inline HalfFaceBuckets bucket_half_faces(const std::vector<Tet>& T, std::size_t vertices) {
  HalfFaceBuckets buckets{std::vector<std::size_t>(vertices + 1, 0),
                          std::vector<SortedHalfFace>(4 * T.size())};
  const int half_faces = static_cast<int>(4 * T.size());
  const auto smallest = [&](int h) {
    const std::array<int, 3> face = half_face_vertices(T, h);
    return static_cast<std::size_t>(std::min({face[0], face[1], face[2]}));
  };
  for (int h = 0; h < half_faces; ++h) ++buckets.first[smallest(h) + 1];
  for (std::size_t v = 0; v < vertices; ++v) buckets.first[v + 1] += buckets.first[v];
  std::vector<std::size_t> cursor(buckets.first.begin(), buckets.first.end() - 1);
  for (int h = 0; h < half_faces; ++h) {
    std::array<int, 3> face = half_face_vertices(T, h);
    std::sort(face.begin(), face.end());
    buckets.items[cursor[static_cast<std::size_t>(face[0])]++] = {face[1], face[2], h};
  }
  return buckets;
}

}  // namespace detail

// twin[h] is the half-face on the other side of half-face h, or -1 on the boundary.  Linear time.
// Raises InputError where a face belongs to more than two tets.
inline std::vector<int> half_face_twins(const std::vector<Tet>& T, std::size_t vertices) {
  check_tets(T, vertices);
  detail::HalfFaceBuckets buckets = detail::bucket_half_faces(T, vertices);
  std::vector<int> twin(4 * T.size(), -1);
  for (std::size_t v = 0; v < vertices; ++v) {
    const auto end = buckets.items.begin() + static_cast<std::ptrdiff_t>(buckets.first[v + 1]);
    auto item = buckets.items.begin() + static_cast<std::ptrdiff_t>(buckets.first[v]);
    std::sort(item, end);
    while (item != end) {
      const auto after = std::find_if(item, end, [&](const auto& other) { return !other.same_face(*item); });
      if (after - item > 2) {
        throw InputError("face " + std::to_string(v) + "-" + std::to_string(item->middle) + "-" +
                         std::to_string(item->largest) + " has " + std::to_string(after - item) +
                         " tets, allowed are 1 or 2");
      }
      if (after - item == 2) {
        twin[static_cast<std::size_t>(item[0].half_face)] = item[1].half_face;
        twin[static_cast<std::size_t>(item[1].half_face)] = item[0].half_face;
      }
      item = after;
    }
  }
  return twin;
}

// True when the two tets of every interior face see it with opposite orientation: then one choice of sign
// per connected component orients everything.
inline bool is_coherently_oriented(const std::vector<Tet>& T, const std::vector<int>& twin, int half_face) {
  const int other = twin[static_cast<std::size_t>(half_face)];
  if (other < 0) return true;
  const std::array<int, 3> a = half_face_vertices(T, half_face);
  const std::array<int, 3> b = half_face_vertices(T, other);
  const auto start = static_cast<std::size_t>(std::find(b.begin(), b.end(), a[0]) - b.begin());
  return b[(start + 1) % 3] == a[2];
}

// Six times the signed volume of a tet.
inline double signed_volume6(const TetMesh& mesh, std::size_t t) {
  const Point3& origin = mesh.V[static_cast<std::size_t>(mesh.T[t][0])];
  std::array<Point3, 3> e{};
  for (std::size_t i = 0; i < 3; ++i) {
    const Point3& p = mesh.V[static_cast<std::size_t>(mesh.T[t][i + 1])];
    e[i] = {p[0] - origin[0], p[1] - origin[1], p[2] - origin[2]};
  }
  return e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) -
         e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0]) +
         e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
}

}  // namespace neurframe
