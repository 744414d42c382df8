#include "cubecover/barrier_energy.hpp"

#include <algorithm>
#include <cmath>

namespace neurframe {

namespace {

// A function of the determinant, with two derivatives.
struct Jet {
  double value;
  double first;
  double second;
};

Jet regularised_determinant(double determinant, double epsilon) {
  const double root = std::sqrt(determinant * determinant + epsilon * epsilon);
  // for negative determinants the sum cancels; the product form does not
  const double value =
      determinant >= 0 ? (determinant + root) / 2 : epsilon * epsilon / (2 * (root - determinant));
  return {value, value / root, epsilon * epsilon / (2 * root * root * root)};
}

Jet shape_factor(const Jet& chi) {  // chi^(-2/3)
  const double value = std::pow(chi.value, -2.0 / 3.0);
  const double by_chi = -2.0 / 3.0 * value / chi.value;
  const double by_chi_twice = 10.0 / 9.0 * value / (chi.value * chi.value);
  return {value, by_chi * chi.first, by_chi_twice * chi.first * chi.first + by_chi * chi.second};
}

Jet volume_term(double determinant, const Jet& chi) {  // (1 + d^2) / chi
  const double square = 1 + determinant * determinant;
  const double value = square / chi.value;
  const double first = (2 * determinant - value * chi.first) / chi.value;
  const double second = (2 - 2 * first * chi.first - value * chi.second) / chi.value;
  return {value, first, second};
}

Eigen::Matrix3d cofactors(const Eigen::Matrix3d& S) {
  Eigen::Matrix3d D;
  D.col(0) = S.col(1).cross(S.col(2));
  D.col(1) = S.col(2).cross(S.col(0));
  D.col(2) = S.col(0).cross(S.col(1));
  return D;
}

}  // namespace

double barrier_value(const Eigen::Matrix3d& S, double epsilon) {
  const double determinant = S.determinant();
  const Jet chi = regularised_determinant(determinant, epsilon);
  return S.squaredNorm() * std::pow(chi.value, -2.0 / 3.0) + (1 + determinant * determinant) / chi.value;
}

BarrierTerm barrier_term(const Eigen::Matrix3d& S, double epsilon) {
  const double determinant = S.determinant();
  const Jet chi = regularised_determinant(determinant, epsilon);
  const Jet shape = shape_factor(chi);
  const Jet volume = volume_term(determinant, chi);
  const double square = S.squaredNorm();
  BarrierTerm term;
  term.cofactors = cofactors(S);
  term.value = square * shape.value + volume.value;
  term.gradient = 2 * shape.value * S + (square * shape.first + volume.first) * term.cofactors;
  // 2 g |X + (g'/g) (D:X) S|^2, multiplied out
  const double bend = 2 * shape.first * shape.first / shape.value * square;
  term.identity = 2 * shape.value;
  term.mixed = 2 * shape.first;
  term.square = bend + std::max(0.0, square * shape.second + volume.second - bend);
  return term;
}

}  // namespace neurframe
