// Sectors in which the field leaves no room for a quad: the matchings are shifted so that there is room.
#include <algorithm>
#include <map>
#include <set>

#include "miq/matching.hpp"

namespace neurframe {
namespace {

// Which vertices may give up quarter turns, and how many each closed or open sector has.
class SectorBudget {
 public:
  SectorBudget(const CrossSurface& surface, std::vector<Sector>& sectors, int closed_minimum)
      : surface_(surface),
        sectors_(sectors),
        closed_minimum_(closed_minimum),
        at_corner_(static_cast<size_t>(surface.half_edge_count()), -1) {
    for (size_t s = 0; s < sectors.size(); ++s) {
      for (const int h : sectors[s].corners) at_corner_[static_cast<size_t>(h)] = static_cast<int>(s);
    }
  }

  Sector& at(int corner) { return sectors_[static_cast<size_t>(at_corner_[static_cast<size_t>(corner)])]; }
  int minimum(const Sector& sector) const { return sector.closed ? closed_minimum_ : 1; }
  int need(const Sector& sector) const { return minimum(sector) - sector.quarter_turns; }

  // Half-edges into the sector's vertex that lie strictly inside the sector.
  std::vector<int> inner_edges(const Sector& sector) const {
    std::vector<int> inner;
    for (const int h : sector.corners) {
      const int crossing = CrossSurface::previous(h);
      if (surface_.twin(crossing) >= 0 && !surface_.is_feature(crossing)) inner.push_back(crossing);
    }
    return inner;
  }

  // the sector at the other end of a half-edge into a vertex
  Sector& across(int incoming) { return at(incoming); }

  // A vertex that can lose a quarter turn and still be as regular as before or better.
  bool is_donor(const Sector& sector) const {
    return sector.closed ? sector.quarter_turns > 4 : sector.quarter_turns > 2;
  }
  bool can_spare(const Sector& sector) const { return need(sector) < 0; }

