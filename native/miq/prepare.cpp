#include "miq/prepare.hpp"

#include <algorithm>
#include <set>
#include <string>

#include "core/errors.hpp"
#include "miq/matching.hpp"

namespace neurframe {
namespace {

// One triangle under construction: its vertices, and per half-edge what it inherits from its parent.
struct Piece {
  std::array<int, 3> triangle;
  std::array<char, 3> feature;
  std::array<int, 3> matching;
};

Piece piece_of(const CrossSurface& surface, int f) {
  Piece piece{surface.triangles[static_cast<size_t>(f)], {}, {}};
  for (int i = 0; i < 3; ++i) {
    const auto h = static_cast<size_t>(3 * f + i);
    piece.feature[static_cast<size_t>(i)] = surface.feature[h];
    piece.matching[static_cast<size_t>(i)] = surface.matching[h];
  }
  return piece;
}

void store(CrossSurface& surface, int f, const Piece& piece) {
  surface.triangles[static_cast<size_t>(f)] = piece.triangle;
  for (int i = 0; i < 3; ++i) {
    const auto h = static_cast<size_t>(3 * f + i);
    surface.feature[h] = piece.feature[static_cast<size_t>(i)];
    surface.matching[h] = piece.matching[static_cast<size_t>(i)];
  }
}

// a new triangle with the cross of triangle f
void append(CrossSurface& surface, int f, const Piece& piece) {
  const auto parent = static_cast<size_t>(f);
  surface.triangles.push_back(piece.triangle);
  surface.axis.push_back(Eigen::Vector3d(surface.axis[parent]));
  surface.size.push_back(double{surface.size[parent]});
  surface.source.push_back(int{surface.source[parent]});
  surface.feature.resize(surface.feature.size() + 3);
  surface.matching.resize(surface.matching.size() + 3);
  store(surface, surface.triangle_count() - 1, piece);
}

// Cuts triangle h / 3 from `middle`, a vertex on its edge h, to the corner opposite.
void cut_triangle(CrossSurface& surface, int h, int middle) {
  const int f = h / 3;
  const Piece whole = piece_of(surface, f);
  const auto i = static_cast<size_t>(h % 3);
  const size_t j = (i + 1) % 3;
  const size_t k = (i + 2) % 3;
  store(surface, f,
        {{whole.triangle[i], middle, whole.triangle[k]},
         {whole.feature[i], 0, whole.feature[k]},
         {whole.matching[i], 0, whole.matching[k]}});
  append(surface, f,
         {{middle, whole.triangle[j], whole.triangle[k]},
          {whole.feature[i], whole.feature[j], 0},
          {whole.matching[i], whole.matching[j], 0}});
}

void split_edge(CrossSurface& surface, int h) {
  const int o = surface.twin(h);
  surface.positions.push_back((surface.at(surface.from(h)) + surface.at(surface.to(h))) / 2);
  const int middle = surface.vertex_count() - 1;
  cut_triangle(surface, h, middle);
  if (o >= 0) cut_triangle(surface, o, middle);
}

void split_at_centroid(CrossSurface& surface, int f) {
  const Piece whole = piece_of(surface, f);
  const auto [a, b, c] = whole.triangle;
  surface.positions.push_back((surface.at(a) + surface.at(b) + surface.at(c)) / 3);
  const int middle = surface.vertex_count() - 1;
  store(surface, f, {{a, b, middle}, {whole.feature[0], 0, 0}, {whole.matching[0], 0, 0}});
  append(surface, f, {{b, c, middle}, {whole.feature[1], 0, 0}, {whole.matching[1], 0, 0}});
  append(surface, f, {{c, a, middle}, {whole.feature[2], 0, 0}, {whole.matching[2], 0, 0}});
}

// Splits, longest first, edges that pass `wanted` (asked of the larger half-edge), none of whose triangles
// has been touched before.
template <class Wanted>
int split_independent_edges(CrossSurface& surface, const Wanted& wanted) {
  std::vector<std::pair<double, int>> edges;
  for (int h = 0; h < surface.half_edge_count(); ++h) {
    if (h > surface.twin(h) && wanted(h)) edges.emplace_back(-surface.along(h).norm(), h);
  }
  std::sort(edges.begin(), edges.end());
  int splits = 0;
  std::vector<char> touched(surface.triangles.size(), 0);
  for (const auto& [order, h] : edges) {
    const int o = surface.twin(h);
    if (touched[static_cast<size_t>(h / 3)] || (o >= 0 && touched[static_cast<size_t>(o / 3)])) continue;
    touched[static_cast<size_t>(h / 3)] = 1;
    if (o >= 0) touched[static_cast<size_t>(o / 3)] = 1;
    split_edge(surface, h);
    ++splits;
  }
  pair_half_edges(surface);
  return splits;
}

template <class Wanted>
int split_all_edges(CrossSurface& surface, const Wanted& wanted) {
  int total = 0;
  while (const int splits = split_independent_edges(surface, wanted)) total += splits;
  return total;
}

std::vector<char> feature_vertices(const CrossSurface& surface) {
  std::vector<char> on(surface.positions.size(), 0);
  for (int h = 0; h < surface.half_edge_count(); ++h) {
    if (surface.is_feature(h))
      on[static_cast<size_t>(surface.from(h))] = on[static_cast<size_t>(surface.to(h))] = 1;
  }
  return on;
}

constexpr double most_split_triangles = 1 << 25;  // a few hundred bytes each

// Raises StageError where the split triangles, of which so many at least are needed, would fill the memory.
void refuse_too_many_splits(const CrossSurface& surface, double longest) {
  double needed = total_area(surface) / longest / longest;
  for (int f = 0; f < surface.triangle_count(); ++f) {
    for (int h = 3 * f; h < 3 * f + 3; ++h) needed += surface.along(h).norm() / longest / 3;
  }
  if (needed <= most_split_triangles) return;
  throw StageError("the edge length asks for more than " +
                   std::to_string(static_cast<int>(most_split_triangles)) +
                   " triangles; choose a longer one");
}

}  // namespace

int split_long_edges(CrossSurface& surface, double longest) {
  refuse_too_many_splits(surface, longest);
  return split_all_edges(surface, [&](int h) { return surface.along(h).norm() > longest; });
}

int split_around_features(CrossSurface& surface) {
  int splits = 0;
  const int before = surface.triangle_count();
  for (int f = 0; f < before; ++f) {
    if (surface.is_feature(3 * f) + surface.is_feature(3 * f + 1) + surface.is_feature(3 * f + 2) < 2)
      continue;
    split_at_centroid(surface, f);
    ++splits;
  }
  pair_half_edges(surface);
  std::vector<char> on = feature_vertices(surface);
  return splits + split_between_critical(surface, on);
}

int split_between_critical(CrossSurface& surface, std::vector<char>& critical) {
  return split_all_edges(surface, [&](int h) {
    critical.resize(surface.positions.size(), 0);
    return !surface.is_feature(h) && critical[static_cast<size_t>(surface.from(h))] &&
           critical[static_cast<size_t>(surface.to(h))];
  });
}

int refine_singular_stars(CrossSurface& surface, const std::vector<char>& singular) {
  int splits = 0;
  while (true) {
    std::set<int> chosen;
    for (const Sector& sector : measure_sectors(surface)) {
      const auto v = static_cast<size_t>(sector.vertex);
      const int lacking = 2 * sector.quarter_turns - static_cast<int>(sector.corners.size());
      if (v >= singular.size() || !singular[v] || lacking <= 0) continue;
      std::vector<std::pair<double, int>> corners;
      for (const int h : sector.corners) corners.emplace_back(-surface.corner_angle(h), h);
      std::sort(corners.begin(), corners.end());
      for (size_t i = 0; i < corners.size() && static_cast<int>(i) < lacking; ++i) {
        const int edge = CrossSurface::next(corners[i].second);
        chosen.insert(std::max(edge, surface.twin(edge)));
      }
    }
    if (chosen.empty()) return splits;
    splits += split_independent_edges(surface, [&](int h) { return chosen.count(h) != 0; });
  }
}

}  // namespace neurframe
