#include "miq/field_topology.hpp"

#include <algorithm>
#include <map>
#include <set>

namespace neurframe {

FieldTopology::FieldTopology(CrossSurface& surface, std::vector<Sector>& sectors)
    : surface_(surface), sectors_(sectors), at_corner_(static_cast<size_t>(surface.half_edge_count()), -1) {
  for (size_t s = 0; s < sectors.size(); ++s) {
    for (const int h : sectors[s].corners) at_corner_[static_cast<size_t>(h)] = static_cast<int>(s);
  }
}

ShiftPath FieldTopology::nearest(const Sector& from, double reach, const Accept& accept) {
  std::vector<ShiftPath> found = search(from, reach, 1, false, accept);
  return found.empty() ? ShiftPath{} : std::move(found.front());
}

std::vector<ShiftPath> FieldTopology::nearest_several(const Sector& from, double reach, int most,
                                                      const Accept& accept) {
  return search(from, reach, most, true, accept);
}

std::vector<ShiftPath> FieldTopology::search(const Sector& from, double reach, int most, bool features,
                                             const Accept& accept) {
  struct Label {
    double distance;
    int half_edge;  // towards `from`
    const Sector* previous;
  };
  std::map<const Sector*, Label> labels{{&from, {0.0, -1, nullptr}}};
  std::set<std::pair<double, const Sector*>> queue{{0.0, &from}};
  std::vector<ShiftPath> found;
  while (!queue.empty()) {
    const auto [distance, sector] = *queue.begin();
    queue.erase(queue.begin());
    if (sector != &from && accept(*sector, distance)) {
      found.emplace_back();
      for (const Sector* s = sector; s != &from; s = labels[s].previous) {
        found.back().push_back(labels[s].half_edge);
      }
      if (static_cast<int>(found.size()) == most) break;
    }
    if (sector != &from && !sector->closed) continue;
    for (const int corner : sector->corners) {
      const int h = CrossSurface::previous(corner);  // into the vertex of the sector
      if (surface_.twin(h) < 0 || surface_.is_feature(h)) continue;
      const Sector& next = at(h);
      const double longer = distance + surface_.along(h).norm();
      const auto known = labels.find(&next);
      if (!(next.closed || features) || longer > reach ||
          (known != labels.end() && known->second.distance <= longer)) {
        continue;
      }
      if (known != labels.end()) queue.erase({known->second.distance, &next});
      labels[&next] = {longer, h, sector};
      queue.insert({longer, &next});
    }
  }
  return found;
}

void FieldTopology::shift(const ShiftPath& path, int turns) {
  for (const int h : path) {
    int& there = surface_.matching[static_cast<size_t>(h)];
    int& back = surface_.matching[static_cast<size_t>(surface_.twin(h))];
    there = (there - turns) & 3;
    back = (back + turns) & 3;
    shifted_.push_back(surface_.from(h));
    shifted_.push_back(surface_.to(h));
  }
}

void FieldTopology::move_turn(const ShiftPath& path, Sector& gains) {
  shift(path, 1);
  ++gains.quarter_turns;
  --at(path.front()).quarter_turns;
}

void FieldTopology::return_turn(const ShiftPath& path, Sector& loses) {
  shift(path, -1);
  --loses.quarter_turns;
  ++at(path.front()).quarter_turns;
}

}  // namespace neurframe
