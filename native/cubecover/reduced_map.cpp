#include "cubecover/reduced_map.hpp"

#include <numeric>

#include "core/errors.hpp"

namespace neurframe {

namespace {

std::vector<int> number_free_unknowns(const Elimination& elimination, ReducedMap& map) {
  std::vector<int> column_of(static_cast<std::size_t>(elimination.size()), -1);
  for (const bool integers : {false, true}) {
    for (int unknown = 0; unknown < elimination.size(); ++unknown) {
      if (!elimination.is_free(unknown) || elimination.is_integer(unknown) != integers) continue;
      at(column_of, unknown) = static_cast<int>(map.unknown_of_column.size());
      map.unknown_of_column.push_back(unknown);
    }
    if (!integers) map.real_count = static_cast<int>(map.unknown_of_column.size());
  }
  map.integer_count = static_cast<int>(map.unknown_of_column.size()) - map.real_count;
  return column_of;
}

// Integers that no coordinate depends on (translations of faces that became redundant) are left out.
std::vector<char> used_unknowns(int rows, Elimination& elimination) {
  std::vector<char> used(static_cast<std::size_t>(elimination.size()), 0);
  for (int row = 0; row < rows; ++row) {
    for (const Term& term : elimination.resolve(row)) at(used, term.unknown) = 1;
  }
  return used;
}

}  // namespace

ReducedMap reduce(const CombedField& field, Elimination& elimination) {
  const int rows = 3 * field.classes.count();
  const std::vector<char> used = used_unknowns(rows, elimination);
  for (int unknown = rows; unknown < elimination.size(); ++unknown) {
    if (elimination.is_free(unknown) && !at(used, unknown))
      elimination.require_zero({{unknown, Rational(1)}});
  }
  ReducedMap map;
  map.class_of_corner = field.classes.of_corner;
  const std::vector<int> column_of = number_free_unknowns(elimination, map);
  map.begin.push_back(0);
  for (int row = 0; row < rows; ++row) {
    for (const Term& term : elimination.resolve(row)) {
      map.column.push_back(at(column_of, term.unknown));
      map.coefficient.push_back(term.coefficient);
      map.factor.push_back(term.coefficient.value());
      map.denominator = std::lcm(map.denominator, term.coefficient.denominator);
    }
    map.begin.push_back(static_cast<int>(map.column.size()));
  }
  return map;
}

std::vector<Rational> integer_row(const ReducedMap& map, const Combination& resolved) {
  std::vector<Rational> row(static_cast<std::size_t>(map.integer_count));
  for (const Term& term : resolved) {
    for (int i = 0; i < map.integer_count; ++i) {
      if (at(map.unknown_of_column, map.real_count + i) == term.unknown) at(row, i) = term.coefficient;
    }
  }
  return row;
}

Eigen::VectorXd evaluate(const ReducedMap& map, const Eigen::VectorXd& columns) {
  Eigen::VectorXd rows = Eigen::VectorXd::Zero(map.row_count());
  for (int row = 0; row < map.row_count(); ++row) {
    for (int k = at(map.begin, row); k < at(map.begin, row + 1); ++k) {
      rows(row) += at(map.factor, k) * columns(at(map.column, k));
    }
  }
  return rows;
}

Eigen::Matrix<double, 3, 4> corner_parameters(const ReducedMap& map, const Eigen::VectorXd& rows, int tet) {
  Eigen::Matrix<double, 3, 4> parameters;
  for (int corner = 0; corner < 4; ++corner) {
    parameters.col(corner) = rows.segment<3>(3 * at(at(map.class_of_corner, tet), corner));
  }
  return parameters;
}

}  // namespace neurframe
