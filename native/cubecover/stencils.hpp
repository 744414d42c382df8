// Assembling gradient and Hessian of an energy of the tets over the free columns of the map, with a sparsity
// pattern that is found once.
#pragma once

#include "cubecover/reduced_map.hpp"
#include "cubecover/spd_solver.hpp"

namespace neurframe {

using TetGradient = Eigen::Matrix<double, 12, 1>;  // by coordinate i of corner c, at 3 c + i
using TetHessian = Eigen::Matrix<double, 12, 12>;

class Stencils {
 public:
  // Columns from `active` on are constants.
  Stencils(const ReducedMap& map, int active);

  void clear();
  void add(int tet, const TetGradient& gradient, const TetHessian& hessian);

  const Eigen::VectorXd& gradient() const { return gradient_; }
  const SparseMatrix& hessian() const { return hessian_; }  // lower triangle
  SparseMatrix& hessian() { return hessian_; }

 private:
  struct Entry {
    int row;    // of the 12
    int local;  // index into the tet's columns
    double factor;
  };

  void find_columns(const ReducedMap& map, int active);
  void find_pattern(int active);

  std::vector<int> column_begin_{0};
  std::vector<int> columns_;  // of each tet, ascending
  std::vector<int> entry_begin_{0};
  std::vector<Entry> entries_;
  std::vector<std::int64_t> slot_begin_{0};
  std::vector<std::int64_t> slots_;  // of each tet's lower triangle, into the values of hessian_
  std::vector<double> scratch_;      // the Hessian of one tet over its columns
  Eigen::VectorXd gradient_;
  SparseMatrix hessian_;
};

}  // namespace neurframe
