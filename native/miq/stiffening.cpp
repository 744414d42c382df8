#include "miq/stiffening.hpp"

#include "core/errors.hpp"

namespace neurframe {
namespace {

void solve_least_squares(MapSystem& system, const TriangleShapes& shapes,
                         const std::vector<double>& stiffness, SparseFactor& factor, Eigen::VectorXd& real,
                         Eigen::VectorXd& integer) {
  const size_t count = shapes.weight.size();
  const Eigen::Vector4d identity(1, 0, 0, 1);
  std::vector<Eigen::Matrix<double, 6, 6>> hessians(count);
  std::vector<Vector6> gradients(count);
  const Eigen::VectorXd no_real = Eigen::VectorXd::Zero(real.size());
  const bool integers_free = system.size() > real.size();
  const Eigen::VectorXd held =
      integers_free ? Eigen::VectorXd(Eigen::VectorXd::Zero(integer.size())) : integer;
  for (size_t f = 0; f < count; ++f) {
    const double weight = stiffness[f] * shapes.weight[f];
    const Eigen::Vector4d rest =
        identity - shapes.jacobian[f] * system.corner_parameters(static_cast<int>(f), no_real, held);
    hessians[f] = weight * shapes.jacobian[f].transpose() * shapes.jacobian[f];
    gradients[f] = weight * shapes.jacobian[f].transpose() * rest;
  }
  system.assemble(hessians, gradients);
  factor.factorize(system.matrix());
  if (factor.info() != Eigen::Success) {
    throw StageError(
        "the least-squares system of the map is singular: does the mesh have triangles without area?");
  }
  const Eigen::VectorXd solution = factor.solve(system.gradient());
  real = solution.head(real.size());
  if (integers_free) integer = solution.tail(integer.size());
}

// Triangles at most `rings` vertex rings away from the given ones, with their ring; -1 elsewhere.
std::vector<int> ring_distance(const CrossSurface& surface, const std::vector<int>& triangles, int rings) {
  std::vector<int> ring(surface.triangles.size(), -1);
  for (const int f : triangles) ring[static_cast<size_t>(f)] = 0;
  std::vector<int> at_vertex(surface.positions.size(), -1);
  for (int level = 1; level <= rings; ++level) {
    for (size_t f = 0; f < ring.size(); ++f) {
      if (ring[f] != level - 1) continue;
      for (const int v : surface.triangles[f]) at_vertex[static_cast<size_t>(v)] = level;
    }
    for (size_t f = 0; f < ring.size(); ++f) {
      for (const int v : surface.triangles[f]) {
        if (ring[f] < 0 && at_vertex[static_cast<size_t>(v)] == level) ring[f] = level;
      }
    }
  }
  return ring;
}

}  // namespace

std::vector<int> defective_triangles(const MapProblem& problem, const MapCheck& check) {
  std::vector<char> overwound(problem.surface.positions.size(), 0);
  for (const int v : check.overwound) overwound[static_cast<size_t>(v)] = 1;
  std::vector<int> triangles = check.folded;
  for (int f = 0; f < problem.surface.triangle_count(); ++f) {
    for (const int v : problem.surface.triangles[static_cast<size_t>(f)]) {
      if (overwound[static_cast<size_t>(v)]) triangles.push_back(f);
    }
  }
  return triangles;
}

void stiffen(const CrossSurface& surface, const std::vector<int>& triangles, std::vector<double>& stiffness) {
  constexpr int kRings = 4;
  const std::vector<int> ring = ring_distance(surface, triangles, kRings);
  for (size_t f = 0; f < ring.size(); ++f) {
    if (ring[f] >= 0) stiffness[f] *= 1 + 2.0 * (kRings + 1 - ring[f]) / (kRings + 1);
  }
}

StiffeningResult solve_with_stiffening(MapSystem& system, const MapProblem& problem,
                                       const TriangleShapes& shapes, int most_rounds,
                                       std::vector<double>& stiffness, Eigen::VectorXd& real,
                                       Eigen::VectorXd& integer) {
  constexpr int kPatience = 3;  // rounds without fewer defects; the untangler then takes over
  StiffeningResult result;
  int best_round = 0;
  std::vector<double> trial_stiffness = stiffness;
  Eigen::VectorXd trial_real = real;
  Eigen::VectorXd trial_integer = integer;
  SparseFactor factor;
  factor.analyzePattern(system.matrix());
  for (;; ++result.rounds) {
    solve_least_squares(system, shapes, trial_stiffness, factor, trial_real, trial_integer);
    const MapCheck check = check_map(problem.surface, problem.sectors,
                                     fixed_point_map(problem.variables, trial_real, trial_integer));
    const int defects = static_cast<int>(check.defects());
    if (result.rounds == 0) result.defects_before = defects;
    if (result.rounds == 0 || defects < result.defects_after) {
      result.defects_after = defects;
      best_round = result.rounds;
      stiffness = trial_stiffness;
      real = trial_real;
      integer = trial_integer;
    }
    if (defects == 0 || result.rounds == most_rounds || result.rounds - best_round == kPatience)
      return result;
    stiffen(problem.surface, defective_triangles(problem, check), trial_stiffness);
  }
}

}  // namespace neurframe
