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

struct RotationChoice {
  OctahedralRotation rotation;
  double residual = 0.0;
  bool ambiguous = false;
};

// The rotation that carries the edges of a to those of b best; the identity wins among equals.
inline RotationChoice best_rotation(const FaceParameters& a, const FaceParameters& b) {
  std::array<double, 24> residual{};
  for (int r = 0; r < 24; ++r)
    residual[static_cast<std::size_t>(r)] = rotation_residual(OctahedralRotation(r), a, b);
  const double least = *std::min_element(residual.begin(), residual.end());
  const double close = std::max(4.0 * least, 1e-9);
  const auto good = std::count_if(residual.begin(), residual.end(), [&](double x) { return x <= close; });
  const auto chosen =
      residual[0] <= close ? residual.begin() : std::min_element(residual.begin(), residual.end());
  return {OctahedralRotation(static_cast<int>(chosen - residual.begin())), *chosen, good > 1};
}

// False when the translation is no integer vector.
inline bool set_translation(const FaceParameters& a, const FaceParameters& b, FaceTransition& transition) {
  bool integral = true;
  Point3 mean{0, 0, 0};
  for (std::size_t k = 0; k < 3; ++k) {
    const Point3 shift = difference(b[k], transition.rotation(a[k]));
    for (std::size_t i = 0; i < 3; ++i) mean[i] += shift[i] / 3.0;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const double rounded = std::nearbyint(mean[i]);
    integral = integral && std::abs(mean[i] - rounded) <= map_tolerance && std::abs(rounded) < 1e9;
    transition.translation[i] = integral ? static_cast<std::int32_t>(rounded) : 0;
  }
  return integral;
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

inline void recover_interior_face(const HexMap& map, const std::vector<int>& twin, int h,
                                  RecoveredTransitions& found, std::vector<int>& impossible) {
  const int other = twin[static_cast<std::size_t>(h)];
  const FaceParameters here = seen_from(map, h, h / 4);
  const FaceParameters there = seen_from(map, h, other / 4);
  const RotationChoice choice = best_rotation(here, there);
  FaceTransition& forward = found.transition[static_cast<std::size_t>(h)];
  FaceTransition& backward = found.transition[static_cast<std::size_t>(other)];
  forward.rotation = choice.rotation;
  if (choice.residual > map_tolerance || !set_translation(here, there, forward)) impossible.push_back(h);
  const GridTransition3 inverse = as_grid_transition(forward).inverse();
  backward.rotation = inverse.rotation;
  for (std::size_t i = 0; i < 3; ++i)
    backward.translation[i] = static_cast<std::int32_t>(inverse.translation[i]);
  found.ambiguous[static_cast<std::size_t>(h)] = found.ambiguous[static_cast<std::size_t>(other)] =
      choice.ambiguous;
}

}  // namespace detail

// Transitions per half-face and planes per boundary half-face, with lists of what no integer-grid map can
// have.
inline RecoveredTransitions recover_transitions(const HexMap& map, const std::vector<int>& twin,
                                                int threads) {
  RecoveredTransitions found;
  found.transition.resize(twin.size());
  found.ambiguous.assign(twin.size(), 0);
  found.boundary.resize(twin.size());
  const auto half_faces = static_cast<std::int64_t>(twin.size());
  found.impossible =
      parallel_collect<int>(half_faces, threads, [&](std::int64_t begin, std::int64_t end, auto& bad) {
        for (std::int64_t i = begin; i < end; ++i) {
          const int h = static_cast<int>(i);
          if (twin[static_cast<std::size_t>(h)] > h) detail::recover_interior_face(map, twin, h, found, bad);
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
