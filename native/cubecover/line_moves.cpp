#include "cubecover/line_moves.hpp"

#include <algorithm>

namespace neurframe {

namespace {

// Once round the edge, beginning with the half-face.
OctahedralRotation holonomy_from(const FieldMesh& mesh, std::span<const int> ring, int half_face) {
  std::vector<int> walk(ring.begin(), ring.end());
  std::rotate(walk.begin(), std::find(walk.begin(), walk.end(), half_face), walk.end());
  return transport(mesh, walk);
}

}  // namespace

std::vector<LineMove> line_moves(const FieldMesh& mesh, const EdgeRings& rings, const Eigen::Vector3d& center,
                                 double radius) {
  std::vector<LineMove> moves;
  for (std::size_t e = 0; e < rings.vertices.size(); ++e) {
    const auto [a, b] = rings.vertices[e];
    if (rings.on_boundary[e]) continue;
    if (((at(mesh.points, a) + at(mesh.points, b)) / 2 - center).norm() > radius) continue;
    const std::span<const int> ring = rings.ring(e);
    if (holonomy(mesh, ring).is_identity()) continue;
    for (const int h : ring) moves.push_back({h, static_cast<int>(e)});
  }
  return moves;
}

void move_line(FieldMesh& mesh, const EdgeRings& rings, const LineMove& move) {
  const std::span<const int> ring = rings.ring(static_cast<std::size_t>(move.ring));
  const OctahedralRotation turn = holonomy_from(mesh, ring, move.half_face);
  set_matching(mesh, move.half_face, at(mesh.matchings, move.half_face) * turn.inverse());
}

}  // namespace neurframe
