// The transition functions and integer boundary planes that a map in floating point stands for.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/extraction/grid_map.hpp"
#include "core/parallel.hpp"

namespace neurframe {

// How far parameters may be from what an integer-grid map demands, in cells.  Written with six digits, maps
// of a hundred cells are off by 1e-4; a hundredth of a cell is still far from any other integer.
inline constexpr double map_tolerance = 1e-2;

struct BoundaryPlane {
  int axis = -1;  // -1: the face lies on no integer plane
  int value = 0;  // in cells
};

// The map as the file has it: parameters in cells, per simplex and corner.
template <int N>
using RealParameters = std::vector<std::array<RealPoint<N>, N + 1>>;

template <int N>
struct RecoveredTransitions {
  std::vector<FacetTransition<N>> transition;  // per facet; not exact yet
  std::vector<BoundaryPlane> boundary;         // per facet, meaningful where the twin is -1
  std::vector<int> impossible;                 // interior facets that no grid symmetry carries across
  std::vector<int> unaligned;                  // boundary facets on no integer plane
};

namespace detail {

template <int N>
using FacetParameters = std::type_identity_t<std::array<RealPoint<N>, N>>;

// The parameters of the corners of a facet as simplex `seen_by` has them, in the order of the facet.
template <int N>
FacetParameters<N> seen_from(const GridMap<N>& map, const RealParameters<N>& real, int facet, int seen_by) {
  const std::array<int, N> vertices = facet_vertices<N>(map.S, facet);
  const auto t = static_cast<std::size_t>(seen_by);
  FacetParameters<N> seen{};
  for (std::size_t k = 0; k < N; ++k)
    seen[k] = real[t][static_cast<std::size_t>(corner_at(map.S[t], vertices[k]))];
  return seen;
}

template <std::size_t Size>
double largest_entry(const std::array<double, Size>& x) {
  double largest = 0.0;
  for (const double entry : x) largest = std::max(largest, std::abs(entry));
  return largest;
}

// Per rotation R of the grid the largest |R (edge of a) - (edge of b)| over the edges from the first corner.
inline std::array<double, 4> rotation_residuals(const FacetParameters<2>& a, const FacetParameters<2>& b) {
  std::array<double, 4> residuals{};
  for (int r = 0; r < 4; ++r) {
    residuals[static_cast<std::size_t>(r)] =
        largest_entry(difference(QuarterTurn(r)(difference(a[1], a[0])), difference(b[1], b[0])));
  }
  return residuals;
}

// A rotation is a signed permutation, so its residual is the largest of three out of 18 misfits: by row and,
// in each, 2 axis + (1 where the sign is negative).
using RowMisfits = std::array<std::array<double, 6>, 3>;

inline RowMisfits row_misfits(const FacetParameters<3>& a, const FacetParameters<3>& b) {
  RowMisfits misfits{};
  for (std::size_t k = 1; k < 3; ++k) {
    const RealPoint<3> from = difference(a[k], a[0]);
    const RealPoint<3> to = difference(b[k], b[0]);
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        double* const pair = &misfits[row][2 * axis];
        pair[0] = std::max(pair[0], std::abs(from[axis] - to[row]));
        pair[1] = std::max(pair[1], std::abs(-from[axis] - to[row]));
      }
    }
  }
  return misfits;
}

inline std::array<double, 24> rotation_residuals(const RowMisfits& misfits) {
  std::array<double, 24> residuals{};
  for (int r = 0; r < 24; ++r) {
    const OctahedralRotation R(r);
    for (int row = 0; row < 3; ++row) {
      const int entry = 2 * R.axis(row) + (R.sign(row) < 0 ? 1 : 0);
      double& residual = residuals[static_cast<std::size_t>(r)];
      residual = std::max(residual, misfits[static_cast<std::size_t>(row)][static_cast<std::size_t>(entry)]);
    }
  }
  return residuals;
}

template <int N>
struct TransitionChoice {
  Rotation<N> rotation;
  RealPoint<N> translation{};  // mean over the corners, before rounding
  double residual = 0.0;       // of the rotation
  bool ambiguous = false;      // other rotations fit as well
  bool integral = false;
};

