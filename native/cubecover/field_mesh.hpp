// A tet mesh that carries one frame per tet and one matching per half-face: what the preparing steps change
// and every later step reads.  Half-faces and edge rings are those of core/tet_mesh.hpp and
// core/edge_rings.hpp.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <vector>

#include "core/edge_rings.hpp"
#include "core/octahedral_rotation.hpp"
#include "cubecover/indexing.hpp"

namespace neurframe {

using EdgeKey = std::array<int, 2>;  // vertex pair, the smaller one first

inline EdgeKey edge_key(int a, int b) {
  return a < b ? EdgeKey{a, b} : EdgeKey{b, a};
}

struct FieldMesh {
  std::vector<Eigen::Vector3d> points;
  std::vector<Tet> tets;                // positively oriented
  std::vector<Eigen::Matrix3d> frames;  // per tet; columns are unit axes, right-handed
  std::vector<EdgeKey> features;        // sorted; edges of the boundary that the hexes must follow
  std::vector<int> twin;                // per half-face; -1 at the boundary
  // per half-face: u_neighbor = R u_tet + integers (Nieser et al. 2011, section 3); twins hold inverses
  std::vector<OctahedralRotation> matchings;

  int tet_count() const { return static_cast<int>(tets.size()); }
  int point_count() const { return static_cast<int>(points.size()); }
  int half_face_count() const { return static_cast<int>(twin.size()); }
};

// The mesh with its twins found, tets turned positive, frames made right-handed and orthonormal, and identity
// matchings.  Raises InputError for degenerate tets, frames that are none, and faces in more than two tets.
FieldMesh make_field_mesh(std::vector<Eigen::Vector3d> points, std::vector<Tet> tets,
                          std::vector<Eigen::Matrix3d> frames, std::vector<EdgeKey> features);

// The ring of the edge between two vertices of a tet.
int ring_of(const FieldMesh& mesh, const EdgeRings& rings, int tet, int a, int b);

// The vertex of a half-face that is none of two others.
int third_vertex(const FieldMesh& mesh, int half_face, int a, int b);

double tet_volume(const FieldMesh& mesh, int tet);
double edge_length(const FieldMesh& mesh, const EdgeKey& edge);
Eigen::Vector3d edge_middle(const FieldMesh& mesh, const EdgeKey& edge);
Eigen::Vector3d tet_center(const FieldMesh& mesh, int tet);
Eigen::Vector3d area_vector(const FieldMesh& mesh, int half_face);  // outward normal times area
double diagonal(const FieldMesh& mesh);                             // of the bounding box
std::vector<char> boundary_vertices(const FieldMesh& mesh);
bool is_feature(const FieldMesh& mesh, const EdgeKey& edge);

// Boundary edges whose two faces' normals differ by more than the angle, as sorted keys.
std::vector<EdgeKey> sharp_edges(const FieldMesh& mesh, double angle_deg);

}  // namespace neurframe
