// Pairs of singular vertices of opposite sign that are not worth their cells.
#include <algorithm>

#include "miq/field_topology.hpp"

namespace neurframe {
namespace {

struct Dipole {
  double distance;
  int gaining;  // sector that lacks quarter turns
  ShiftPath path;
  bool operator<(const Dipole& other) const {
    return distance != other.distance ? distance < other.distance : gaining < other.gaining;
  }
};

// for each sector that lacks quarter turns its nearest partner, nearest pairs first
std::vector<Dipole> find_dipoles(FieldTopology& topology, double reach) {
  std::vector<Dipole> dipoles;
  std::vector<Sector>& sectors = topology.sectors();
  for (size_t s = 0; s < sectors.size(); ++s) {
    if (!sectors[s].closed || sectors[s].quarter_turns >= 4) continue;
    Dipole dipole{0, static_cast<int>(s), {}};
    dipole.path = topology.nearest(sectors[s], reach, [&](const Sector& other, double distance) {
      dipole.distance = distance;
      return other.quarter_turns > 4;
    });
    if (!dipole.path.empty()) dipoles.push_back(std::move(dipole));
  }
  std::sort(dipoles.begin(), dipoles.end());
  return dipoles;
}

// false if an earlier pair has used up one of the two
bool cancel(FieldTopology& topology, const Dipole& dipole) {
  Sector& gaining = topology.sectors()[static_cast<size_t>(dipole.gaining)];
  if (gaining.quarter_turns >= 4 || topology.at(dipole.path.front()).quarter_turns <= 4) return false;
  topology.move_turn(dipole.path, gaining);
  return true;
}

}  // namespace

int cancel_dipoles(FieldTopology& topology, double reach) {
  int cancelled = 0;
  while (true) {
    const std::vector<Dipole> dipoles = find_dipoles(topology, reach);
    if (dipoles.empty()) return cancelled;
    for (const Dipole& dipole : dipoles) cancelled += cancel(topology, dipole);
  }
}

}  // namespace neurframe