template <int N>
void measure_translation(const FacetParameters<N>& a, const FacetParameters<N>& b,
                         TransitionChoice<N>& choice) {
  choice.translation = {};
  for (std::size_t k = 0; k < N; ++k) {
    const RealPoint<N> shift = difference(b[k], choice.rotation(a[k]));
    for (std::size_t i = 0; i < N; ++i) choice.translation[i] += shift[i] / N;
  }
  choice.integral = true;
  for (const double t : choice.translation) {
    choice.integral =
        choice.integral && std::abs(t - std::nearbyint(t)) <= map_tolerance && std::abs(t) < 1e9;
  }
}

template <int N>
TransitionChoice<N> fitted_transition(const FacetParameters<N>& a, const FacetParameters<N>& b, int rotation,
                                      double residual) {
  TransitionChoice<N> choice;
  choice.rotation = Rotation<N>(rotation);
  choice.residual = residual;
  measure_translation<N>(a, b, choice);
  return choice;
}

// How far from the best residual another rotation still counts as fitting.
inline double close_residual(double best) {
  return std::max(4.0 * best, 1e-9);
}

// Of several rotations that fit (a thin facet) the first with an integer translation counts, the identity
// before all others.
template <int N>
TransitionChoice<N> best_of(const std::array<double, Dimension<N>::rotations>& residuals,
                            const FacetParameters<N>& a, const FacetParameters<N>& b) {
  const auto best = std::min_element(residuals.begin(), residuals.end());
  const double close = close_residual(*best);
  const bool ambiguous =
      std::count_if(residuals.begin(), residuals.end(), [&](double x) { return x <= close; }) > 1;
  TransitionChoice<N> choice = fitted_transition<N>(a, b, static_cast<int>(best - residuals.begin()), *best);
  for (std::size_t r = 0; r < residuals.size() && ambiguous; ++r) {
    if (residuals[r] > close) continue;
    choice = fitted_transition<N>(a, b, static_cast<int>(r), residuals[r]);
    if (choice.integral) break;
  }
  choice.ambiguous = ambiguous;
  return choice;
}

// By the entry of each row of a signed permutation (see RowMisfits): its number, or 255 for no rotation.
constexpr std::array<std::uint8_t, 216> rotations_by_rows() {
  std::array<std::uint8_t, 216> table{};
  table.fill(255);
  for (int r = 0; r < 24; ++r) {
    const OctahedralRotation R(r);
    int key = 0;
    for (int row = 0; row < 3; ++row) key = 6 * key + 2 * R.axis(row) + (R.sign(row) < 0 ? 1 : 0);
    table[static_cast<std::size_t>(key)] = static_cast<std::uint8_t>(r);
  }
  return table;
}

// The rotation of which every row fits far better than any other row could; -1 where there is none such.  It
// is the best one, and no other fits as well.
inline int unrivalled_rotation(const RowMisfits& misfits, double& residual) {
  static constexpr std::array<std::uint8_t, 216> numbers = rotations_by_rows();
  std::size_t key = 0;
  double second = INFINITY;
  residual = 0.0;
  for (const std::array<double, 6>& row : misfits) {
    const auto best = std::min_element(row.begin(), row.end());
    for (auto other = row.begin(); other != row.end(); ++other) {
      if (other != best) second = std::min(second, *other);
    }
    residual = std::max(residual, *best);
    key = 6 * key + static_cast<std::size_t>(best - row.begin());
  }
  return numbers[key] < 24 && second > close_residual(residual) ? numbers[key] : -1;
}

// The grid symmetry that carries a to b best.
inline TransitionChoice<2> best_transition(const FacetParameters<2>& a, const FacetParameters<2>& b) {
  return best_of<2>(rotation_residuals(a, b), a, b);
}

inline TransitionChoice<3> best_transition(const FacetParameters<3>& a, const FacetParameters<3>& b) {
  const RowMisfits misfits = row_misfits(a, b);
  double residual = 0.0;
  const int rotation = unrivalled_rotation(misfits, residual);
  return rotation >= 0 ? fitted_transition<3>(a, b, rotation, residual)
                       : best_of<3>(rotation_residuals(misfits), a, b);
}

