#include "cubecover/settling.hpp"

#include "cubecover/matching.hpp"

namespace neurframe {

namespace {

constexpr int reach = 3;  // tets round the faces, by common vertices
constexpr int sweeps = 20;
constexpr double least_determinant = 0.05;  // of a mean of rotations
constexpr int polar_steps = 6;

std::vector<int> tets_near(const FieldMesh& mesh, const std::vector<int>& half_faces) {
  std::vector<char> vertex(mesh.points.size(), 0);
  for (const int h : half_faces)
    for (const int v : half_face_vertices(mesh.tets, h)) at(vertex, v) = 1;
  std::vector<int> tets;
  for (int ring = 0; ring < reach; ++ring) {
    tets.clear();
    for (int t = 0; t < mesh.tet_count(); ++t) {
      for (const int v : at(mesh.tets, t)) {
        if (!at(vertex, v)) continue;
        tets.push_back(t);
        break;
      }
    }
    for (const int t : tets)
      for (const int v : at(mesh.tets, t)) at(vertex, v) = 1;
  }
  return tets;
}

// By Newton's method for the polar decomposition, which is much faster than one by singular values; what is
// far from any rotation stays as it was.
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& matrix, const Eigen::Matrix3d& before) {
  if (!(matrix.determinant() > least_determinant)) return before;
  Eigen::Matrix3d rotation = matrix;
  for (int step = 0; step < polar_steps; ++step)
    rotation = (rotation + rotation.inverse().transpose().eval()) / 2;
  return rotation;
}

// u_neighbor = R u_tet, so the neighbour's frame in the names of the tet's axes is F R.
Eigen::Matrix3d mean_of_neighbors(const FieldMesh& mesh, int tet) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  double weight = 0;
  for (int h = 4 * tet; h < 4 * tet + 4; ++h) {
    const int twin = at(mesh.twin, h);
    if (twin < 0) continue;
    const double area = area_vector(mesh, h).norm();
    sum += area * at(mesh.frames, twin / 4) * to_matrix(at(mesh.matchings, h));
    weight += area;
  }
  return sum / weight;
}

}  // namespace

void settle_frames(FieldMesh& mesh, const std::vector<Alignment>& alignments,
                   const std::vector<int>& half_faces) {
  const std::vector<int> tets = tets_near(mesh, half_faces);
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    for (const int t : tets) {
      Eigen::Matrix3d& frame = at(mesh.frames, t);
      frame = nearest_rotation(mean_of_neighbors(mesh, t), frame);
      frame = aligned_frame(frame, at(alignments, t));
    }
  }
}

}  // namespace neurframe
