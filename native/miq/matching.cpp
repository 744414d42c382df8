#include "miq/matching.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace neurframe {
namespace {

// angle of the first axis of triangle f against the edge direction
double axis_angle(const CrossSurface& surface, int f, const Eigen::Vector3d& edge) {
  const Eigen::Vector3d& axis = surface.axis[static_cast<size_t>(f)];
  return std::atan2(axis.dot(surface.normal(f).cross(edge)), axis.dot(edge));
}

// angle of the first axis of the left triangle of h in the cross of the right one, unfolded about the edge
double rotation_across(const CrossSurface& surface, int h) {
  const Eigen::Vector3d edge = surface.along(h);
  return axis_angle(surface, h / 3, edge) - axis_angle(surface, surface.twin(h) / 3, edge);
}

}  // namespace

double align_to_features(CrossSurface& surface) {
  double largest = 0;
  for (int f = 0; f < surface.triangle_count(); ++f) {
    int edge = -1;
    for (int h = 3 * f; h < 3 * f + 3; ++h) {
      if (surface.is_feature(h) && (edge < 0 || surface.along(h).norm() > surface.along(edge).norm()))
        edge = h;
    }
    if (edge < 0) continue;
    const Eigen::Vector3d along = surface.along(edge).normalized();
    const double angle = axis_angle(surface, f, along);
    const double target = std::round(angle / kQuarterTurn) * kQuarterTurn;
    largest = std::max(largest, std::abs(angle - target));
    surface.axis[static_cast<size_t>(f)] =
        std::cos(target) * along + std::sin(target) * surface.normal(f).cross(along);
  }
  return largest;
}

void compute_matchings(CrossSurface& surface) {
  surface.matching.assign(static_cast<size_t>(surface.half_edge_count()), 0);
  for (int h = 0; h < surface.half_edge_count(); ++h) {
    const int o = surface.twin(h);
    if (o < h) continue;
    const int turns = static_cast<int>(std::lround(rotation_across(surface, h) / kQuarterTurn)) & 3;
    surface.matching[static_cast<size_t>(h)] = turns;
    surface.matching[static_cast<size_t>(o)] = (4 - turns) & 3;
  }
}

double rotation_residual(const CrossSurface& surface, int h) {
  // the same floats whichever side asks, so that the two residuals are exact negatives
  const int low = std::min(h, surface.twin(h));
  const double rotation =
      rotation_across(surface, low) - kQuarterTurn * surface.matching[static_cast<size_t>(low)];
  const double residual = std::remainder(rotation, 4 * kQuarterTurn);
  return low == h ? residual : -residual;
}

std::vector<Sector> measure_sectors(const CrossSurface& surface) {
  std::vector<Sector> sectors;
  for (const int start : outgoing_half_edges(surface)) {
    if (start < 0) continue;
    std::vector<int> corners = fan(surface, start);
    const auto first =
        std::find_if(corners.begin(), corners.end(), [&](int h) { return surface.is_feature(h); });
    const bool closed = first == corners.end();
    if (!closed) std::rotate(corners.begin(), first, corners.end());
    double angle = 0;
    for (size_t i = 0; i < corners.size(); ++i) {
      const int h = corners[i];
      if (i == 0 || (!closed && surface.is_feature(h))) {
        sectors.push_back({surface.from(h), {}, closed, 0, 0});
        angle = 0;
      }
      sectors.back().corners.push_back(h);
      const int crossing = CrossSurface::previous(h);
      const double corner = surface.corner_angle(h);
      sectors.back().angle += corner;
      angle += corner;
      if (surface.twin(crossing) >= 0 && !surface.is_feature(crossing)) {
        angle += rotation_residual(surface, crossing);
      }
      sectors.back().quarter_turns = static_cast<int>(std::lround(angle / kQuarterTurn));
    }
  }
  return sectors;
}

std::vector<char> singular_vertices(const CrossSurface& surface, const std::vector<Sector>& sectors) {
  std::vector<int> count(surface.positions.size(), 0);
  std::vector<char> open(surface.positions.size(), 0);
  for (int h = 0; h < surface.half_edge_count(); ++h) {
    if (surface.twin(h) < 0) open[static_cast<size_t>(surface.from(h))] = 1;
  }
  for (const Sector& sector : sectors) ++count[static_cast<size_t>(sector.vertex)];
  std::vector<char> singular(surface.positions.size(), 0);
  for (const Sector& sector : sectors) {
    const auto v = static_cast<size_t>(sector.vertex);
    // a feature line that ends inside the surface has one sector all round
    const int regular = count[v] == 1 && !open[v] ? 4 : 2;
    // more lines than one through a vertex cross there, whatever the turns between them
    const bool crossing = count[v] > (open[v] ? 1 : 2);
    if (crossing || sector.quarter_turns != regular) singular[v] = 1;
  }
  return singular;
}

}  // namespace neurframe
