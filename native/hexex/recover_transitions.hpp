// The transition functions and integer boundary planes that a map in floating point stands for.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "core/hex_map_io.hpp"
#include "core/parallel.hpp"
#include "hexex/grid_map.hpp"

namespace neurframe {

// How far parameters may be from what an integer-grid map demands, in cells.  Written with six digits, maps
// of a hundred cells are off by 1e-4; a hundredth of a cell is still far from any other integer.
inline constexpr double map_tolerance = 1e-2;

struct BoundaryPlane {
  int axis = -1;  // -1: the face lies on no integer plane
  int value = 0;  // in cells
};

struct RecoveredTransitions {
  std::vector<FaceTransition> transition;  // per half-face; not exact yet
  std::vector<char> ambiguous;  // per half-face: the image of the face is too thin to tell the rotation
  std::vector<BoundaryPlane> boundary;  // per half-face, meaningful where the twin is -1
  std::vector<int> impossible;          // interior half-faces that no grid symmetry carries across
  std::vector<int> unaligned;           // boundary half-faces on no integer plane
};

namespace detail {

using FaceParameters = std::array<Point3, 3>;

// The parameters of the corners of a half-face as tet `tet_of` sees them, in the order of the half-face.
inline FaceParameters seen_from(const HexMap& map, int half_face, int tet_of) {
  const std::array<int, 3> vertices = half_face_vertices(map.mesh.T, half_face);
  const auto t = static_cast<std::size_t>(tet_of);
  FaceParameters seen{};
  for (std::size_t k = 0; k < 3; ++k) {
    seen[k] = map.parameters[t][static_cast<std::size_t>(corner_of(map.mesh.T[t], vertices[k]))];
  }
  return seen;
}

inline double largest_entry(const Point3& x) {
  return std::max({std::abs(x[0]), std::abs(x[1]), std::abs(x[2])});
}

// max |R (edge of a) - (edge of b)| over two edges
inline double rotation_residual(const OctahedralRotation& R, const FaceParameters& a,
                                const FaceParameters& b) {
  const auto residual = [&](std::size_t k) {
    return largest_entry(difference(R(difference(a[k], a[0])), difference(b[k], b[0])));
  };
  return std::max(residual(1), residual(2));
}

struct TransitionChoice {
  OctahedralRotation rotation;
  Point3 translation{0, 0, 0};  // mean over the corners, before rounding
  double residual = 0.0;        // of the rotation
  bool ambiguous = false;       // other rotations fit as well
  bool integral = false;
};

inline void measure_translation(const FaceParameters& a, const FaceParameters& b, TransitionChoice& choice) {
  choice.translation = {0, 0, 0};
  for (std::size_t k = 0; k < 3; ++k) {
    const Point3 shift = difference(b[k], choice.rotation(a[k]));
    for (std::size_t i = 0; i < 3; ++i) choice.translation[i] += shift[i] / 3.0;
  }
  choice.integral = true;
  for (const double t : choice.translation) {
    choice.integral =
        choice.integral && std::abs(t - std::nearbyint(t)) <= map_tolerance && std::abs(t) < 1e9;
  }
}

// The grid symmetry that carries a to b best.  Of several that do (a thin face) the first with an integer
// translation counts, the identity before all others.
inline TransitionChoice best_transition(const FaceParameters& a, const FaceParameters& b) {
  std::array<double, 24> residual{};
  for (std::size_t r = 0; r < 24; ++r)
    residual[r] = rotation_residual(OctahedralRotation(static_cast<int>(r)), a, b);
  const auto best = std::min_element(residual.begin(), residual.end()) - residual.begin();
  const double close = std::max(4.0 * residual[static_cast<std::size_t>(best)], 1e-9);
  TransitionChoice choice{
      OctahedralRotation(static_cast<int>(best)), {}, residual[static_cast<std::size_t>(best)]};
  choice.ambiguous =
      std::count_if(residual.begin(), residual.end(), [&](double x) { return x <= close; }) > 1;
  measure_translation(a, b, choice);
  for (std::size_t r = 0; r < 24 && choice.ambiguous; ++r) {
    if (residual[r] > close) continue;
    TransitionChoice other{OctahedralRotation(static_cast<int>(r)), {}, residual[r], true};
    measure_translation(a, b, other);
    if (other.integral) return other;
  }
  return choice;
}

// The plane u[axis] = integer that the face lies on; of several (a thin face) the one it faces most.
inline BoundaryPlane integer_plane(const FaceParameters& face) {
  const Point3 a = difference(face[1], face[0]);
  const Point3 b = difference(face[2], face[0]);
  const Point3 normal{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  BoundaryPlane plane;
  double facing = -1.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double value = std::nearbyint((face[0][i] + face[1][i] + face[2][i]) / 3.0);
    double deviation = 0.0;
    for (const Point3& u : face) deviation = std::max(deviation, std::abs(u[i] - value));
    if (deviation > map_tolerance || std::abs(normal[i]) <= facing) continue;
    facing = std::abs(normal[i]);
    plane = {static_cast<int>(i), static_cast<int>(value)};
  }
  return plane;
}

inline void set_transition(const GridTransition3& given, bool ambiguous, FaceTransition& transition) {
  transition.rotation = given.rotation;
  transition.ambiguous = ambiguous;
  for (std::size_t i = 0; i < 3; ++i)
    transition.translation[i] = static_cast<std::int32_t>(given.translation[i]);
}

// False when no grid symmetry fits.
inline bool recover_interior_face(const HexMap& map, const std::vector<int>& twin, int h,
                                  std::vector<FaceTransition>& transition) {
  const int other = twin[static_cast<std::size_t>(h)];
  const TransitionChoice choice = best_transition(seen_from(map, h, h / 4), seen_from(map, h, other / 4));
  if (!choice.integral || choice.residual > map_tolerance) return false;
  GridTransition3 forward{choice.rotation, {}};
  for (std::size_t i = 0; i < 3; ++i) forward.translation[i] = std::llround(choice.translation[i]);
  set_transition(forward, choice.ambiguous, transition[static_cast<std::size_t>(h)]);
  set_transition(forward.inverse(), choice.ambiguous, transition[static_cast<std::size_t>(other)]);
  return true;
}

}  // namespace detail

// Transitions per half-face and planes per boundary half-face, with lists of what no integer-grid map can
// have.
inline RecoveredTransitions recover_transitions(const HexMap& map, const std::vector<int>& twin,
                                                int threads) {
  RecoveredTransitions found;
  found.transition.resize(twin.size());
  found.boundary.resize(twin.size());
  const auto half_faces = static_cast<std::int64_t>(twin.size());
  found.impossible =
      parallel_collect<int>(half_faces, threads, [&](std::int64_t begin, std::int64_t end, auto& bad) {
        for (std::int64_t i = begin; i < end; ++i) {
          const int h = static_cast<int>(i);
          if (twin[static_cast<std::size_t>(h)] < h) continue;
          if (!detail::recover_interior_face(map, twin, h, found.transition)) bad.push_back(h);
        }
      });
  found.unaligned =
      parallel_collect<int>(half_faces, threads, [&](std::int64_t begin, std::int64_t end, auto& bad) {
        for (std::int64_t i = begin; i < end; ++i) {
          const int h = static_cast<int>(i);
          if (twin[static_cast<std::size_t>(h)] >= 0) continue;
          BoundaryPlane& plane = found.boundary[static_cast<std::size_t>(h)];
          plane = detail::integer_plane(detail::seen_from(map, h, h / 4));
          if (plane.axis < 0) bad.push_back(h);
        }
      });
  return found;
}

}  // namespace neurframe
