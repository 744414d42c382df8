// Sectors in which the field leaves no room for a quad: the matchings are shifted so that there is room.
#include <map>

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

int repair_sectors(CrossSurface& surface, std::vector<Sector>& sectors, int closed_minimum) {
  constexpr int kDonorReach = 4;  // cancels a nearby singularity of the opposite sign
  constexpr int kFarReach = 40;
  SectorBudget budget(surface, sectors, closed_minimum);
  int shifted = 0;
  for (Sector& sector : sectors) {
    while (budget.need(sector) > 0) {
      std::vector<int> path =
          path_to_donor(budget, sector, kDonorReach, [&](const Sector& s) { return budget.is_donor(s); });
      if (path.empty()) {
        path = path_to_donor(budget, sector, kFarReach,
                             [&](const Sector& s) { return s.closed && budget.can_spare(s); });
      }
      if (path.empty()) break;
      for (const int h : path) shift_matching(surface, h);
      --budget.across(path.front()).quarter_turns;
      ++sector.quarter_turns;
      shifted += static_cast<int>(path.size());
    }
  }
  return shifted;
}

}  // namespace neurframe
