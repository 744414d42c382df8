// Boundary faces as elements of the foldover-free energy.
#pragma once

#include "cubecover/targets.hpp"

namespace neurframe {

// Tets that keep their orientation may still fold the boundary: where two faces of one plane come to lie on
// each other, the solid turns once all the way round the edge between them, and no tet is folded.  So each
// boundary face is an element, whose S is that of its tet along the face, while the face's normal goes to
// the outward axis: det S is the face's area in its plane, negative where it is seen from inside.
struct FaceTarget {
  int tet;
  Eigen::Matrix<double, 4, 3> relative;  // S = U relative + offset, as for tets
  Eigen::Matrix3d offset;
  double weight;
};

std::vector<FaceTarget> make_face_targets(const CombedField& field, const TetTargets& targets);

inline Eigen::Matrix3d relative_gradient(const FaceTarget& face, const ReducedMap& map,
                                         const Eigen::VectorXd& rows) {
  return corner_parameters(map, rows, face.tet) * face.relative + face.offset;
}

// The smallest determinant, and how many faces are seen from inside.
Foldover measure_turned_faces(const std::vector<FaceTarget>& faces, const ReducedMap& map,
                              const Eigen::VectorXd& rows);

}  // namespace neurframe
