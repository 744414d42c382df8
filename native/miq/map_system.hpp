// Assembly of energies of the map over the reduced variables.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <memory>
#include <vector>

#include "miq/cross_surface.hpp"
#include "miq/reduced_variables.hpp"

namespace neurframe {

using Matrix46 = Eigen::Matrix<double, 4, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using SparseMatrix = Eigen::SparseMatrix<double>;
using SparseFactor = Eigen::SimplicialLDLT<SparseMatrix, Eigen::Lower, Eigen::AMDOrdering<int>>;

// The Jacobian of the map on each triangle, (du/dx, du/dy, dv/dx, dv/dy), against the triangle's cross scaled
// by the target edge length: the identity is the ideal map.  Corner parameters are ordered u0 v0 u1 v1 u2 v2.
struct TriangleShapes {
  std::vector<Matrix46> jacobian;
  std::vector<double> weight;  // triangle area in target cells
};
TriangleShapes triangle_shapes(const CrossSurface& surface, double edge_length);

// Which of the reduced variables are free: the integers may be held.  Real variables come first.
class MapSystem {
 public:
  MapSystem(const ReducedVariables& variables, int triangle_count, bool integers_free);

  int size() const { return size_; }

  // corner parameters of triangle f
  Vector6 corner_parameters(int f, const Eigen::VectorXd& real, const Eigen::VectorXd& integer) const;

  // Lower half of the sum of R_f^T H_f R_f, and the sum of R_f^T g_f, with R_f the triangle's rows.
  void assemble(const std::vector<Eigen::Matrix<double, 6, 6>>& hessians,
                const std::vector<Vector6>& gradients);
  void assemble_gradient(const std::vector<Vector6>& gradients);
  const SparseMatrix& matrix() const { return matrix_; }
  const Eigen::VectorXd& gradient() const { return gradient_; }

 private:
  struct Entry {
    int slot;
    short local;  // 6 i + j
    float factor;
  };
  void build_pattern();

  const ReducedVariables& variables_;
  int triangle_count_;
  int size_;
  std::vector<std::vector<std::pair<int, int>>> rows_;  // per coordinate: free variable and factor
  SparseMatrix matrix_;
  Eigen::VectorXd gradient_;
  std::vector<Entry> entries_;
  std::vector<size_t> first_entry_;  // per triangle
};

// The quadratic form sum of stiffness * weight * |J|^2 over all triangles, split into real and integer
// variables.
struct PoissonSystem {
  std::unique_ptr<SparseFactor> real_factor = std::make_unique<SparseFactor>();
  SparseMatrix real_integer;  // mixed block
  Eigen::MatrixXd schur;      // integer variables after elimination of the real ones
  // change of the real variables that follows a change of the integers
  Eigen::VectorXd real_response(const Eigen::VectorXd& integer_change) const;
};
PoissonSystem poisson_system(const ReducedVariables& variables, MapSystem& full, const TriangleShapes& shapes,
                             const std::vector<double>& stiffness);

}  // namespace neurframe
