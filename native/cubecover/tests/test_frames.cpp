// Frames as coefficients, their diffusion, and new starts: against closed forms.
#include <cmath>
#include <numbers>

#include "core/testing.hpp"
#include "cubecover/local_restart.hpp"
#include "cubecover/octahedral_coefficients.hpp"
#include "grid_meshes.hpp"

namespace neurframe {
namespace {

Eigen::Matrix3d random_rotation(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const Eigen::Vector4d q(normal(random), normal(random), normal(random), normal(random));
  return Eigen::Quaterniond(q.normalized()).toRotationMatrix();
}

// The angle between two frames up to the symmetry of the cube.
double angle_between(const Eigen::Matrix3d& one, const Eigen::Matrix3d& other) {
  const OctahedralRotation matching = best_matching(one, other);
  return Eigen::AngleAxisd(other * to_matrix(matching) * one.transpose()).angle();
}

void test_coefficients_forget_the_names_of_axes() {
  std::mt19937_64 random(3);
  const Eigen::Matrix3d frame = random_rotation(random);
  const FrameCoefficients q = coefficients_of(frame);
  CHECK_NEAR(q.norm(), frame_coefficient_norm, 1e-12);
  for (int i = 0; i < OctahedralRotation::count; ++i) {
    const FrameCoefficients named_anew = coefficients_of(frame * to_matrix(OctahedralRotation(i)));
    CHECK_NEAR((named_anew - q).norm(), 0, 1e-12);
  }
}

// <q(A), q(B)> = sum over axes of (a . b)^4 less the product of the parts that all frames share, 9/5.
void test_products_of_coefficients() {
  std::mt19937_64 random(4);
  const Eigen::Matrix3d a = random_rotation(random);
  const Eigen::Matrix3d b = random_rotation(random);
  const double fourth_powers = (a.transpose() * b).array().pow(4).sum();
  CHECK_NEAR(coefficients_of(a).dot(coefficients_of(b)), fourth_powers - 9.0 / 5.0, 1e-12);
}

void test_nearest_frame() {
  std::mt19937_64 random(5);
  for (int round = 0; round < 50; ++round) {
    const Eigen::Matrix3d frame = random_rotation(random);
    CHECK_NEAR(angle_between(nearest_frame(coefficients_of(frame), random_rotation(random)), frame), 0, 1e-6);
    // of anything else, nothing random is nearer
    const FrameCoefficients q = FrameCoefficients::Random();
    const double product = coefficients_of(nearest_frame(q, frame)).dot(q);
    for (int i = 0; i < 200; ++i) CHECK(coefficients_of(random_rotation(random)).dot(q) <= product + 1e-9);
  }
}

void test_frames_about_an_axis() {
  std::mt19937_64 random(6);
  const Eigen::Matrix3d first = random_rotation(random);
  const FramesAboutAxis frames(first, 1);
  for (const double angle : {-0.7, -0.3, 0.0, 0.2, 0.75}) {
    CHECK_NEAR(frames.nearest_angle(coefficients_of(frames.frame(angle))), angle, 1e-12);
    CHECK_NEAR((frames.frame(angle).col(1) - first.col(1)).norm(), 0, 1e-12);
  }
}

// The frames of a box settle to the box's own from anything near them.
void test_diffusion_straightens_a_box() {
  FieldMesh mesh = box({4, 4, 4});
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> small(-0.3, 0.3);
  for (Eigen::Matrix3d& frame : mesh.frames)
    frame = Eigen::AngleAxisd(small(random), Eigen::Vector3d(1, 2, -1).normalized()) * frame;
  diffuse_frames(mesh, boundary_alignments(mesh), {10});
  for (const Eigen::Matrix3d& frame : mesh.frames)
    CHECK_NEAR(angle_between(frame, Eigen::Matrix3d::Identity()), 0, 0.01);
}

void test_diffusion_keeps_to_the_boundary() {
  FieldMesh mesh = cylinder(8, 4, 0.6);
  const std::vector<Alignment> alignments = boundary_alignments(mesh);
  diffuse_frames(mesh, alignments, {10});
  for (int t = 0; t < mesh.tet_count(); ++t) {
    if (!at(alignments, t).first) continue;
    CHECK_NEAR((at(mesh.frames, t).transpose() * *at(alignments, t).first).cwiseAbs().maxCoeff(), 1, 1e-9);
  }
}

// A ball of frames that are turned by 45 degrees is surrounded by defects; a new start removes it.
void test_restart() {
  FieldMesh mesh = box({6, 6, 6});
  const FieldMesh sound = mesh;
  const Eigen::Vector3d center(3, 3, 3);
  for (int t = 0; t < mesh.tet_count(); ++t) {
    if ((tet_center(mesh, t) - center).norm() < 1.2)
      at(mesh.frames, t) = Eigen::AngleAxisd(std::numbers::pi / 4, Eigen::Vector3d(1, 1, 0).normalized()) *
                           Eigen::Matrix3d::Identity();
  }
  const std::vector<Alignment> alignments = boundary_alignments(mesh);
  CHECK(restart_frames(mesh, alignments, {center, 1.6, 0.5}));
  for (int t = 0; t < mesh.tet_count(); ++t)
    CHECK_NEAR(angle_between(at(mesh.frames, t), at(sound.frames, t)), 0, 0.01);
  CHECK(!restart_frames(mesh, alignments, {center, 100, 0}));  // no rim
}

}  // namespace
}  // namespace neurframe

int main() {
  neurframe::test_coefficients_forget_the_names_of_axes();
  neurframe::test_products_of_coefficients();
  neurframe::test_nearest_frame();
  neurframe::test_frames_about_an_axis();
  neurframe::test_diffusion_straightens_a_box();
  neurframe::test_diffusion_keeps_to_the_boundary();
  neurframe::test_restart();
  return neurframe::test_result();
}