 private:
  const CrossSurface& surface_;
  std::vector<Sector>& sectors_;
  int closed_minimum_;
  std::vector<int> at_corner_;
};

// One quarter turn more for the vertex that h runs into, one less for the vertex that it comes from.
void shift_matching(CrossSurface& surface, int h) {
  int& there = surface.matching[static_cast<size_t>(h)];
  int& back = surface.matching[static_cast<size_t>(surface.twin(h))];
  there = (there + 3) & 3;
  back = (back + 1) & 3;
}

// shifts a path of half-edges that run towards the vertex that gains, and notes the vertices on it
void shift_along(CrossSurface& surface, const std::vector<int>& path, std::vector<int>& vertices) {
  for (const int h : path) {
    shift_matching(surface, h);
    vertices.push_back(surface.from(h));
    vertices.push_back(surface.to(h));
  }
}

// Breadth-first search from the sector over closed vertices to one that passes `accept`; the half-edges of
// the path run towards the sector.  Empty if there is none within `reach` edges.
template <class Accept>
std::vector<int> path_to_donor(SectorBudget& budget, const Sector& sector, int reach, const Accept& accept) {
  struct Step {
    int half_edge, previous, depth;
  };
  std::vector<Step> steps;
  std::map<const Sector*, bool> seen{{&sector, true}};
  const auto expand = [&](const Sector& from, int previous, int depth) {
    for (const int h : budget.inner_edges(from)) {
      if (!seen.emplace(&budget.across(h), true).second) continue;
      steps.push_back({h, previous, depth});
    }
  };
  expand(sector, -1, 1);
  for (size_t i = 0; i < steps.size(); ++i) {
    const Sector& candidate = budget.across(steps[i].half_edge);
    if (accept(candidate)) {
      std::vector<int> path;
      for (int j = static_cast<int>(i); j >= 0; j = steps[static_cast<size_t>(j)].previous) {
        path.push_back(steps[static_cast<size_t>(j)].half_edge);
      }
      return path;
    }
    if (candidate.closed && steps[i].depth < reach)
      expand(candidate, static_cast<int>(i), steps[i].depth + 1);
  }
  return {};
}

}  // namespace

std::vector<int> repair_sectors(CrossSurface& surface, std::vector<Sector>& sectors, int closed_minimum) {
  constexpr int kDonorReach = 4;  // cancels a nearby singularity of the opposite sign
  constexpr int kFarReach = 40;
  SectorBudget budget(surface, sectors, closed_minimum);
  std::vector<int> shifted;
  for (Sector& sector : sectors) {
    while (budget.need(sector) > 0) {
      std::vector<int> path =
          path_to_donor(budget, sector, kDonorReach, [&](const Sector& s) { return budget.is_donor(s); });
      if (path.empty()) {
        path = path_to_donor(budget, sector, kFarReach,
                             [&](const Sector& s) { return s.closed && budget.can_spare(s); });
      }
      if (path.empty()) break;
      shift_along(surface, path, shifted);
      --budget.across(path.front()).quarter_turns;
      ++sector.quarter_turns;
    }
  }
  return shifted;
}

namespace {

struct Dipole {
  double distance;
  int gaining, losing;    // sectors
  std::vector<int> path;  // half-edges towards the gaining vertex
  bool operator<(const Dipole& other) const {
    return distance != other.distance ? distance < other.distance : gaining < other.gaining;
  }
};

// Dijkstra's algorithm from a closed sector that lacks quarter turns to the nearest one that has too many.
bool nearest_partner(const CrossSurface& surface, const std::vector<Sector>& sectors,
                     const std::vector<int>& closed_sector, int source, double reach, Dipole& dipole) {
  struct Label {
    double distance;
    int half_edge;
  };
  std::map<int, Label> labels{{sectors[static_cast<size_t>(source)].vertex, {0.0, -1}}};
  std::set<std::pair<double, int>> queue{{0.0, sectors[static_cast<size_t>(source)].vertex}};
  while (!queue.empty()) {
    const auto [distance, v] = *queue.begin();
    queue.erase(queue.begin());
    const int sector = closed_sector[static_cast<size_t>(v)];
    if (sectors[static_cast<size_t>(sector)].quarter_turns > 4) {
      dipole = {distance, source, sector, {}};
      for (int at = v; labels[at].half_edge >= 0; at = surface.to(labels[at].half_edge)) {
        dipole.path.push_back(labels[at].half_edge);
      }
      return true;
    }
    for (const int corner : sectors[static_cast<size_t>(sector)].corners) {
      const int h = CrossSurface::previous(corner);  // runs into v
      const int next = surface.from(h);
      if (closed_sector[static_cast<size_t>(next)] < 0) continue;
      const double longer = distance + surface.along(h).norm();
      const auto found = labels.find(next);
      if (longer > reach || (found != labels.end() && found->second.distance <= longer)) continue;
      if (found != labels.end()) queue.erase({found->second.distance, next});
      labels[next] = {longer, h};
      queue.insert({longer, next});
    }
  }
  return false;
}

}  // namespace

namespace {

std::vector<int> closed_sectors(const CrossSurface& surface, const std::vector<Sector>& sectors) {
  std::vector<int> closed(surface.positions.size(), -1);
  for (size_t s = 0; s < sectors.size(); ++s) {
    if (sectors[s].closed) closed[static_cast<size_t>(sectors[s].vertex)] = static_cast<int>(s);
  }
  return closed;
}

// for each sector that lacks quarter turns its nearest partner, nearest pairs first
std::vector<Dipole> find_dipoles(const CrossSurface& surface, const std::vector<Sector>& sectors,
                                 const std::vector<int>& closed, double reach) {
  std::vector<Dipole> dipoles;
  for (size_t s = 0; s < sectors.size(); ++s) {
    Dipole dipole;
    if (!sectors[s].closed || sectors[s].quarter_turns >= 4) continue;
    if (nearest_partner(surface, sectors, closed, static_cast<int>(s), reach, dipole)) {
      dipoles.push_back(std::move(dipole));
    }
  }
  std::sort(dipoles.begin(), dipoles.end());
  return dipoles;
}

// false if an earlier pair has used up one of the two
bool cancel(CrossSurface& surface, std::vector<Sector>& sectors, const Dipole& dipole,
            std::vector<int>& shifted) {
  Sector& gaining = sectors[static_cast<size_t>(dipole.gaining)];
  Sector& losing = sectors[static_cast<size_t>(dipole.losing)];
  if (gaining.quarter_turns >= 4 || losing.quarter_turns <= 4) return false;
  shift_along(surface, dipole.path, shifted);
  ++gaining.quarter_turns;
  --losing.quarter_turns;
  return true;
}

}  // namespace

std::vector<int> cancel_dipoles(CrossSurface& surface, std::vector<Sector>& sectors, double reach) {
  const std::vector<int> closed = closed_sectors(surface, sectors);
  std::vector<int> shifted;
  while (true) {
    const std::vector<Dipole> dipoles = find_dipoles(surface, sectors, closed, reach);
    if (dipoles.empty()) return shifted;
    for (const Dipole& dipole : dipoles) cancel(surface, sectors, dipole, shifted);
  }
}

int cancel_costly_dipoles(CrossSurface& surface, std::vector<Sector>& sectors, double reach) {
  const std::vector<int> closed = closed_sectors(surface, sectors);
  int cancelled = 0;
  double energy = rotation_energy(surface);
  for (const Dipole& dipole : find_dipoles(surface, sectors, closed, reach)) {
    const std::vector<int> matching = surface.matching;
    const std::vector<Eigen::Vector3d> axis = surface.axis;
    std::vector<int> shifted;
    if (!cancel(surface, sectors, dipole, shifted)) continue;
    relax_field(surface, shifted, 1.5 * dipole.distance);
    const double after = rotation_energy(surface);
    if (after < energy) {
      energy = after;
      ++cancelled;
      continue;
    }
    surface.matching = matching;
    surface.axis = axis;
    --sectors[static_cast<size_t>(dipole.gaining)].quarter_turns;
    ++sectors[static_cast<size_t>(dipole.losing)].quarter_turns;
  }
  return cancelled;
}

}  // namespace neurframe
