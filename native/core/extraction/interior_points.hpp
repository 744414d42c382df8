// The integer points strictly inside the simplices, numbered, and found again in constant time.
//
// Most vertices of the result lie inside a simplex.  Numbering them by simplex, column and height needs no
// hashing, and the number does not depend on the threads.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/errors.hpp"
#include "core/extraction/lattice_points.hpp"
#include "core/parallel.hpp"

namespace neurframe {

template <int N>
class InteriorPoints {
 public:
  // Raises StageError for a map of more columns or points than can be numbered.
  InteriorPoints(const GridMap<N>& map, int threads) : map_(&map), boxes_(map.P.size()) {
    refuse_too_many_columns();
    const auto simplices = static_cast<std::int64_t>(map.P.size());
    columns_ =
        parallel_collect<Column>(simplices, threads, [&](std::int64_t begin, std::int64_t end, auto& out) {
          for (std::int64_t t = begin; t < end; ++t) add_simplex(static_cast<int>(t), out);
        });
    std::int64_t columns = 0;
    for (ColumnBox& box : boxes_) {
      box.first = columns;
      columns += box.columns();
    }
    for (Column& column : columns_) {
      const std::int32_t height = column.first;  // add_simplex left the height here
      column.first = static_cast<std::int32_t>(count_);
      count_ += height;
      if (count_ > most_cells) throw StageError("more than " + std::to_string(most_cells) + " grid points");
    }
  }

  std::int64_t count() const { return count_; }

  // The number of the integer point p (in the chart of simplex t), which must lie strictly inside simplex t.
  int number(int t, const FixedPoint<N>& p) const {
    const ColumnBox& box = boxes_[static_cast<std::size_t>(t)];
    std::int64_t place = 0;
    for (std::size_t k = 0; k + 1 < N; ++k)
      place = place * box.size[k] + (p[k] >> map_->fraction_bits) - box.low[k];
    const Column& column = columns_[static_cast<std::size_t>(box.first + place)];
    return static_cast<int>(column.first + (p[N - 1] >> map_->fraction_bits) - column.lowest);
  }

  // Calls visit(number, point) for the points inside simplex t, in ascending order.
  template <class Visit>
  void for_each(int t, const Visit& visit) const {
    const ColumnBox& box = boxes_[static_cast<std::size_t>(t)];
    const std::int64_t columns = box.columns();
    for (std::int64_t i = 0; i < columns; ++i) {
      const auto place = static_cast<std::size_t>(box.first + i);
      const std::int64_t end = place + 1 < columns_.size() ? columns_[place + 1].first : count_;
      LatticeIndex<N> index{};
      std::int64_t rest = i;
      for (std::size_t k = N - 1; k-- > 0; rest /= box.size[k]) index[k] = box.low[k] + rest % box.size[k];
      for (std::int64_t n = columns_[place].first; n < end; ++n) {
        index[N - 1] = columns_[place].lowest + n - columns_[place].first;
        visit(static_cast<int>(n), lattice_point<N>(index, map_->one(), 0));
      }
    }
  }

 private:
  // 32 bits are enough: coordinates stay below 2^24 cells.
  struct ColumnBox {
    std::int64_t first = 0;
    std::array<std::int32_t, N - 1> low{};
    std::array<std::int32_t, N - 1> size{};  // zero where the simplex has no lattice point in its box

    std::int64_t columns() const {
      std::int64_t product = 1;
      for (const std::int32_t entry : size) product *= entry;
      return product;
    }
  };
  struct Column {
    std::int32_t lowest;  // interior index
    std::int32_t first;   // its number
  };

  // Two GiB of columns.  Parameters of one wrong number span millions of cells: without this check they end
  // in the memory of the machine.
  void refuse_too_many_columns() const {
    constexpr double most_columns = 1 << 28;
    const double columns = column_count(*map_, 0);
    if (columns <= most_columns) return;
    throw StageError("the parameters span " + std::to_string(columns) + " columns of cells, allowed are " +
                     std::to_string(most_columns) + "; a coarser grid has fewer");
  }

  void add_simplex(int t, std::vector<Column>& out) {
    const LatticeBox<N> box = lattice_box(*map_, t, 0);
    if (map_->orientation[static_cast<std::size_t>(t)] == 0 || certainly_outside(*map_, t, box, 0)) return;
    ColumnBox& columns = boxes_[static_cast<std::size_t>(t)];
    for (std::size_t k = 0; k + 1 < N; ++k) {
      columns.low[k] = static_cast<std::int32_t>(box.low[k]);
      columns.size[k] = static_cast<std::int32_t>(box.high[k] - box.low[k] + 1);
    }
    const SimplexPlanes<N> planes(*map_, t);
    for_each_column<N>(planes, box, map_->one(), 0, [&](LatticeIndex<N> index, ColumnRange column) {
      const auto inside = [&](std::int64_t last) {
        if (column.certainly_inside(last)) return true;
        index[N - 1] = last;
        return all_positive(planes.signs(lattice_point<N>(index, map_->one(), 0)));
      };
      while (column.begin < column.end && !inside(column.begin)) ++column.begin;
      while (column.begin < column.end && !inside(column.end - 1)) --column.end;
      out.push_back({static_cast<std::int32_t>(column.begin),
                     static_cast<std::int32_t>(std::max<std::int64_t>(0, column.end - column.begin))});
    });
  }

  const GridMap<N>* map_;
  std::vector<ColumnBox> boxes_;
  std::vector<Column> columns_;
  std::int64_t count_ = 0;
};

}  // namespace neurframe
