// The map on the fixed-point grid, and the exact tests that decide whether it is accepted.
#pragma once

#include "core/fixed_point.hpp"
#include "cubecover/constraints.hpp"
#include "cubecover/reduced_map.hpp"

namespace neurframe {

struct ExactMap {
  int fraction_bits = 0;
  std::vector<std::array<Vector3<Fixed>, 4>> parameters;  // per tet and corner
};

// The free reals go to the grid, everything else follows exactly.  Raises StageError when the map is too
// large for 40-bit coordinates.
ExactMap round_to_grid(const ReducedMap& map, const Eigen::VectorXd& columns);

// Everything that keeps the map from being a valid integer-grid map; tested on the parameters alone, in
// integers.
struct Verification {
  std::vector<int> folded_tets;      // determinant not positive
  std::vector<int> open_seams;       // half-faces whose transition is not R with one integer translation
  std::vector<int> unaligned_faces;  // boundary half-faces that are not on an integer plane
  struct WoundEdge {
    int ring;
    int quarter_turns;  // -1 when they cannot be counted: a folded tet in the star, or an edge off its axis
    int expected;
  };
  std::vector<WoundEdge> wound_edges;  // the image turns round them too often or too seldom

  bool valid() const {
    return folded_tets.empty() && open_seams.empty() && unaligned_faces.empty() && wound_edges.empty();
  }
};

Verification verify(const CombedField& field, const ExactMap& map);

}  // namespace neurframe
