#include "cubecover/octahedral_coefficients.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace neurframe {

namespace {

using Quartic = Eigen::Matrix<double, 15, 1>;  // per monomial: coefficient / sqrt(multinomial)
using HarmonicBasis = Eigen::Matrix<double, 15, 9>;

struct Monomial {
  int powers[3];
  double scale;  // sqrt(4! / (powers! ...)): makes the dot product of (a.v)^4 and (b.v)^4 equal (a.b)^4
};

double factorial(int n) {
  return n < 2 ? 1 : n * factorial(n - 1);
}

std::array<Monomial, 15> make_monomials() {
  std::array<Monomial, 15> monomials{};
  std::size_t count = 0;
  for (int x = 4; x >= 0; --x) {
    for (int y = 4 - x; y >= 0; --y) {
      const int z = 4 - x - y;
      monomials[count++] = {{x, y, z}, std::sqrt(24 / (factorial(x) * factorial(y) * factorial(z)))};
    }
  }
  return monomials;
}

const std::array<Monomial, 15>& monomials() {
  static const std::array<Monomial, 15> all = make_monomials();
  return all;
}

// The orthogonal complement of |v|^2 v_i v_j.
HarmonicBasis make_harmonic_basis() {
  Eigen::Matrix<double, 15, 6> with_trace = Eigen::Matrix<double, 15, 6>::Zero();
  int column = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j, ++column) {
      for (int k = 0; k < 3; ++k) {
        int powers[3] = {0, 0, 0};
        ++powers[i], ++powers[j], powers[k] += 2;
        for (int m = 0; m < 15; ++m) {
          const Monomial& monomial = monomials()[static_cast<std::size_t>(m)];
          if (std::equal(powers, powers + 3, monomial.powers)) with_trace(m, column) += 1 / monomial.scale;
        }
      }
    }
  }
  const Eigen::HouseholderQR<Eigen::Matrix<double, 15, 6>> qr(with_trace);
  const Eigen::Matrix<double, 15, 15> q = qr.householderQ();
  return q.rightCols<9>();
}

const HarmonicBasis& harmonic_basis() {
  static const HarmonicBasis basis = make_harmonic_basis();
  return basis;
}

Quartic fourth_power(const Eigen::Vector3d& a) {
  Quartic quartic;
  for (int m = 0; m < 15; ++m) {
    const auto& [powers, scale] = monomials()[static_cast<std::size_t>(m)];
    double product = scale;
    for (int k = 0; k < 3; ++k) {
      for (int i = 0; i < powers[k]; ++i) product *= a(k);
    }
    quartic(m) = product;
  }
  return quartic;
}

// A fully symmetric tensor of order four, contracted two and three times with a vector.
class SymmetricTensor {
 public:
  explicit SymmetricTensor(const Quartic& quartic) {
    for (int m = 0; m < 15; ++m) {
      const auto& [powers, scale] = monomials()[static_cast<std::size_t>(m)];
      entry_[index(powers[1], powers[2])] = quartic(m) / scale;
    }
  }

  // T(v, v, ., .)
  Eigen::Matrix3d contracted(const Eigen::Vector3d& v) const {
    Eigen::Matrix3d matrix;
    for (int i = 0; i < 3; ++i) {
      for (int j = i; j < 3; ++j) {
        double sum = 0;
        for (int k = 0; k < 3; ++k) {
          for (int l = k; l < 3; ++l) sum += (k == l ? 1 : 2) * v(k) * v(l) * entry(i, j, k, l);
        }
        matrix(i, j) = matrix(j, i) = sum;
      }
    }
    return matrix;
  }

 private:
  static std::size_t index(int ys, int zs) { return static_cast<std::size_t>(5 * ys + zs); }
  double entry(int i, int j, int k, int l) const {
    return entry_[index((i == 1) + (j == 1) + (k == 1) + (l == 1),
                        (i == 2) + (j == 2) + (k == 2) + (l == 2))];
  }

  std::array<double, 25> entry_{};
};

// The sum over the axes of T(a, a, a, a), its gradient and Hessian by the vector w of a small rotation
// a -> a + w x a + w x (w x a) / 2.
struct RotationJet {
  double value = 0;
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
};

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& a) {
  Eigen::Matrix3d matrix;
  matrix << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return matrix;
}

RotationJet rotation_jet(const SymmetricTensor& tensor, const Eigen::Matrix3d& frame) {
  RotationJet jet;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d a = frame.col(k);
    const Eigen::Matrix3d twice = tensor.contracted(a);
    const Eigen::Vector3d thrice = twice * a;
    const Eigen::Matrix3d turn = -cross_matrix(a);  // w -> w x a
    jet.value += thrice.dot(a);
    jet.gradient += 4 * a.cross(thrice);
    jet.hessian += 12 * turn.transpose() * twice * turn +
                   2 * (thrice * a.transpose() + a * thrice.transpose()) -
                   4 * thrice.dot(a) * Eigen::Matrix3d::Identity();
  }
  return jet;
}

