// Smoothing of the crosses with their matchings kept.
#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <cmath>

#include "core/errors.hpp"
#include "miq/matching.hpp"

namespace neurframe {
namespace {

Eigen::Vector3d centroid(const CrossSurface& surface, int f) {
  return (surface.at(surface.from(3 * f)) + surface.at(surface.from(3 * f + 1)) +
          surface.at(surface.from(3 * f + 2))) /
         3;
}

// Triangles to be turned, numbered from 0; -1 for the others.
std::vector<int> number_free(const CrossSurface& surface, const std::vector<int>& vertices, double radius,
                             int& count) {
  std::vector<int> number(surface.triangles.size(), -1);
  count = 0;
  for (int f = 0; f < surface.triangle_count(); ++f) {
    if (surface.is_feature(3 * f) || surface.is_feature(3 * f + 1) || surface.is_feature(3 * f + 2)) continue;
    const Eigen::Vector3d at = centroid(surface, f);
    for (const int v : vertices) {
      if ((surface.at(v) - at).squaredNorm() > radius * radius) continue;
      number[static_cast<size_t>(f)] = count++;
      break;
    }
  }
  return number;
}

}  // namespace

double dual_weight(const CrossSurface& surface, int h) {
  return 1.5 * surface.along(h).squaredNorm() / (surface.area(h / 3) + surface.area(surface.twin(h) / 3));
}

void relax_field(CrossSurface& surface, const std::vector<int>& vertices, double radius) {
  int count = 0;
  const std::vector<int> number = number_free(surface, vertices, radius, count);
  if (count == 0) return;
  std::vector<Eigen::Triplet<double>> triplets;
  Eigen::VectorXd right = Eigen::VectorXd::Zero(count);
  for (int f = 0; f < surface.triangle_count(); ++f) {
    const int i = number[static_cast<size_t>(f)];
    // a whole component may be free: the tiny diagonal keeps its common turn at zero
    if (i >= 0) triplets.emplace_back(i, i, 1e-9);
  }
  for (int h = 0; h < surface.half_edge_count(); ++h) {
    const int o = surface.twin(h);
    const int i = number[static_cast<size_t>(h / 3)];
    if (o < 0 || i < 0 || surface.is_feature(h)) continue;
    const int j = number[static_cast<size_t>(o / 3)];
    const double weight = dual_weight(surface, h);
    // turning both by d changes the residual from this triangle to the other by d_this - d_other
    triplets.emplace_back(i, i, weight);
    if (j >= 0) triplets.emplace_back(i, j, -weight);
    right[i] -= weight * rotation_residual(surface, h);
  }
  Eigen::SparseMatrix<double> matrix(count, count);
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(matrix);
  if (factor.info() != Eigen::Success) throw StageError("the smoothness system of the crosses is singular");
  const Eigen::VectorXd turn = factor.solve(right);
  for (int f = 0; f < surface.triangle_count(); ++f) {
    const int i = number[static_cast<size_t>(f)];
    if (i < 0) continue;
    const Eigen::Vector3d second = surface.second_axis(f);
    Eigen::Vector3d& axis = surface.axis[static_cast<size_t>(f)];
    axis = (std::cos(turn[i]) * axis + std::sin(turn[i]) * second).normalized();
  }
}

}  // namespace neurframe
