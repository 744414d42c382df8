// Where the quarter turns of the field sit: matchings shifted along edges move them from vertex to vertex.
#pragma once

#include <functional>
#include <vector>

#include "miq/matching.hpp"

namespace neurframe {

// Half-edges along which matchings are to be shifted, each running towards the vertex that gains.
using ShiftPath = std::vector<int>;

// The quarter turns of every sector, and the means to move one of them from a sector to another.
class FieldTopology {
 public:
  // keeps references to both
  FieldTopology(CrossSurface& surface, std::vector<Sector>& sectors);

  const CrossSurface& surface() const { return surface_; }
  std::vector<Sector>& sectors() { return sectors_; }
  Sector& at(int corner) { return sectors_[static_cast<size_t>(at_corner_[static_cast<size_t>(corner)])]; }

  // What the search is told of a closed sector at this distance along edges: go on, or end here.
  using Accept = std::function<bool(const Sector& sector, double distance)>;

  // Dijkstra's algorithm along edges from the sector over closed sectors to the nearest one that is accepted;
  // the path runs towards the sector.  Empty if there is none within `reach`.
  ShiftPath nearest(const Sector& from, double reach, const Accept& accept);

  // The same for the nearest `most` sectors that are accepted, which may have features: paths end there, too.
  std::vector<ShiftPath> nearest_several(const Sector& from, double reach, int most, const Accept& accept);

  // One quarter turn more for the sector that the path runs to, one less for the one it comes from; the
  // vertices on the path are noted in shifted().
  void move_turn(const ShiftPath& path, Sector& gains);
  // the other way round
  void return_turn(const ShiftPath& path, Sector& loses);

  const std::vector<int>& shifted() const { return shifted_; }

 private:
  void shift(const ShiftPath& path, int turns);
  std::vector<ShiftPath> search(const Sector& from, double reach, int most, bool features,
                                const Accept& accept);

  CrossSurface& surface_;
  std::vector<Sector>& sectors_;
  std::vector<int> at_corner_;
  std::vector<int> shifted_;
};

// Gives every sector between features the quarter turns that its angle can hold: those that the field has if
// they are at least one and not more than 67.5 degrees from the angle, else the nearest number of them.  What
// it lacks or has too much goes to or comes from the interior vertices: the nearest singular vertex of the
// opposite sign within `reach`, else a new one beside it.  Closed sectors get `closed_minimum` at least.
// Returns the number of quarter turns moved.
int repair_sectors(FieldTopology& topology, int closed_minimum, double reach);

// Cancels pairs of singular vertices of opposite sign that are at most `reach` apart along edges off the
// features, nearest first.  Returns the number of pairs.
int cancel_dipoles(FieldTopology& topology, double reach);

struct TradeOptions {
  double reach;    // along edges, between the two sectors
  double penalty;  // energy that a singular vertex less may cost
};

// Moves quarter turns between sectors, features included, one after the other where (Dirichlet energy of the
// smoothest crosses) + penalty * (singular vertices) falls most by it, until it falls no more; then relaxes
// the crosses around.  Returns the number of turns moved.
int trade_singularities(CrossSurface& surface, std::vector<Sector>& sectors, const TradeOptions& options);

// Moves interior singular vertices that are less than `clearance` from a feature to the nearest vertex that
// far away, or to the farthest one within reach where the features leave less room.  A map whose singularity
// stands in the tip between two features has no room for the cells between them.  Returns how many moved.
int retreat_from_features(FieldTopology& topology, double clearance);

}  // namespace neurframe
