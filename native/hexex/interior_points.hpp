// The integer points strictly inside the tets, numbered, and found again in constant time.
//
// Most vertices of a hex mesh lie inside a tet.  Numbering them by tet, column and height needs no hashing,
// and the number does not depend on the threads.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/parallel.hpp"
#include "hexex/lattice_points.hpp"

namespace neurframe {

class InteriorPoints {
 public:
  InteriorPoints(const GridMap& map, int threads) : map_(&map), tets_(map.P.size()) {
    const auto tets = static_cast<std::int64_t>(map.P.size());
    columns_ = parallel_collect<Column>(tets, threads, [&](std::int64_t begin, std::int64_t end, auto& out) {
      for (std::int64_t t = begin; t < end; ++t) add_tet(static_cast<int>(t), out);
    });
    std::int64_t columns = 0;
    for (TetColumns& tet : tets_) {
      tet.first = columns;
      columns += tet.nx * tet.ny;
    }
    for (Column& column : columns_) {
      const std::int64_t height = column.first;  // add_tet left the height here
      column.first = count_;
      count_ += height;
    }
    if (count_ > most_points) throw StageError("more than " + std::to_string(most_points) + " grid points");
  }

  std::int64_t count() const { return count_; }

  // The number of the integer point p (in the chart of tet t), which must lie strictly inside tet t.
  int number(int t, const FixedPoint3& p) const {
    const TetColumns& tet = tets_[static_cast<std::size_t>(t)];
    const std::int64_t x = (p[0] >> map_->fraction_bits) - tet.x;
    const std::int64_t y = (p[1] >> map_->fraction_bits) - tet.y;
    const Column& column = columns_[static_cast<std::size_t>(tet.first + x * tet.ny + y)];
    return static_cast<int>(column.first + (p[2] >> map_->fraction_bits) - column.z);
  }

  // Calls visit(number, point) for the points inside tet t, in ascending order.
  template <class Visit>
  void for_each(int t, const Visit& visit) const {
    const TetColumns& tet = tets_[static_cast<std::size_t>(t)];
    for (std::int64_t i = 0; i < tet.nx * tet.ny; ++i) {
      const auto place = static_cast<std::size_t>(tet.first + i);
      const std::int64_t end = place + 1 < columns_.size() ? columns_[place + 1].first : count_;
      const Column& column = columns_[place];
      for (std::int64_t n = column.first; n < end; ++n) {
        const std::array<std::int64_t, 3> index{tet.x + i / tet.ny, tet.y + i % tet.ny,
                                                column.z + n - column.first};
        visit(static_cast<int>(n),
              FixedPoint3{index[0] * map_->one(), index[1] * map_->one(), index[2] * map_->one()});
      }
    }
  }

 private:
  static constexpr std::int64_t most_points = (std::int64_t{1} << 31) - 1;

  struct TetColumns {
    std::int64_t first = 0;
    std::int64_t x = 0;
    std::int64_t y = 0;
    std::int64_t nx = 0;
    std::int64_t ny = 0;
  };
  struct Column {
    std::int64_t z;      // lowest interior index
    std::int64_t first;  // its number
  };

  void add_tet(int t, std::vector<Column>& out) {
    TetColumns& tet = tets_[static_cast<std::size_t>(t)];
    const LatticeBox box = lattice_box(*map_, t, 0);
    if (box.empty() || map_->orientation[static_cast<std::size_t>(t)] == 0) return;
    tet = {0, box.low[0], box.low[1], box.high[0] - box.low[0] + 1, box.high[1] - box.low[1] + 1};
    const TetPlanes planes(*map_, t);
    for_each_column(planes, box, map_->one(), 0, [&](std::int64_t x, std::int64_t y, Interval column) {
      const auto inside = [&](std::int64_t z) {
        return all_positive(planes.signs({x * map_->one(), y * map_->one(), z * map_->one()}));
      };
      while (column.begin < column.end && !inside(column.begin)) ++column.begin;
      while (column.begin < column.end && !inside(column.end - 1)) --column.end;
      out.push_back({column.begin, std::max<std::int64_t>(0, column.end - column.begin)});
    });
  }

  const GridMap* map_;
  std::vector<TetColumns> tets_;
  std::vector<Column> columns_;
  std::int64_t count_ = 0;
};

}  // namespace neurframe
