// Cells that are preimages of one and the same cell, where the map folds.
//
// A fold shows a cell centre several times, with signs +1, -1, +1 in the simplest case.  Walks that return to
// another preimage tell which ones belong together.  The signs of a class add up to the number of hexes that
// are really there: one for an honest cell, none where a fold only looks like one.
#pragma once

#include <unordered_map>
#include <utility>
#include <vector>

#include "hexex/grid_vertices.hpp"
#include "hexex/trace_cells.hpp"

namespace neurframe {

// Union-find whose members carry the rotation from their chart to that of the class.
class CellClasses {
 public:
  explicit CellClasses(std::size_t cells) : parent_(cells), to_parent_(cells), twisted_(cells, 0) {
    for (std::size_t i = 0; i < cells; ++i) parent_[i] = static_cast<int>(i);
  }

  struct Root {
    int cell;
    OctahedralRotation rotation;  // from the chart asked for to that of the root
  };

  Root find(int cell) {
    path_.clear();
    for (int at = cell; parent_[static_cast<std::size_t>(at)] != at;
         at = parent_[static_cast<std::size_t>(at)]) {
      path_.push_back(static_cast<std::size_t>(at));
    }
    if (path_.empty()) return {cell, {}};
    const int root = parent_[path_.back()];
    OctahedralRotation rotation;
    for (auto i = path_.rbegin(); i != path_.rend(); ++i) {  // compress, from the root down
      rotation = rotation * to_parent_[*i];
      to_parent_[*i] = rotation;
      parent_[*i] = root;
    }
    return {root, rotation};
  }

  // Declares a and b the same cell; `rotation` leads from the chart of a to that of b.  The lower number is
  // the root.
  void join(int a, int b, OctahedralRotation rotation) {
    const Root x = find(a);
    const Root y = find(b);
    const OctahedralRotation root_to_root = y.rotation * rotation * x.rotation.inverse();
    if (x.cell == y.cell) {
      // the cell comes back to itself turned: a singularity inside of it
      if (!root_to_root.is_identity()) twisted_[static_cast<std::size_t>(x.cell)] = 1;
      return;
    }
    const bool x_below = x.cell > y.cell;
    const auto child = static_cast<std::size_t>(x_below ? x.cell : y.cell);
    const auto parent = static_cast<std::size_t>(x_below ? y.cell : x.cell);
    parent_[child] = static_cast<int>(parent);
    to_parent_[child] = x_below ? root_to_root : root_to_root.inverse();
    twisted_[parent] = static_cast<char>(twisted_[parent] | twisted_[child]);
  }

  bool twisted(int root) const { return twisted_[static_cast<std::size_t>(root)] != 0; }

 private:
  std::vector<int> parent_;
  std::vector<OctahedralRotation> to_parent_;
  std::vector<char> twisted_;
  std::vector<std::size_t> path_;
};

inline CellClasses classify_cells(const TracedCells& traced) {
  CellClasses classes(traced.cells.size());
  if (traced.centres.empty()) return classes;
  std::unordered_map<PlaceKey, int, PlaceKeyHash> cell_at;
  for (const NamedCentre& centre : traced.centres) {
    if (!centre.is_own) continue;
    const auto [found, added] = cell_at.try_emplace(centre.key, centre.cell);
    const OctahedralRotation from = traced.cells[static_cast<std::size_t>(centre.cell)].frame;
    const OctahedralRotation to = traced.cells[static_cast<std::size_t>(found->second)].frame;
    if (!added) classes.join(centre.cell, found->second, to * from.inverse());
  }
  bool returns = false;
  for (const NamedCentre& centre : traced.centres) returns = returns || !centre.is_own;
  if (!returns) return classes;
  // cells strictly inside a tet have their own tet and centre for a name
  for (std::size_t c = 0; c < traced.cells.size(); ++c) {
    cell_at.try_emplace({traced.cells[c].tet, traced.cells[c].centre}, static_cast<int>(c));
  }
  for (const NamedCentre& centre : traced.centres) {
    if (centre.is_own) continue;
    const auto found = cell_at.find(centre.key);
    // the place is known, but under this perturbation none of its tets holds the centre: it is nobody's cell
    if (found == cell_at.end()) continue;
    const OctahedralRotation to = traced.cells[static_cast<std::size_t>(found->second)].frame;
    classes.join(centre.cell, found->second, to * centre.rotation);
  }
  return classes;
}

}  // namespace neurframe
