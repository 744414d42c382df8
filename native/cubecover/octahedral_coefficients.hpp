// Frames up to the symmetry of the cube as nine linear coefficients: what can be averaged.
#pragma once

#include <Eigen/Dense>

namespace neurframe {

// The harmonic part of the quartic v -> sum over the axes a of (a . v)^4, in an orthonormal basis of the
// harmonic quartics under the inner product in which (a . v)^4 and (b . v)^4 have the product (a . b)^4.
// These are the spherical harmonics of band 4 up to a rotation of the basis (Palmer et al. 2020, section 3).
using FrameCoefficients = Eigen::Matrix<double, 9, 1>;

FrameCoefficients coefficients_of(const Eigen::Matrix3d& frame);

// The length of every frame's coefficients.
inline constexpr double frame_coefficient_norm = 1.0954451150103321;  // sqrt(6 / 5)

// The frame whose coefficients are nearest to q: Newton's method on the rotations, from the better one of
// `start` and a fixed sample of the rotations.
Eigen::Matrix3d nearest_frame(const FrameCoefficients& q, const Eigen::Matrix3d& start);

// The frames with one axis along a direction, as coefficients: center + radius (cos 4a, sin 4a) along two
// orthonormal directions, where a is the angle from a first such frame.
class FramesAboutAxis {
 public:
  // `first` is a frame with its axis `column` along the common direction.
  FramesAboutAxis(const Eigen::Matrix3d& first, int column);

  FrameCoefficients tangential(const FrameCoefficients& q) const { return plane_ * (plane_.transpose() * q); }
  double nearest_angle(const FrameCoefficients& q) const;
  Eigen::Matrix3d frame(double angle) const;

 private:
  Eigen::Matrix3d first_;
  Eigen::Vector3d axis_;
  Eigen::Matrix<double, 9, 2> plane_;
};

}  // namespace neurframe
