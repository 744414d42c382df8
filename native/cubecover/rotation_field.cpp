#include "cubecover/rotation_field.hpp"

#include "cubecover/spd_solver.hpp"

namespace neurframe {

namespace {

constexpr double target_strength = 100;       // of the mean degree of the dual graph
constexpr double background_strength = 1e-4;  // ... enough to make the system definite

constexpr double tolerance = 1e-4;  // of the residual; only the nearest rotation is wanted

using Triplets = std::vector<Eigen::Triplet<double>>;

// Lower triangle of the Laplacian of the dual graph: area of the shared face over the distance of the
// centres.
Triplets dual_laplacian(const FieldMesh& mesh) {
  Triplets entries;
  for (int h = 0; h < mesh.half_face_count(); ++h) {
    const int twin = at(mesh.twin, h);
    if (twin < h) continue;
    const int t = h / 4, s = twin / 4;
    const double weight = area_vector(mesh, h).norm() / (tet_center(mesh, t) - tet_center(mesh, s)).norm();
    entries.emplace_back(t, t, weight);
    entries.emplace_back(s, s, weight);
    entries.emplace_back(std::max(t, s), std::min(t, s), -weight);
  }
  return entries;
}

double mean_degree(const Triplets& laplacian, int tet_count) {
  double trace = 0;
  for (const auto& entry : laplacian) trace += entry.row() == entry.col() ? entry.value() : 0;
  return trace / tet_count;
}

// One axis of all tets, as rows.
Eigen::MatrixXd axis_field(Triplets laplacian, int tet_count, const std::vector<AxisTarget>& targets,
                           const Eigen::Vector3d& background, int axis) {
  const double unit = mean_degree(laplacian, tet_count);
  Eigen::MatrixXd right_side = background_strength * unit * background.transpose().replicate(tet_count, 1);
  for (int t = 0; t < tet_count; ++t) laplacian.emplace_back(t, t, background_strength * unit);
  for (const AxisTarget& target : targets) {
    if (target.axis.axis != axis) continue;
    laplacian.emplace_back(target.tet, target.tet, target_strength * unit);
    right_side.row(target.tet) += target_strength * unit * target.axis.sign * target.direction.transpose();
  }
  SparseMatrix matrix(tet_count, tet_count);
  matrix.setFromTriplets(laplacian.begin(), laplacian.end());
  Eigen::MatrixXd field(tet_count, 3);
  for (int k = 0; k < 3; ++k) field.col(k) = solve_loosely(matrix, right_side.col(k), tolerance);
  return field;
}

Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& matrix) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double handedness = (svd.matrixU() * svd.matrixV().transpose()).determinant();
  return svd.matrixU() * Eigen::Vector3d(1, 1, handedness < 0 ? -1 : 1).asDiagonal() *
         svd.matrixV().transpose();
}

}  // namespace

std::vector<Eigen::Matrix3d> rotation_field(const FieldMesh& mesh, const std::vector<AxisTarget>& targets,
                                            const Eigen::Matrix3d& background) {
  const Triplets laplacian = dual_laplacian(mesh);
  std::array<Eigen::MatrixXd, 3> axes;
  for (int axis = 0; axis < 3; ++axis)
    at(axes, axis) = axis_field(laplacian, mesh.tet_count(), targets, background.col(axis), axis);
  std::vector<Eigen::Matrix3d> frames;
  for (int t = 0; t < mesh.tet_count(); ++t) {
    Eigen::Matrix3d frame;
    for (int axis = 0; axis < 3; ++axis) frame.col(axis) = at(axes, axis).row(t).transpose();
    frames.push_back(nearest_rotation(frame));
  }
  return frames;
}

}  // namespace neurframe
