// Cells that are preimages of one and the same cell, where the map folds: union-find.
#pragma once

#include <utility>
#include <vector>

#include "core/extraction/grid_map.hpp"

namespace neurframe {

// Union-find whose members carry the rotation from their chart to that of the class.
template <int N>
class CellClasses {
 public:
  explicit CellClasses(std::size_t cells) : parent_(cells), to_parent_(cells), twisted_(cells, 0) {
    for (std::size_t i = 0; i < cells; ++i) parent_[i] = static_cast<int>(i);
  }

  struct Root {
    int cell;
    Rotation<N> rotation;  // from the chart asked for to that of the root
  };

  Root find(int cell) {
    path_.clear();
    for (int at = cell; parent_[static_cast<std::size_t>(at)] != at;
         at = parent_[static_cast<std::size_t>(at)]) {
      path_.push_back(static_cast<std::size_t>(at));
    }
    if (path_.empty()) return {cell, {}};
    const int root = parent_[path_.back()];
    Rotation<N> rotation;
    for (auto i = path_.rbegin(); i != path_.rend(); ++i) {  // compress, from the root down
      rotation = rotation * to_parent_[*i];
      to_parent_[*i] = rotation;
      parent_[*i] = root;
    }
    return {root, rotation};
  }

  // Declares a and b the same cell; `rotation` leads from the chart of a to that of b.  The lower number is
  // the root.
  void join(int a, int b, Rotation<N> rotation) {
    const Root x = find(a);
    const Root y = find(b);
    const Rotation<N> root_to_root = y.rotation * rotation * x.rotation.inverse();
    if (x.cell == y.cell) {
      // the cell comes back to itself turned: a singularity inside of it
      if (root_to_root != Rotation<N>{}) twisted_[static_cast<std::size_t>(x.cell)] = 1;
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
  std::vector<Rotation<N>> to_parent_;
  std::vector<char> twisted_;
  std::vector<std::size_t> path_;
};

}  // namespace neurframe
