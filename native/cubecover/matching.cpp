#include "cubecover/matching.hpp"

namespace neurframe {

Eigen::Matrix3d to_matrix(OctahedralRotation rotation) {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
  for (int row = 0; row < 3; ++row) matrix(row, rotation.axis(row)) = rotation.sign(row);
  return matrix;
}

namespace {

// trace((R from^T)^T to^T), which is largest where the Frobenius distance is smallest
double agreement(const Eigen::Matrix3d& to_from, OctahedralRotation rotation) {
  double sum = 0;
  for (int row = 0; row < 3; ++row) sum += rotation.sign(row) * to_from(row, rotation.axis(row));
  return sum;
}

}  // namespace

OctahedralRotation best_matching(const Eigen::Matrix3d& from, const Eigen::Matrix3d& to) {
  const Eigen::Matrix3d to_from = to.transpose() * from;
  OctahedralRotation best;
  double best_agreement = agreement(to_from, best);
  for (int i = 1; i < OctahedralRotation::count; ++i) {
    const OctahedralRotation candidate(i);
    const double found = agreement(to_from, candidate);
    // a margin keeps ties (frames 45 degrees apart) independent of the last bits
    if (found > best_agreement + 1e-9) {
      best = candidate;
      best_agreement = found;
    }
  }
  return best;
}

double mismatch(const Eigen::Matrix3d& from, const Eigen::Matrix3d& to, OctahedralRotation matching) {
  return (to.transpose() - to_matrix(matching) * from.transpose()).norm();
}

void set_matching(FieldMesh& mesh, int half_face, OctahedralRotation matching) {
  at(mesh.matchings, half_face) = matching;
  at(mesh.matchings, at(mesh.twin, half_face)) = matching.inverse();
}

void match_faces(FieldMesh& mesh) {
  for (int h = 0; h < mesh.half_face_count(); ++h) {
    const int other = at(mesh.twin, h);
    if (other > h) set_matching(mesh, h, best_matching(at(mesh.frames, h / 4), at(mesh.frames, other / 4)));
  }
}

OctahedralRotation transport(const FieldMesh& mesh, std::span<const int> walk) {
  OctahedralRotation product;
  for (const int half_face : walk) product = at(mesh.matchings, half_face) * product;
  return product;
}

}  // namespace neurframe
