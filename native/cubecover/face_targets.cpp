#include "cubecover/face_targets.hpp"

#include <algorithm>

namespace neurframe {

namespace {

constexpr double share_of_tet = 0.5;  // of the tet's weight: the boundary shall not be better than the inside

}  // namespace

std::vector<FaceTarget> make_face_targets(const CombedField& field, const TetTargets& targets) {
  std::vector<FaceTarget> faces;
  for (int h = 0; h < field.mesh.half_face_count(); ++h) {
    const SignedAxis outward = at(field.boundary_axis, h);
    if (outward.axis < 0) continue;
    const int tet = h / 4;
    const Eigen::Vector3d normal =
        at(field.mesh.frames, tet).transpose() * area_vector(field.mesh, h).normalized();
    const Eigen::Vector3d image = outward.sign * Eigen::Vector3d::Unit(outward.axis);
    const Eigen::Matrix3d along_face = Eigen::Matrix3d::Identity() - normal * normal.transpose();
    faces.push_back({tet, at(targets.relative, tet) * along_face, image * normal.transpose(),
                     share_of_tet * at(targets.weight, tet)});
  }
  return faces;
}

Foldover measure_turned_faces(const std::vector<FaceTarget>& faces, const ReducedMap& map,
                              const Eigen::VectorXd& rows) {
  Foldover turned{0, 1e300};
  for (const FaceTarget& face : faces) {
    const double determinant = relative_gradient(face, map, rows).determinant();
    turned.smallest = std::min(turned.smallest, determinant);
    turned.count += determinant > 0 ? 0 : 1;
  }
  return turned;
}

}  // namespace neurframe
