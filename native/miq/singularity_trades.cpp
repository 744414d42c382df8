// Quarter turns that change places where that leaves fewer singular vertices, weighed against smoothness.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "miq/field_energy.hpp"
#include "miq/field_topology.hpp"

namespace neurframe {
namespace {

// A sector may be further from its angle than this, in quarter turns, if it was so before.
constexpr double kMostTradedTurn = 0.6;
constexpr int kPartners = 5;  // for each sector, how many of the nearest are weighed

struct Trade {
  ShiftPath path;  // towards `sector`, from the sector that it trades with
  int sector;
  int turns;  // what `sector` gains: 1 or -1
  double own_energy;
};

// The turns of all sectors of a vertex, and how many it should have.
struct VertexTurns {
  int turns = 0;
  int regular = 4;
  bool singular(int more) const { return turns + more != regular; }
};

class TradeSearch {
 public:
  TradeSearch(CrossSurface& surface, std::vector<Sector>& sectors, const TradeOptions& options)
      : options_(options),
        topology_(surface, sectors),
        energy_(surface),
        vertices_(surface.positions.size()) {
    for (const Sector& sector : sectors) of(sector).turns += sector.quarter_turns;
    for (int h = 0; h < surface.half_edge_count(); ++h) {
      if (surface.twin(h) < 0) vertices_[static_cast<size_t>(surface.from(h))].regular = 2;
    }
  }

  int run() {
    int done = 0;
    for (std::vector<Trade> trades = find_all(); !trades.empty(); trades = find_all()) {
      int round = 0;
      while (const Trade* best = best_of(trades)) {
        apply(*best);
        ++round;
      }
      if (round == 0) break;
      done += round;
    }
    return done;
  }

  const std::vector<int>& shifted() const { return topology_.shifted(); }

 private:
  VertexTurns& of(const Sector& sector) { return vertices_[static_cast<size_t>(sector.vertex)]; }

  // Whether the sector can have that many turns more.
  bool holds(const Sector& sector, int more) const {
    const int turns = sector.quarter_turns + more;
    // closed: no vertex becomes singular that was not, none more singular
    if (sector.closed)
      return std::abs(turns - 4) < std::max(1, std::abs(sector.quarter_turns - 4)) || turns == 4;
    const double angle = sector.angle / (std::numbers::pi / 2);
    return turns >= 1 &&
           std::abs(turns - angle) < std::max(kMostTradedTurn, std::abs(sector.quarter_turns - angle));
  }

  int removed(const Sector& gains, const Sector& loses) {
    const auto change = [&](const Sector& sector, int more) {
      return int{of(sector).singular(0)} - int{of(sector).singular(more)};
    };
    return gains.vertex == loses.vertex ? 0 : change(gains, 1) + change(loses, -1);
  }

  int removed(const Sector& sector, const Sector& other, int turns) {
    return turns > 0 ? removed(sector, other) : removed(other, sector);
  }

  std::vector<Trade> find_all() {
    std::vector<Trade> trades;
    for (size_t s = 0; s < topology_.sectors().size(); ++s) {
      const Sector& sector = topology_.sectors()[s];
      if (!of(sector).singular(0)) continue;
      for (const int turns : {1, -1}) {
        if (!holds(sector, turns)) continue;
        const auto accept = [&](const Sector& other, double) {
          return holds(other, -turns) && removed(sector, other, turns) > 0;
        };
        for (ShiftPath& path : topology_.nearest_several(sector, options_.reach, kPartners, accept)) {
          const double own_energy = energy_.own_energy(path);
          trades.push_back({std::move(path), static_cast<int>(s), turns, own_energy});
        }
      }
    }
    return trades;
  }

  // The trade that lowers energy + penalty * singular vertices most; null if none lowers it.
  const Trade* best_of(const std::vector<Trade>& trades) {
    const Trade* best = nullptr;
    double lowest = 0;
    for (const Trade& trade : trades) {
      const Sector& sector = topology_.sectors()[static_cast<size_t>(trade.sector)];
      const Sector& other = topology_.at(trade.path.front());
      const int fewer = removed(sector, other, trade.turns);
      if (fewer <= 0 || !holds(sector, trade.turns) || !holds(other, -trade.turns)) continue;
      const double change =
          energy_.change(trade.path, trade.turns, trade.own_energy) - options_.penalty * fewer;
      if (change >= lowest) continue;
      lowest = change;
      best = &trade;
    }
    return best;
  }

  void apply(const Trade& trade) {
    Sector& sector = topology_.sectors()[static_cast<size_t>(trade.sector)];
    of(sector).turns += trade.turns;
    of(topology_.at(trade.path.front())).turns -= trade.turns;
    energy_.shift(trade.path, trade.turns);
    if (trade.turns > 0) {
      topology_.move_turn(trade.path, sector);
    } else {
      topology_.return_turn(trade.path, sector);
    }
  }

  TradeOptions options_;
  FieldTopology topology_;
  FieldEnergy energy_;
  std::vector<VertexTurns> vertices_;
};

}  // namespace

int trade_singularities(CrossSurface& surface, std::vector<Sector>& sectors, const TradeOptions& options) {
  if (options.reach <= 0) return 0;
  TradeSearch search(surface, sectors, options);
  const int done = search.run();
  if (done > 0) relax_field(surface, search.shifted(), options.reach);
  return done;
}

}  // namespace neurframe
