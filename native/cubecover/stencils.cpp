#include "cubecover/stencils.hpp"

#include <algorithm>

namespace neurframe {

Stencils::Stencils(const ReducedMap& map, int active) : gradient_(Eigen::VectorXd::Zero(active)) {
  find_columns(map, active);
  find_pattern(active);
}

void Stencils::find_columns(const ReducedMap& map, int active) {
  for (const std::array<int, 4>& classes : map.class_of_corner) {
    const std::size_t first_entry = entries_.size();
    std::vector<int> columns;
    for (int row = 0; row < 12; ++row) {
      const int coordinate = 3 * at(classes, row / 3) + row % 3;
      for (int k = at(map.begin, coordinate); k < at(map.begin, coordinate + 1); ++k) {
        if (at(map.column, k) >= active) continue;
        columns.push_back(at(map.column, k));
        entries_.push_back({row, at(map.column, k), at(map.factor, k)});
      }
    }
    std::sort(columns.begin(), columns.end());
    columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
    for (std::size_t e = first_entry; e < entries_.size(); ++e) {
      const auto found = std::lower_bound(columns.begin(), columns.end(), entries_[e].local);
      entries_[e].local = static_cast<int>(found - columns.begin());
    }
    columns_.insert(columns_.end(), columns.begin(), columns.end());
    column_begin_.push_back(static_cast<int>(columns_.size()));
    entry_begin_.push_back(static_cast<int>(entries_.size()));
  }
}

void Stencils::find_pattern(int active) {
  std::vector<std::vector<int>> rows_of_column(static_cast<std::size_t>(active));
  const auto each_pair = [&](const auto& visit) {
    for (std::size_t t = 0; t + 1 < column_begin_.size(); ++t) {
      for (int i = column_begin_[t]; i < column_begin_[t + 1]; ++i) {
        for (int j = column_begin_[t]; j <= i; ++j) visit(at(columns_, i), at(columns_, j));
      }
    }
  };
  each_pair([&](int row, int column) { at(rows_of_column, column).push_back(row); });
  std::vector<Eigen::Triplet<double>> triplets;
  for (int column = 0; column < active; ++column) {
    std::vector<int>& rows = at(rows_of_column, column);
    std::sort(rows.begin(), rows.end());
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
    for (const int row : rows) triplets.emplace_back(row, column, 0.0);
  }
  hessian_.resize(active, active);
  hessian_.setFromTriplets(triplets.begin(), triplets.end());
  hessian_.makeCompressed();
  each_pair([&](int row, int column) {
    const int* rows = hessian_.innerIndexPtr();
    const int* begin = rows + hessian_.outerIndexPtr()[column];
    const int* end = rows + hessian_.outerIndexPtr()[column + 1];
    slots_.push_back(std::lower_bound(begin, end, row) - rows);
  });
  for (std::size_t t = 0; t + 1 < column_begin_.size(); ++t) {
    const std::int64_t count = column_begin_[t + 1] - column_begin_[t];
    slot_begin_.push_back(slot_begin_.back() + count * (count + 1) / 2);
  }
}

void Stencils::clear() {
  gradient_.setZero();
  std::fill_n(hessian_.valuePtr(), hessian_.nonZeros(), 0.0);
}

void Stencils::add(int tet, const TetGradient& gradient, const TetHessian& hessian) {
  const int first = at(column_begin_, tet);
  const int count = at(column_begin_, tet + 1) - first;
  scratch_.assign(static_cast<std::size_t>(count * count), 0.0);
  const int begin = at(entry_begin_, tet), end = at(entry_begin_, tet + 1);
  for (int e = begin; e < end; ++e) {
    const Entry& one = at(entries_, e);
    gradient_(at(columns_, first + one.local)) += one.factor * gradient(one.row);
    for (int f = begin; f < end; ++f) {
      const Entry& other = at(entries_, f);
      at(scratch_, count * one.local + other.local) +=
          one.factor * other.factor * hessian(one.row, other.row);
    }
  }
  std::int64_t slot = slot_begin_[static_cast<std::size_t>(tet)];
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j <= i; ++j)
      hessian_.valuePtr()[slots_[static_cast<std::size_t>(slot++)]] += at(scratch_, count * i + j);
  }
}

}  // namespace neurframe
