#include "miq/fixed_point_map.hpp"

#include <algorithm>
#include <cmath>
#include <set>

namespace neurframe {
namespace {

int64_t whole(const std::vector<std::pair<int, int>>& terms, const Eigen::VectorXd& integer) {
  int64_t total = 0;
  for (const auto& [index, factor] : terms) total += factor * std::llround(integer[index]);
  return total;
}

// Sums of numbers below it, times 2^24 for the fraction, stay far from the ends of 64 bits.
constexpr double largest_term = std::int64_t{1} << 36;  // cells

// Infinite where the terms of a sum are too large for exact arithmetic, or are no numbers.
double largest_parameter(const ReducedVariables& variables, const Eigen::VectorXd& real,
                         const Eigen::VectorXd& integer) {
  if (!(integer.array().abs() < largest_term).all()) return INFINITY;
  double largest = 0;
  for (const ReducedCoordinate& x : variables.coordinates) {
    double value = x.real >= 0 ? x.sign * real[x.real] : 0.0;
    double terms = std::abs(value);
    for (const auto& [index, factor] : x.integers) {
      value += factor * integer[index];
      terms += std::abs(factor * integer[index]);
    }
    if (!(terms < largest_term)) return INFINITY;
    largest = std::max(largest, std::abs(value));
  }
  return largest;
}

// quadrant of a direction, each closed at its clockwise axis
int quadrant(const Vector2<Fixed>& d) {
  if (d[0] > 0 && d[1] >= 0) return 0;
  if (d[0] <= 0 && d[1] > 0) return 1;
  return d[0] < 0 ? 2 : 3;
}

int quadrants_passed(const FixedPointMap& map, int corner) {
  const auto at = [&](int c) { return map.corners[static_cast<size_t>(c)]; };
  const Vector2<Fixed> first = difference(at(CrossSurface::next(corner)), at(corner));
  const Vector2<Fixed> last = difference(at(CrossSurface::previous(corner)), at(corner));
  return (quadrant(last) - quadrant(first)) & 3;
}

}  // namespace

FixedPointMap fixed_point_map(const ReducedVariables& variables, const Eigen::VectorXd& real,
                              const Eigen::VectorXd& integer) {
  FixedPointMap map;
  map.fraction_bits = fraction_bits_for(largest_parameter(variables, real, integer));
  if (map.fraction_bits == 0) throw StageError("the map spans too many cells; use a larger edge length");
  const auto parameter = [&](int corner, int k) {
    const int sector = variables.sector[static_cast<size_t>(corner)];
    const ReducedCoordinate& x = variables.coordinates[static_cast<size_t>(2 * sector + k)];
    Fixed value = x.real >= 0 ? x.sign * to_fixed(real[x.real], map.fraction_bits) : 0;
    for (const auto& [index, factor] : x.integers) {
      value += factor * to_fixed(integer[index], map.fraction_bits);
    }
    return value;
  };
  for (int c = 0; c < static_cast<int>(variables.sector.size()); ++c) {
    map.corners.push_back({parameter(c, 0), parameter(c, 1)});
  }
  return map;
}

MapCheck check_map(const CrossSurface& surface, const std::vector<Sector>& sectors,
                   const FixedPointMap& map) {
  MapCheck check;
  double doubled = 0;
  for (int f = 0; f < surface.triangle_count(); ++f) {
    const auto c = static_cast<size_t>(3 * f);
    const Int128 area = orient2d(map.corners[c], map.corners[c + 1], map.corners[c + 2]);
    doubled += std::ldexp(static_cast<double>(area), -2 * map.fraction_bits);
    if (sign_of(area) <= 0) check.folded.push_back(f);
  }
  check.cells = doubled / 2;
  const std::set<int> folded(check.folded.begin(), check.folded.end());
  std::set<int> overwound;
  for (const Sector& sector : sectors) {
    int turns = 0;
    bool countable = true;
    for (const int h : sector.corners) {
      turns += quadrants_passed(map, h);
      countable = countable && folded.count(h / 3) == 0;
    }
    if (countable && turns != sector.quarter_turns) overwound.insert(sector.vertex);
  }
  check.overwound.assign(overwound.begin(), overwound.end());
  return check;
}

QuadMap quad_map(const CrossSurface& surface, const ReducedVariables& variables, const CutGraph& graph,
                 const FixedPointMap& map, const Eigen::VectorXd& integer) {
  QuadMap out;
  for (const Eigen::Vector3d& p : surface.positions) out.mesh.V.push_back({p[0], p[1], p[2]});
  out.mesh.F = surface.triangles;
  for (size_t f = 0; f < surface.triangles.size(); ++f) {
    std::array<Vector2<double>, 3> corners;
    for (size_t i = 0; i < 3; ++i) {
      for (size_t k = 0; k < 2; ++k) corners[i][k] = from_fixed(map.corners[3 * f + i][k], map.fraction_bits);
    }
    out.parameters.push_back(corners);
  }
  for (size_t b = 0; b < graph.branches.size(); ++b) {
    const SeamTransition& seam = variables.transitions[b];
    const GridTransition2 transition{
        QuarterTurn(seam.turns), {whole(seam.translation[0], integer), whole(seam.translation[1], integer)}};
    for (const int h : graph.branches[b].half_edges) {
      out.transitions.push_back({h / 3, surface.twin(h) / 3, transition});
    }
  }
  return out;
}

}  // namespace neurframe