Eigen::Matrix3d rotated(const Eigen::Matrix3d& frame, const Eigen::Vector3d& w) {
  const double angle = w.norm();
  return angle > 0 ? Eigen::Matrix3d(Eigen::AngleAxisd(angle, w / angle) * frame) : frame;
}

// Newton's direction where the value is concave, the gradient elsewhere; at most a sixth of a turn.
Eigen::Vector3d ascent_direction(const RotationJet& jet) {
  const Eigen::LLT<Eigen::Matrix3d> concave(-jet.hessian);
  Eigen::Vector3d w = concave.info() == Eigen::Success ? Eigen::Vector3d(concave.solve(jet.gradient))
                                                       : Eigen::Vector3d(jet.gradient / 8);
  const double longest = 0.3;
  if (w.norm() > longest) w *= longest / w.norm();
  return w;
}

Eigen::Matrix3d climb(const SymmetricTensor& tensor, Eigen::Matrix3d frame) {
  constexpr int most_steps = 12;
  constexpr double small_turn = 1e-5;
  RotationJet jet = rotation_jet(tensor, frame);
  for (int step = 0; step < most_steps; ++step) {
    Eigen::Vector3d w = ascent_direction(jet);
    Eigen::Matrix3d next = rotated(frame, w);
    RotationJet next_jet = rotation_jet(tensor, next);
    for (; next_jet.value < jet.value && w.norm() > small_turn; next_jet = rotation_jet(tensor, next)) {
      w /= 4;
      next = rotated(frame, w);
    }
    if (next_jet.value <= jet.value) return frame;
    frame = next;
    jet = next_jet;
    if (w.norm() < small_turn) break;
  }
  return frame;
}

struct Samples {
  std::vector<Eigen::Matrix3d> frames;
  Eigen::Matrix<double, 9, Eigen::Dynamic> coefficients;
};

// Rotations by angles up to 62.8 degrees, the largest distance of two frames, about 13 axes of the cube.
Samples make_samples() {
  Samples samples{{Eigen::Matrix3d::Identity()}, {}};
  for (int i = 0; i < 27; ++i) {
    const Eigen::Vector3d axis(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    if (axis.norm() == 0) continue;
    for (const double angle_deg : {22.5, 45.0}) {
      samples.frames.push_back(
          Eigen::AngleAxisd(angle_deg * std::numbers::pi / 180, axis.normalized()).toRotationMatrix());
    }
  }
  samples.coefficients.resize(9, static_cast<Eigen::Index>(samples.frames.size()));
  for (std::size_t i = 0; i < samples.frames.size(); ++i)
    samples.coefficients.col(static_cast<Eigen::Index>(i)) = coefficients_of(samples.frames[i]);
  return samples;
}

}  // namespace

FrameCoefficients coefficients_of(const Eigen::Matrix3d& frame) {
  const Quartic sum = fourth_power(frame.col(0)) + fourth_power(frame.col(1)) + fourth_power(frame.col(2));
  return harmonic_basis().transpose() * sum;
}

Eigen::Matrix3d nearest_frame(const FrameCoefficients& q, const Eigen::Matrix3d& start) {
  static const Samples samples = make_samples();
  Eigen::Index best = 0;
  const double best_product = (samples.coefficients.transpose() * q).maxCoeff(&best);
  const bool keep = coefficients_of(start).dot(q) >= best_product;
  const SymmetricTensor tensor(harmonic_basis() * q);
  return climb(tensor, keep ? start : samples.frames[static_cast<std::size_t>(best)]);
}

FramesAboutAxis::FramesAboutAxis(const Eigen::Matrix3d& first, int column)
    : first_(first), axis_(first.col(column)) {
  constexpr double eighth = std::numbers::pi / 8;
  const FrameCoefficients at_zero = coefficients_of(first);
  const FrameCoefficients center = (at_zero + coefficients_of(frame(2 * eighth))) / 2;
  plane_.col(0) = (at_zero - center).normalized();
  plane_.col(1) = (coefficients_of(frame(eighth)) - center).normalized();
}

double FramesAboutAxis::nearest_angle(const FrameCoefficients& q) const {
  const Eigen::Vector2d in_plane = plane_.transpose() * q;
  return std::atan2(in_plane(1), in_plane(0)) / 4;
}

Eigen::Matrix3d FramesAboutAxis::frame(double angle) const {
  return Eigen::AngleAxisd(angle, axis_) * first_;
}

}  // namespace neurframe
