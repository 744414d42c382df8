// The foldover-free energy of one tet (Garanzha et al. 2021, equations 3 to 6).
#pragma once

#include <Eigen/Dense>

namespace neurframe {

// Derivatives by the entries of S.  With D the cofactor matrix of S, the Hessian is the quadratic form
//   X -> identity |X|^2 + 2 mixed (S:X) (D:X) + square (D:X)^2,
// positive semidefinite: see barrier_term.
struct BarrierTerm {
  double value = 0;
  Eigen::Matrix3d gradient;
  Eigen::Matrix3d cofactors;
  double identity = 0;
  double mixed = 0;
  double square = 0;
};

double barrier_value(const Eigen::Matrix3d& S, double epsilon);

// f(S) = |S|^2 / chi^(2/3) + (1 + d^2) / chi with d = det S and chi = (d + sqrt(d^2 + epsilon^2)) / 2.
// With g = chi^(-2/3) the Hessian without the term of the second derivative of d is
//   2 g |X + (g'/g) (D:X) S|^2 + (|S|^2 (g'' - 2 g'^2 / g) + h'') (D:X)^2,   D = cofactor matrix of S,
// whose first part is a square; the coefficient of the second is clamped at zero.  No eigenvalues are needed.
BarrierTerm barrier_term(const Eigen::Matrix3d& S, double epsilon);

}  // namespace neurframe
