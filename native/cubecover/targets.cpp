#include "cubecover/targets.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "cubecover/barrier_energy.hpp"

namespace neurframe {

namespace {

constexpr double distortion_power = 4;  // the worst cells count, but not one alone
constexpr double least_weight = 0.05;   // of the mean tet volume: slivers unfold too (measured, notes)

// The gradients of the four barycentric coordinates, as rows.
Eigen::Matrix<double, 4, 3> barycentric_gradients(const FieldMesh& mesh, int tet) {
  const Tet& corners = at(mesh.tets, tet);
  Eigen::Matrix3d edges;
  for (int k = 0; k < 3; ++k)
    edges.col(k) = at(mesh.points, at(corners, k + 1)) - at(mesh.points, corners[0]);
  Eigen::Matrix<double, 4, 3> gradients;
  gradients.bottomRows<3>() = edges.inverse();
  gradients.row(0) = -gradients.bottomRows<3>().colwise().sum();
  return gradients;
}

}  // namespace

TetTargets make_targets(const FieldMesh& mesh, double cell_length) {
  TetTargets targets;
  double total = 0;
  for (int t = 0; t < mesh.tet_count(); ++t) {
    targets.relative.push_back(barycentric_gradients(mesh, t) * at(mesh.frames, t) * cell_length);
    targets.weight.push_back(tet_volume(mesh, t));
    total += targets.weight.back();
  }
  const double mean = total / mesh.tet_count();
  // relative to the mean, so that energies do not depend on the unit of length
  for (double& weight : targets.weight) weight = std::max(weight / mean, least_weight);
  return targets;
}

Foldover measure_foldover(const TetTargets& targets, const ReducedMap& map, const Eigen::VectorXd& rows) {
  Foldover foldover{0, 1e300};
  for (int t = 0; t < static_cast<int>(targets.weight.size()); ++t) {
    const double determinant = relative_gradient(targets, map, rows, t).determinant();
    foldover.smallest = std::min(foldover.smallest, determinant);
    foldover.count += determinant > 0 ? 0 : 1;
  }
  return foldover;
}

double mean_distortion(const TetTargets& targets, const ReducedMap& map, const Eigen::VectorXd& rows) {
  double sum = 0;
  double total = 0;
  for (int t = 0; t < static_cast<int>(targets.weight.size()); ++t) {
    const Eigen::Matrix3d gradient = relative_gradient(targets, map, rows, t);
    if (gradient.determinant() <= 0) return std::numeric_limits<double>::infinity();
    sum += at(targets.weight, t) * std::pow(barrier_value(gradient, 0), distortion_power);
    total += at(targets.weight, t);
  }
  return std::pow(sum / total, 1 / distortion_power);
}

double parametric_volume(const ReducedMap& map, const Eigen::VectorXd& rows) {
  double volume = 0;
  for (int t = 0; t < static_cast<int>(map.class_of_corner.size()); ++t) {
    const Eigen::Matrix<double, 3, 4> corners = corner_parameters(map, rows, t);
    volume += (corners.rightCols<3>().colwise() - corners.col(0)).determinant() / 6;
  }
  return volume;
}

}  // namespace neurframe
