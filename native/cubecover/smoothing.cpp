#include "cubecover/smoothing.hpp"

#include "cubecover/alignment.hpp"
#include "cubecover/matching.hpp"

namespace neurframe {

namespace {

std::vector<double> dual_weights(const FieldMesh& mesh) {
  std::vector<double> weights(mesh.twin.size(), 0);
  for (int h = 0; h < mesh.half_face_count(); ++h) {
    if (at(mesh.twin, h) < 0) continue;
    const double distance = (tet_center(mesh, h / 4) - tet_center(mesh, at(mesh.twin, h) / 4)).norm();
    at(weights, h) = area_vector(mesh, h).norm() / distance;
  }
  return weights;
}

Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& matrix) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d rotation = svd.matrixU() * svd.matrixV().transpose();
  if (rotation.determinant() < 0)
    rotation = svd.matrixU() * Eigen::Vector3d(1, 1, -1).asDiagonal() * svd.matrixV().transpose();
  return rotation;
}

}  // namespace

void smooth_frames(FieldMesh& mesh, int sweeps) {
  const std::vector<double> weights = dual_weights(mesh);
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    // in place, in the order of the tets: converges faster than from a copy, and is as deterministic
    for (int t = 0; t < mesh.tet_count(); ++t) {
      Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
      for (int h = 4 * t; h < 4 * t + 4; ++h) {
        if (at(mesh.twin, h) < 0) continue;
        const Eigen::Matrix3d& other = at(mesh.frames, at(mesh.twin, h) / 4);
        const OctahedralRotation matching = best_matching(at(mesh.frames, t), other);
        sum += at(weights, h) * other * to_matrix(matching);
      }
      at(mesh.frames, t) = nearest_rotation(sum);
    }
    align_boundary_layer(mesh);
  }
}

}  // namespace neurframe
