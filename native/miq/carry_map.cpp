#include "miq/carry_map.hpp"

#include <algorithm>
#include <cmath>

namespace neurframe {
namespace {

constexpr double kUsedShare = 0.5;  // of the way to the first collapse
constexpr double kLeastStep = 1e-3;
constexpr int kMostSteps = 60;

using Corner = Eigen::Vector2d;

double cross(const Corner& a, const Corner& b) {
  return a[0] * b[1] - a[1] * b[0];
}

// The least t > 0 at which a + b t + c t^2 vanishes, given a > 0; 1 if there is none below 1.
double first_zero(double a, double b, double c) {
  const double discriminant = b * b - 4 * a * c;
  if (discriminant < 0) return 1;
  // both roots without cancellation; for a > 0 the least positive one is 2 a / (-b + sqrt) wherever it exists
  const double denominator = -b + std::sqrt(discriminant);
  return denominator > 0 ? std::min(1.0, 2 * a / denominator) : 1;
}

// The share of the step, at most 1, at which the first triangle has no area left.
double way_to_collapse(const MapSystem& system, int triangle_count, const Eigen::VectorXd& real,
                       const Eigen::VectorXd& integer, const Eigen::VectorXd& real_step,
                       const Eigen::VectorXd& integer_step) {
  double least = 1;
  for (int f = 0; f < triangle_count; ++f) {
    const Vector6 at = system.corner_parameters(f, real, integer);
    const Vector6 by = system.corner_parameters(f, real_step, integer_step);
    const Corner a = at.segment<2>(2) - at.head<2>(), b = at.tail<2>() - at.head<2>();
    const Corner da = by.segment<2>(2) - by.head<2>(), db = by.tail<2>() - by.head<2>();
    least = std::min(least, first_zero(cross(a, b), cross(a, db) + cross(da, b), cross(da, db)));
  }
  return least;
}

}  // namespace

bool carry_map(MapSystem& held_system, const TriangleShapes& shapes, const PoissonSystem& poisson,
               const UntangleOptions& relaxation, const Eigen::VectorXd& goal, Eigen::VectorXd& real,
               Eigen::VectorXd& integer) {
  const auto triangle_count = static_cast<int>(shapes.weight.size());
  for (int step = 0; step < kMostSteps; ++step) {
    const Eigen::VectorXd integer_step = goal - integer;
    const Eigen::VectorXd real_step = poisson.real_response(integer_step);
    const double way = way_to_collapse(held_system, triangle_count, real, integer, real_step, integer_step);
    const bool last = way >= 1;
    const double share = last ? 1 : kUsedShare * way;
    if (share < kLeastStep) return false;
    real += share * real_step;
    integer = last ? goal : Eigen::VectorXd(integer + share * integer_step);
    if (untangle(held_system, shapes, relaxation, real, integer).folds_after > 0) return false;
    if (last) return true;
  }
  return false;
}

}  // namespace neurframe
