// Sectors whose quarter turns their angle cannot hold, and singularities too near to features.
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "miq/field_topology.hpp"

namespace neurframe {
namespace {

constexpr double kAnyDistance = std::numeric_limits<double>::infinity();

// The quarter turns that a sector between features is to have.
int turns_held(const Sector& sector) {
  // beyond 67.5 degrees a cell beside the corner comes near to a straight angle or to none
  constexpr double kMostTurn = 0.75;
  const double turns = sector.angle / kQuarterTurn;
  if (sector.quarter_turns >= 1 && std::abs(sector.quarter_turns - turns) <= kMostTurn) {
    return sector.quarter_turns;
  }
  return std::max(1, static_cast<int>(std::lround(turns)));
}

// A turn for a sector that lacks one; false if there is none.
bool take_turn(FieldTopology& topology, Sector& sector, int closed_minimum, double reach) {
  ShiftPath path =
      topology.nearest(sector, reach, [](const Sector& s, double) { return s.quarter_turns > 4; });
  if (path.empty()) {
    path = topology.nearest(sector, kAnyDistance,
                            [&](const Sector& s, double) { return s.quarter_turns > closed_minimum; });
  }
  if (path.empty()) return false;
  topology.move_turn(path, sector);
  return true;
}

// A place for the turn that a sector has too much.
bool give_turn(FieldTopology& topology, Sector& sector, double reach) {
  ShiftPath path =
      topology.nearest(sector, reach, [](const Sector& s, double) { return s.quarter_turns < 4; });
  if (path.empty()) {
    path =
        topology.nearest(sector, kAnyDistance, [](const Sector& s, double) { return s.quarter_turns == 4; });
  }
  if (path.empty()) return false;
  topology.return_turn(path, sector);
  return true;
}

// Distance along edges from the nearest feature, per vertex.
std::vector<double> feature_distance(const CrossSurface& surface) {
  std::vector<double> distance(surface.positions.size(), kAnyDistance);
  std::set<std::pair<double, int>> queue;
  const auto reach = [&](int v, double at) {
    double& known = distance[static_cast<size_t>(v)];
    if (at >= known) return;
    queue.erase({known, v});
    known = at;
    queue.insert({at, v});
  };
  for (int h = 0; h < surface.half_edge_count(); ++h) {
    if (!surface.is_feature(h)) continue;
    reach(surface.from(h), 0);
    reach(surface.to(h), 0);
  }
  const std::vector<int> outgoing = outgoing_half_edges(surface);
  while (!queue.empty()) {
    const auto [at, v] = *queue.begin();
    queue.erase(queue.begin());
    for (const int h : fan(surface, outgoing[static_cast<size_t>(v)])) {
      reach(surface.to(h), at + surface.along(h).norm());
      // a boundary vertex reaches its last neighbour by the edge that runs in
      const int in = CrossSurface::previous(h);
      reach(surface.from(in), at + surface.along(in).norm());
    }
  }
  return distance;
}

// The way to the nearest regular vertex that is clear of features, else to the clearest one within reach.
ShiftPath path_to_clearance(FieldTopology& topology, const Sector& sector,
                            const std::vector<double>& distance, double clearance) {
  // a tip of 15 degrees is as wide as the clearance on both sides at this distance
  const double reach = 8 * clearance;
  const Sector* clearest = nullptr;
  double most = distance[static_cast<size_t>(sector.vertex)];
  ShiftPath path = topology.nearest(sector, reach, [&](const Sector& s, double) {
    const double here = distance[static_cast<size_t>(s.vertex)];
    if (s.quarter_turns != 4) return false;
    if (here > most) {
      most = here;
      clearest = &s;
    }
    return here >= clearance;
  });
  if (!path.empty() || clearest == nullptr) return path;
  return topology.nearest(sector, reach, [&](const Sector& s, double) { return &s == clearest; });
}

}  // namespace

int repair_sectors(FieldTopology& topology, int closed_minimum, double reach) {
  int moved = 0;
  for (Sector& sector : topology.sectors()) {
    const int least = sector.closed ? closed_minimum : turns_held(sector);
    const int most = sector.closed ? std::max(sector.quarter_turns, least) : least;
    while (sector.quarter_turns < least && take_turn(topology, sector, closed_minimum, reach)) ++moved;
    while (sector.quarter_turns > most && give_turn(topology, sector, reach)) ++moved;
  }
  return moved;
}

int retreat_from_features(FieldTopology& topology, double clearance) {
  const std::vector<double> distance = feature_distance(topology.surface());
  int moved = 0;
  for (Sector& sector : topology.sectors()) {
    const bool singular = sector.closed && sector.quarter_turns != 4;
    if (!singular || distance[static_cast<size_t>(sector.vertex)] >= clearance) continue;
    const ShiftPath path = path_to_clearance(topology, sector, distance, clearance);
    if (path.empty()) continue;
    ++moved;
    while (sector.quarter_turns < 4) topology.move_turn(path, sector);
    while (sector.quarter_turns > 4) topology.return_turn(path, sector);
  }
  return moved;
}

}  // namespace neurframe
