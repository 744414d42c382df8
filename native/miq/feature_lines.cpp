#include "miq/feature_lines.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

namespace neurframe {
namespace {

void set_feature(CrossSurface& surface, int h, char value) {
  surface.feature[static_cast<size_t>(h)] = value;
  if (surface.twin(h) >= 0) surface.feature[static_cast<size_t>(surface.twin(h))] = value;
}

void drop_short_lines(CrossSurface& surface, double shortest) {
  const std::vector<int> outgoing = outgoing_half_edges(surface);
  std::vector<char> done(static_cast<size_t>(surface.half_edge_count()), 0);
  for (int seed = 0; seed < surface.half_edge_count(); ++seed) {
    if (!surface.is_feature(seed) || done[static_cast<size_t>(seed)]) continue;
    std::vector<int> line{seed};
    done[static_cast<size_t>(seed)] = 1;
    double length = 0;
    bool boundary = false;
    for (size_t i = 0; i < line.size(); ++i) {
      const int h = line[i];
      if (h > surface.twin(h)) length += surface.along(h).norm();
      boundary = boundary || surface.twin(h) < 0;
      std::vector<int> around = fan(surface, outgoing[static_cast<size_t>(surface.to(h))]);
      if (surface.twin(h) >= 0) around.push_back(surface.twin(h));
      for (const int k : fan(surface, outgoing[static_cast<size_t>(surface.from(h))])) around.push_back(k);
      for (const int k : around) {
        if (!surface.is_feature(k) || done[static_cast<size_t>(k)]) continue;
        done[static_cast<size_t>(k)] = 1;
        line.push_back(k);
      }
    }
    if (length >= shortest || boundary) continue;
    for (const int h : line) set_feature(surface, h, 0);
  }
}

// The feature half-edges, one an edge, that lie on one line with `seed`: through vertices where two meet
// without a corner.
std::vector<int> feature_line(const CrossSurface& surface, int seed,
                              const std::vector<std::vector<int>>& at_vertex) {
  constexpr double kStraight = 0.7;  // cosine of the turn, about 45 degrees
  std::vector<int> line{seed};
  std::set<int> seen{seed};
  for (size_t i = 0; i < line.size(); ++i) {
    for (const int v : {surface.from(line[i]), surface.to(line[i])}) {
      const std::vector<int>& edges = at_vertex[static_cast<size_t>(v)];
      if (edges.size() != 2) continue;
      const int other = edges[0] == line[i] ? edges[1] : edges[0];
      const double sign = (surface.from(line[i]) == v) == (surface.from(other) == v) ? -1 : 1;
      const double turn = sign * surface.along(line[i]).normalized().dot(surface.along(other).normalized());
      if (turn > kStraight && seen.insert(other).second) line.push_back(other);
    }
  }
  return line;
}

}  // namespace

void mark_features(CrossSurface& surface, const FeatureOptions& options) {
  surface.feature.assign(static_cast<size_t>(surface.half_edge_count()), 0);
  const std::set<std::pair<int, int>> pairs(options.pairs.begin(), options.pairs.end());
  const double cosine = std::cos(options.angle_deg * std::numbers::pi / 180);
  for (int h = 0; h < surface.half_edge_count(); ++h) {
    const int o = surface.twin(h);
    const bool sharp = o >= 0 && !options.given && surface.normal(h / 3).dot(surface.normal(o / 3)) < cosine;
    const bool listed =
        pairs.count({surface.from(h), surface.to(h)}) || pairs.count({surface.to(h), surface.from(h)});
    if (o < 0 || sharp || listed) set_feature(surface, h, 1);
  }
  if (!options.given) drop_short_lines(surface, options.shortest_line);
}

int release_lines(CrossSurface& surface, const std::vector<Eigen::Vector3d>& points) {
  std::vector<std::vector<int>> at_vertex(surface.positions.size());
  for (int h = 0; h < surface.half_edge_count(); ++h) {
    if (!surface.is_feature(h) || h < surface.twin(h)) continue;
    at_vertex[static_cast<size_t>(surface.from(h))].push_back(h);
    at_vertex[static_cast<size_t>(surface.to(h))].push_back(h);
  }
  const auto passes = [&](int h) {
    const Eigen::Vector3d along = surface.along(h);
    for (const Eigen::Vector3d& p : points) {
      const Eigen::Vector3d offset = p - surface.at(surface.from(h));
      const double t = std::clamp(offset.dot(along) / along.squaredNorm(), 0.0, 1.0);
      if ((offset - t * along).norm() < 1e-6 * along.norm()) return true;
    }
    return false;
  };
  std::set<int> released;
  for (int h = 0; h < surface.half_edge_count(); ++h) {
    if (!surface.is_feature(h) || h < surface.twin(h) || released.count(h) || !passes(h)) continue;
    for (const int k : feature_line(surface, h, at_vertex)) released.insert(k);
  }
  int count = 0;
  for (const int h : released) {
    if (surface.twin(h) < 0) continue;
    set_feature(surface, h, 0);
    ++count;
  }
  return count;
}

std::vector<Eigen::Vector3d> feature_points_near(const CrossSurface& surface,
                                                 const std::vector<int>& triangles, int rings) {
  std::vector<Eigen::Vector3d> points;
  std::set<int> seen(triangles.begin(), triangles.end());
  std::vector<int> front(seen.begin(), seen.end());
  for (int ring = 0; ring <= rings && points.empty(); ++ring) {
    std::vector<int> next;
    for (const int f : front) {
      for (int h = 3 * f; h < 3 * f + 3; ++h) {
        const int o = surface.twin(h);
        if (o >= 0 && surface.is_feature(h)) {
          points.push_back((surface.at(surface.from(h)) + surface.at(surface.to(h))) / 2);
        }
        if (o >= 0 && seen.insert(o / 3).second) next.push_back(o / 3);
      }
    }
    front = std::move(next);
  }
  return points;
}

}  // namespace neurframe