inline RealPoint<3> real_normal(const FacetParameters<3>& x) {
  const RealPoint<3> a = difference(x[1], x[0]);
  const RealPoint<3> b = difference(x[2], x[0]);
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline RealPoint<2> real_normal(const FacetParameters<2>& x) {
  return {x[1][1] - x[0][1], x[0][0] - x[1][0]};
}

// The plane u[axis] = integer that the facet lies on; of several (a thin facet) the one it faces most.
template <int N>
BoundaryPlane integer_plane(const FacetParameters<N>& facet) {
  const RealPoint<N> normal = real_normal(facet);
  BoundaryPlane plane;
  double facing = -1.0;
  for (std::size_t i = 0; i < N; ++i) {
    double mean = 0.0;
    for (const RealPoint<N>& u : facet) mean += u[i] / N;
    const double value = std::nearbyint(mean);
    double deviation = 0.0;
    for (const RealPoint<N>& u : facet) deviation = std::max(deviation, std::abs(u[i] - value));
    if (deviation > map_tolerance || std::abs(normal[i]) <= facing) continue;
    facing = std::abs(normal[i]);
    plane = {static_cast<int>(i), static_cast<int>(value)};
  }
  return plane;
}

template <int N>
void set_transition(const GridTransition<N>& given, bool ambiguous, FacetTransition<N>& transition) {
  transition.rotation = given.rotation;
  transition.ambiguous = ambiguous;
  for (std::size_t i = 0; i < N; ++i)
    transition.translation[i] = static_cast<std::int32_t>(given.translation[i]);
}

// Sets the transition across facet h, and its inverse behind.
template <int N>
void set_transitions(const std::vector<int>& twin, int h, const TransitionChoice<N>& choice,
                     std::vector<FacetTransition<N>>& transition) {
  GridTransition<N> forward{choice.rotation, {}};
  for (std::size_t i = 0; i < N; ++i) forward.translation[i] = std::llround(choice.translation[i]);
  const auto here = static_cast<std::size_t>(h);
  set_transition<N>(forward, choice.ambiguous, transition[here]);
  set_transition<N>(forward.inverse(), choice.ambiguous, transition[static_cast<std::size_t>(twin[here])]);
}

}  // namespace detail

template <int N>
bool is_possible(const detail::TransitionChoice<N>& choice) {
  return choice.integral && choice.residual <= map_tolerance;
}

// Transitions per facet and planes per boundary facet, with lists of what no integer-grid map can have.
template <int N>
RecoveredTransitions<N> recover_transitions(const GridMap<N>& map, const RealParameters<N>& real,
                                            int threads) {
  RecoveredTransitions<N> found;
  found.transition.resize(map.twin.size());
  found.boundary.resize(map.twin.size());
  const auto facets = static_cast<std::int64_t>(map.twin.size());
  found.impossible =
      parallel_collect<int>(facets, threads, [&](std::int64_t begin, std::int64_t end, auto& bad) {
        for (int h = static_cast<int>(begin); h < end; ++h) {
          const int other = map.twin[static_cast<std::size_t>(h)];
          if (other < h) continue;
          const detail::TransitionChoice<N> choice = detail::best_transition(
              detail::seen_from(map, real, h, h / (N + 1)), detail::seen_from(map, real, h, other / (N + 1)));
          if (!is_possible(choice)) bad.push_back(h);
          if (is_possible(choice)) detail::set_transitions<N>(map.twin, h, choice, found.transition);
        }
      });
  found.unaligned =
      parallel_collect<int>(facets, threads, [&](std::int64_t begin, std::int64_t end, auto& bad) {
        for (int h = static_cast<int>(begin); h < end; ++h) {
          if (map.twin[static_cast<std::size_t>(h)] >= 0) continue;
          BoundaryPlane& plane = found.boundary[static_cast<std::size_t>(h)];
          plane = detail::integer_plane<N>(detail::seen_from(map, real, h, h / (N + 1)));
          if (plane.axis < 0) bad.push_back(h);
        }
      });
  return found;
}

}  // namespace neurframe
