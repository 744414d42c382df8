#include "cubecover/vertex_star.hpp"

#include <map>

namespace neurframe {

OctahedralRotation transport_in_star(const FieldMesh& mesh, int vertex, int from, int to) {
  std::map<int, OctahedralRotation> reached = {{from, OctahedralRotation()}};
  std::vector<int> queue = {from};
  for (std::size_t i = 0; i < queue.size() && !reached.contains(to); ++i) {
    for (int h = 4 * queue[i]; h < 4 * queue[i] + 4; ++h) {
      const int twin = at(mesh.twin, h);
      if (twin < 0 || reached.contains(twin / 4) || corner_of(at(mesh.tets, twin / 4), vertex) < 0) continue;
      reached[twin / 4] = at(mesh.matchings, h) * reached[queue[i]];
      queue.push_back(twin / 4);
    }
  }
  return reached.at(to);
}

}  // namespace neurframe
