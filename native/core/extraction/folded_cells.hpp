// The cells that a walk could not settle: folds and flat simplices.
//
// A fold shows a cell centre several times, with signs +1, -1, +1 in the simplest case, and a walk from one
// of them to a corner may return to another.  All that are linked so form a class; its signs add up to the
// number of hexes that are really there: one for an honest cell, none where a fold only looks like one.  Each
// corner is reached from at least one preimage, and where it is reached from several, these are one vertex.
// All members of a class walk with one and the same perturbation: only then is every walk the reverse of
// another.
#pragma once

#include <algorithm>
#include <array>
#include <unordered_map>
#include <vector>

#include "core/extraction/cell_classes.hpp"
#include "core/extraction/grid_vertices.hpp"
#include "core/extraction/trace_cells.hpp"

namespace neurframe {

// What the preimages of one cell know of it, in the chart of the root of its class.
template <int N>
struct CellSummary {
  int sign = 0;
  int members = 0;
  std::array<int, cell_corners<N>> corners = no_corners();
  std::array<int, cell_corners<N>> failures{};  // code of a walk that failed, where none arrived

  static std::array<int, cell_corners<N>> no_corners() {
    std::array<int, cell_corners<N>> corners;
    corners.fill(-1);
    return corners;
  }
};

template <int N>
class FoldedCells {
 public:
  FoldedCells(const GridMap<N>& map, const InteriorPoints<N>& points, const TracedCells<N>& traced,
              GridVertices<N>& vertices)
      : map_(map),
        points_(points),
        traced_(traced),
        vertices_(vertices),
        search_(map),
        classes_(traced.cells.size()) {
    for (std::size_t c = 0; c < traced.cells.size(); ++c) {
      if (is_unsettled(traced.cells[c])) members_[static_cast<int>(c)].push_back(static_cast<int>(c));
    }
    join_cells_of_one_place();
    if (members_.empty()) return;
    for (std::size_t c = 0; c < traced.cells.size(); ++c) {
      cell_at_.try_emplace({traced.cells[c].simplex, traced.cells[c].centre}, static_cast<int>(c));
    }
    join_linked_cells();
  }

  // The root of a cell's class: the cell with the lowest number.
  int root(int cell) { return classes_.find(cell).cell; }
  // True for the members of all classes that need more than a cell's own walks.
  bool is_folded(int cell) { return !members_.empty() && members_.count(root(cell)) != 0; }
  bool twisted(int root) const { return classes_.twisted(root); }

  // Joins the vertices that turn out to be one.
  CellSummary<N> summary(int root) {
    CellSummary<N> found;
    for (const int member : members_.at(root)) {
      const Rotation<N> to_root = classes_.find(member).rotation;
      for_each_preimage(member, [&](const PreimageVisit<N>& visit, Rotation<N> Q) {
        found.sign += map_.orientation[static_cast<std::size_t>(visit.simplex)];
        ++found.members;
        for (int corner = 0; corner < cell_corners<N>; ++corner) {
          const auto place =
              static_cast<std::size_t>(turned_corner<N>(to_root * visit.rotation.inverse(), corner));
          note_walk(walk_diagonal(map_, visit.simplex, visit.point, corner, Q), place, found);
        }
      });
    }
    return found;
  }

 private:
  static bool is_unsettled(const Cell<N>& cell) {
    bool returned = false;
    for (const int code : cell.corners) returned = returned || code == failed_corner(WalkEnd::returned);
    return cell.sign <= 0 || returned;
  }

  // Several owners of one place are a defect: the charts around it do not fit together.
  void join_cells_of_one_place() {
    std::unordered_map<PlaceKey<N>, int, PlaceKeyHash> owner;
    for (const NamedCentre<N>& centre : traced_.centres) {
      const auto [found, added] = owner.try_emplace(centre.key, centre.cell);
      if (added) continue;
      const Rotation<N> from = traced_.cells[static_cast<std::size_t>(centre.cell)].frame;
      const Rotation<N> to = traced_.cells[static_cast<std::size_t>(found->second)].frame;
      join(centre.cell, found->second, to * from.inverse());
    }
  }

