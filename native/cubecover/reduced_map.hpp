// The map as a linear function of the free unknowns that the elimination left: seams, planes and singular
// lines hold exactly for whatever values those take.
#pragma once

#include <Eigen/Dense>
#include <cstdint>
#include <vector>

#include "core/fixed_point.hpp"
#include "cubecover/constraints.hpp"

namespace neurframe {

struct ReducedMap {
  int real_count = 0;  // columns [0, real_count) are real, the others integer
  int integer_count = 0;
  std::vector<int> unknown_of_column;
  std::vector<int> begin;  // terms of row r, the coordinate r % 3 of corner class r / 3
  std::vector<int> column;
  std::vector<Rational> coefficient;
  std::vector<double> factor;                       // the coefficients as doubles
  std::int64_t denominator = 1;                     // least common one of the coefficients
  std::vector<std::array<int, 4>> class_of_corner;  // per tet

  int column_count() const { return real_count + integer_count; }
  int row_count() const { return static_cast<int>(begin.size()) - 1; }
};

ReducedMap reduce(const CombedField& field, Elimination& elimination);

// The combination of integer columns (index minus real_count) that a resolved combination is; it must have no
// real unknowns.
std::vector<Rational> integer_row(const ReducedMap& map, const Combination& resolved);

// Coordinates of all corner classes, three each.
Eigen::VectorXd evaluate(const ReducedMap& map, const Eigen::VectorXd& columns);

// Parameters of a tet's corners, one column each.
Eigen::Matrix<double, 3, 4> corner_parameters(const ReducedMap& map, const Eigen::VectorXd& rows, int tet);

}  // namespace neurframe
