// Matchings between the frames of neighbouring tets and their holonomy round edges (Nieser et al. 2011,
// section 3).
#pragma once

#include <span>

#include "cubecover/field_mesh.hpp"

namespace neurframe {

Eigen::Matrix3d to_matrix(OctahedralRotation rotation);

// The R of the 24 for which R from^T is nearest to to^T, the target gradients of the two charts.
OctahedralRotation best_matching(const Eigen::Matrix3d& from, const Eigen::Matrix3d& to);

// Frobenius distance |to^T - R from^T| of a matching; 0 for frames that agree, at most sqrt(12).
double mismatch(const Eigen::Matrix3d& from, const Eigen::Matrix3d& to, OctahedralRotation matching);

// Sets every face's matching to the best one.
void match_faces(FieldMesh& mesh);

void set_matching(FieldMesh& mesh, int half_face, OctahedralRotation matching);  // on both sides

// The product of the matchings across the half-faces of a walk: u_last = R u_first + integers.
OctahedralRotation transport(const FieldMesh& mesh, std::span<const int> walk);

// Once round an interior edge, in the chart of the ring's first tet: u -> H u + integers.
inline OctahedralRotation holonomy(const FieldMesh& mesh, std::span<const int> ring) {
  return transport(mesh, ring);
}

}  // namespace neurframe