  // Walks from all members again and again, until no class meets a new one.
  void join_linked_cells() {
    std::vector<int> waiting;
    for (const auto& [root, members] : members_) waiting.push_back(root);
    std::sort(waiting.begin(), waiting.end());
    for (std::size_t next = 0; next < waiting.size(); ++next) {
      const int root = waiting[next];
      if (members_.count(root) == 0) continue;  // joined to another class meanwhile
      std::vector<Link> links;
      for (const int member : members_.at(root)) collect_links(member, links);
      bool grown = false;
      for (const Link& link : links) grown = join(link.from, link.to, link.rotation) || grown;
      if (grown) waiting.push_back(classes_.find(root).cell);
    }
  }

  struct Link {
    int from;
    int to;
    Rotation<N> rotation;
  };

  void collect_links(int member, std::vector<Link>& links) {
    for_each_preimage(member, [&](const PreimageVisit<N>& visit, Rotation<N> Q) {
      for (int corner = 0; corner < cell_corners<N>; ++corner) {
        const WalkResult<N> walk = walk_diagonal(map_, visit.simplex, visit.point, corner, Q);
        if (walk.end == WalkEnd::returned) add_link(member, walk, walk.rotation * visit.rotation, links);
      }
    });
  }

  // The cell at the place that a walk returned to, which may be kept at another simplex of that place.
  void add_link(int member, const WalkResult<N>& walk, Rotation<N> rotation, std::vector<Link>& links) {
    for (const PreimageVisit<N>& visit : search_.visits(walk.simplex, walk.point)) {
      const auto found = cell_at_.find({visit.simplex, visit.point});
      if (found == cell_at_.end()) continue;
      links.push_back({member, found->second, visit.rotation * rotation});
      return;
    }
  }

  // False when a and b are in one class already.
  bool join(int a, int b, Rotation<N> rotation) {
    const int x = classes_.find(a).cell;
    const int y = classes_.find(b).cell;
    classes_.join(a, b, rotation);
    if (x == y) return false;
    const int root = std::min(x, y);
    const int child = std::max(x, y);
    std::vector<int>& members = members_.try_emplace(root, std::vector<int>{root}).first->second;
    const auto joining = members_.try_emplace(child, std::vector<int>{child}).first;
    members.insert(members.end(), joining->second.begin(), joining->second.end());
    members_.erase(child);
    return true;
  }

  // Calls visit(preimage, Q) for the simplices that hold the centre of a member under the perturbation of its
  // class.
  template <class Visit>
  void for_each_preimage(int member, const Visit& visit) {
    const Cell<N>& cell = traced_.cells[static_cast<std::size_t>(member)];
    const typename CellClasses<N>::Root root = classes_.find(member);
    const Rotation<N> Q = root.rotation.inverse() * traced_.cells[static_cast<std::size_t>(root.cell)].frame;
    const std::vector<PreimageVisit<N>> visits = search_.visits(cell.simplex, cell.centre);
    for (const PreimageVisit<N>& here : visits) {
      if (map_.orientation[static_cast<std::size_t>(here.simplex)] == 0) continue;
      const FacetSigns<N> signs = exact_facet_signs(map_, here.simplex, here.point);
      const Rotation<N> turned = here.rotation * Q;
      if (perturbed_inside(map_, here.simplex, here.point, signs, turned)) visit(here, turned);
    }
  }

  void note_walk(const WalkResult<N>& walk, std::size_t place, CellSummary<N>& found) {
    if (walk.end == WalkEnd::reached) {
      const int vertex = vertex_at(map_, points_, search_, walk.simplex, walk.point, vertices_);
      if (found.corners[place] < 0) found.corners[place] = vertex;
      vertices_.join(found.corners[place], vertex);
    } else if (walk.end != WalkEnd::returned) {
      found.failures[place] = failed_corner(walk.end);
    }
  }

  const GridMap<N>& map_;
  const InteriorPoints<N>& points_;
  const TracedCells<N>& traced_;
  GridVertices<N>& vertices_;
  PreimageSearch<N> search_;
  CellClasses<N> classes_;
  std::unordered_map<int, std::vector<int>> members_;  // of the classes that are not settled, by root
  std::unordered_map<PlaceKey<N>, int, PlaceKeyHash> cell_at_;
};

}  // namespace neurframe
