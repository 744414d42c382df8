// No face of the result has more than two hexes, nor two on the same side of it.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "hexex/assemble_hexes.hpp"

namespace neurframe {

namespace detail {

struct HexFace {
  std::array<int, 3> others;  // the three larger vertices, sorted
  int hex;
  bool reversed;  // which way round the hex sees the face

  bool same_face(const HexFace& other) const { return others == other.others; }
  bool operator<(const HexFace& other) const {
    return others != other.others ? others < other.others : hex < other.hex;
  }
};

// The face from its smallest vertex on, in the direction of the smaller of the two neighbours.
inline std::pair<int, HexFace> sorted_face(const Hex& hex, std::size_t face, int number) {
  std::array<int, 4> v{};
  for (std::size_t k = 0; k < 4; ++k) v[k] = hex[static_cast<std::size_t>(hex_faces[face][k])];
  std::rotate(v.begin(), std::min_element(v.begin(), v.end()), v.end());
  HexFace found{{v[1], v[2], v[3]}, number, v[3] < v[1]};
  std::sort(found.others.begin(), found.others.end());
  return {v[0], found};
}

// Faces in buckets by smallest vertex: first[v] .. first[v+1].
struct HexFaceBuckets {
  std::vector<std::size_t> first;
  std::vector<HexFace> faces;
};

inline HexFaceBuckets bucket_hex_faces(const std::vector<Hex>& hexes, int vertices) {
  HexFaceBuckets buckets{std::vector<std::size_t>(static_cast<std::size_t>(vertices) + 1, 0),
                         std::vector<HexFace>(6 * hexes.size())};
  const auto smallest = [&](const Hex& hex, const std::array<int, 4>& face) {
    int least = hex[static_cast<std::size_t>(face[0])];
    for (const int k : face) least = std::min(least, hex[static_cast<std::size_t>(k)]);
    return static_cast<std::size_t>(least);
  };
  for (const Hex& hex : hexes) {
    for (const auto& face : hex_faces) ++buckets.first[smallest(hex, face) + 1];
  }
  for (std::size_t v = 0; v + 1 < buckets.first.size(); ++v) buckets.first[v + 1] += buckets.first[v];
  std::vector<std::size_t> cursor(buckets.first.begin(), buckets.first.end() - 1);
  for (std::size_t h = 0; h < hexes.size(); ++h) {
    for (std::size_t face = 0; face < 6; ++face) {
      const auto [v, found] = sorted_face(hexes[h], face, static_cast<int>(h));
      buckets.faces[cursor[static_cast<std::size_t>(v)]++] = found;
    }
  }
  return buckets;
}

}  // namespace detail

// Drops hexes, latest first, until every face has at most two, on opposite sides.
inline void drop_crowding_hexes(const TracedCells& traced, int vertices, AssembledHexes& out) {
  detail::HexFaceBuckets buckets = detail::bucket_hex_faces(out.hexes, vertices);
  std::vector<char> dropped(out.hexes.size(), 0);
  for (std::size_t v = 0; v + 1 < buckets.first.size(); ++v) {
    const auto end = buckets.faces.begin() + static_cast<std::ptrdiff_t>(buckets.first[v + 1]);
    auto face = buckets.faces.begin() + static_cast<std::ptrdiff_t>(buckets.first[v]);
    std::sort(face, end);
    while (face != end) {
      bool taken[2] = {false, false};
      const auto start = face;
      for (; face != end && face->same_face(*start); ++face) {
        bool& side = taken[face->reversed ? 1 : 0];
        if (dropped[static_cast<std::size_t>(face->hex)] != 0) continue;
        if (side) dropped[static_cast<std::size_t>(face->hex)] = 1;
        side = true;
      }
    }
  }
  std::size_t kept = 0;
  for (std::size_t h = 0; h < out.hexes.size(); ++h) {
    const Cell& cell = traced.cells[static_cast<std::size_t>(out.cell_of_hex[h])];
    if (dropped[h] != 0) {
      out.lost.push_back(detail::lost_cell(CellLoss::crowded_face, cell));
    } else {
      out.hexes[kept] = out.hexes[h];
      out.cell_of_hex[kept++] = out.cell_of_hex[h];
    }
  }
  out.hexes.resize(kept);
  out.cell_of_hex.resize(kept);
}

}  // namespace neurframe
