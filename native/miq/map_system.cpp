#include "miq/map_system.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>

#include "core/errors.hpp"

namespace neurframe {

TriangleShapes triangle_shapes(const CrossSurface& surface, double edge_length) {
  TriangleShapes shapes;
  for (int f = 0; f < surface.triangle_count(); ++f) {
    const double length = edge_length * surface.size[static_cast<size_t>(f)];
    const Eigen::Vector3d second = surface.second_axis(f);
    Eigen::Matrix2d edges;
    edges << surface.along(3 * f).dot(surface.axis[static_cast<size_t>(f)]),
        -surface.along(3 * f + 2).dot(surface.axis[static_cast<size_t>(f)]), surface.along(3 * f).dot(second),
        -surface.along(3 * f + 2).dot(second);
    edges /= length;
    const Eigen::Matrix2d inverse = edges.inverse();
    Matrix46 jacobian = Matrix46::Zero();
    for (int parameter = 0; parameter < 2; ++parameter) {
      for (int k = 0; k < 2; ++k) {
        jacobian(2 * parameter + k, 2 + parameter) = inverse(0, k);
        jacobian(2 * parameter + k, 4 + parameter) = inverse(1, k);
        jacobian(2 * parameter + k, parameter) = -inverse(0, k) - inverse(1, k);
      }
    }
    shapes.jacobian.push_back(jacobian);
    shapes.weight.push_back(edges.determinant() / 2);
  }
  return shapes;
}

MapSystem::MapSystem(const ReducedVariables& variables, int triangle_count, bool integers_free)
    : variables_(variables),
      triangle_count_(triangle_count),
      size_(variables.real_count + (integers_free ? variables.integer_count : 0)) {
  for (const ReducedCoordinate& coordinate : variables.coordinates) {
    std::vector<std::pair<int, int>> row;
    if (coordinate.real >= 0) row.emplace_back(coordinate.real, coordinate.sign);
    if (integers_free) {
      for (const auto& [index, factor] : coordinate.integers)
        row.emplace_back(variables.real_count + index, factor);
    }
    rows_.push_back(std::move(row));
  }
  build_pattern();
}

void MapSystem::build_pattern() {
  const auto row = [&](int f, int local) -> const auto& {
    const auto corner = static_cast<size_t>(3 * f + local / 2);
    return rows_[static_cast<size_t>(2 * variables_.sector[corner] + local % 2)];
  };
  const auto for_each_pair = [&](int f, const auto& visit) {
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j < 6; ++j) {
        for (const auto& [a, factor_a] : row(f, i)) {
          for (const auto& [b, factor_b] : row(f, j)) {
            if (a >= b) visit(a, b, 6 * i + j, factor_a * factor_b);
          }
        }
      }
    }
  };
  std::vector<Eigen::Triplet<double>> triplets;
  for (int f = 0; f < triangle_count_; ++f) {
    for_each_pair(f, [&](int a, int b, int, int) { triplets.emplace_back(a, b, 0.0); });
  }
  matrix_.resize(size_, size_);
  matrix_.setFromTriplets(triplets.begin(), triplets.end());
  for (int f = 0; f < triangle_count_; ++f) {
    first_entry_.push_back(entries_.size());
    for_each_pair(f, [&](int a, int b, int local, int factor) {
      const int* begin = matrix_.innerIndexPtr() + matrix_.outerIndexPtr()[b];
      const int* end = matrix_.innerIndexPtr() + matrix_.outerIndexPtr()[b + 1];
      const auto slot = std::lower_bound(begin, end, a) - matrix_.innerIndexPtr();
      entries_.push_back({static_cast<int>(slot), static_cast<short>(local), static_cast<float>(factor)});
    });
  }
  first_entry_.push_back(entries_.size());
}

Vector6 MapSystem::corner_parameters(int f, const Eigen::VectorXd& real,
                                     const Eigen::VectorXd& integer) const {
  Vector6 out;
  for (int local = 0; local < 6; ++local) {
    const auto corner = static_cast<size_t>(3 * f + local / 2);
    const ReducedCoordinate& coordinate =
        variables_.coordinates[static_cast<size_t>(2 * variables_.sector[corner] + local % 2)];
    double value = coordinate.real >= 0 ? coordinate.sign * real[coordinate.real] : 0.0;
    for (const auto& [index, factor] : coordinate.integers) value += factor * integer[index];
    out[local] = value;
  }
  return out;
}

void MapSystem::assemble(const std::vector<Eigen::Matrix<double, 6, 6>>& hessians,
                         const std::vector<Vector6>& gradients) {
  std::fill_n(matrix_.valuePtr(), matrix_.nonZeros(), 0.0);
  for (size_t f = 0; f < static_cast<size_t>(triangle_count_); ++f) {
    const double* hessian = hessians[f].data();
    for (size_t e = first_entry_[f]; e < first_entry_[f + 1]; ++e) {
      matrix_.valuePtr()[entries_[e].slot] +=
          static_cast<double>(entries_[e].factor) * hessian[entries_[e].local];
    }
  }
  assemble_gradient(gradients);
}

void MapSystem::assemble_gradient(const std::vector<Vector6>& gradients) {
  gradient_.setZero(size_);
  for (size_t f = 0; f < static_cast<size_t>(triangle_count_); ++f) {
    for (size_t local = 0; local < 6; ++local) {
      const auto coordinate = static_cast<size_t>(2 * variables_.sector[3 * f + local / 2]) + local % 2;
      for (const auto& [index, factor] : rows_[coordinate]) {
        gradient_[index] += factor * gradients[f][static_cast<Eigen::Index>(local)];
      }
    }
  }
}

Eigen::VectorXd PoissonSystem::real_response(const Eigen::VectorXd& integer_change) const {
  return -real_factor->solve(Eigen::VectorXd(real_integer * integer_change));
}

PoissonSystem poisson_system(const ReducedVariables& variables, MapSystem& full, const TriangleShapes& shapes,
                             const std::vector<double>& stiffness) {
  const auto count = shapes.weight.size();
  std::vector<Eigen::Matrix<double, 6, 6>> hessians(count);
  for (size_t f = 0; f < count; ++f) {
    hessians[f] = stiffness[f] * shapes.weight[f] * shapes.jacobian[f].transpose() * shapes.jacobian[f];
  }
  full.assemble(hessians, std::vector<Vector6>(count, Vector6::Zero()));
  const int n = variables.real_count;
  const int k = variables.integer_count;
  const SparseMatrix mixed = full.matrix().bottomLeftCorner(k, n);
  PoissonSystem out;
  out.real_integer = mixed.transpose();
  out.real_factor->compute(SparseMatrix(full.matrix().topLeftCorner(n, n)));
  if (out.real_factor->info() != Eigen::Success) {
    throw StageError("the Poisson system of the map is singular: does the mesh have triangles without area?");
  }
  const Eigen::MatrixXd lower = Eigen::MatrixXd(full.matrix().bottomRightCorner(k, k));
  out.schur = lower.selfadjointView<Eigen::Lower>();
  // one column at a time: a block of right-hand sides strides through memory and takes three times as long
  for (int j = 0; j < k; ++j) {
    const Eigen::VectorXd response = out.real_factor->solve(Eigen::VectorXd(out.real_integer.col(j)));
    out.schur.col(j) -= mixed * response;
  }
  out.schur = (out.schur + out.schur.transpose().eval()) / 2;
  return out;
}

}  // namespace neurframe
