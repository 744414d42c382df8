// An integer-grid map of a tet mesh in exact fixed-point coordinates.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/fixed_point.hpp"
#include "core/octahedral_rotation.hpp"
#include "core/tet_mesh.hpp"

namespace neurframe {

using FixedPoint3 = Vector3<Fixed>;

// The transition function across a half-face, from the chart of its tet to the chart of the tet behind it.
struct FaceTransition {
  std::array<std::int32_t, 3> translation{0, 0, 0};  // in cells
  OctahedralRotation rotation;
  bool ambiguous = false;  // the image of the face is too thin to tell the rotation
  bool exact = false;      // it maps the three corners of the face exactly, so that a walk may cross here
};

struct GridMap {
  TetMesh mesh;                               // coherently oriented
  std::vector<int> twin;                      // per half-face, see tet_mesh.hpp
  std::vector<FaceTransition> transition;     // per half-face
  std::vector<std::array<FixedPoint3, 4>> P;  // parameters per tet and corner, in units of 2^-fraction_bits
  std::vector<std::int8_t> orientation;  // sign of the parametric volume per tet: 1, 0 (flat), -1 (flipped)
  std::vector<char> turned;              // per tet: corners 2 and 3 are swapped against the input
  std::vector<char> touches_flat;        // per vertex: some tet around it is flat
  int fraction_bits = 0;

  Fixed one() const { return Fixed{1} << fraction_bits; }
};

inline FixedPoint3 carry(const FaceTransition& transition, const FixedPoint3& x, int fraction_bits) {
  FixedPoint3 moved = transition.rotation(x);
  for (std::size_t i = 0; i < 3; ++i)
    moved[i] += Fixed{transition.translation[i]} * (Fixed{1} << fraction_bits);
  return moved;
}

inline GridTransition3 as_grid_transition(const FaceTransition& transition) {
  const auto& t = transition.translation;
  return {transition.rotation, {t[0], t[1], t[2]}};
}

inline FixedPoint3 face_corner(const GridMap& map, int half_face, int k) {
  const auto corner = face_corners[static_cast<std::size_t>(half_face % 4)][static_cast<std::size_t>(k)];
  return map.P[static_cast<std::size_t>(half_face / 4)][static_cast<std::size_t>(corner)];
}

}  // namespace neurframe
