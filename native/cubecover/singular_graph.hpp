// The singular edges of a matched field, joined to arcs between nodes.
#pragma once

#include <string>

#include "cubecover/boundary_axes.hpp"

namespace neurframe {

// An interior edge whose holonomy is not the identity.
struct SingularEdge {
  EdgeKey vertices;
  int ring;  // index into the edge rings
  int tet;   // the first tet of the ring, in whose chart axis and turn are given
  OctahedralRotation holonomy;
  int axis;             // chart axis along the edge; -1 for a compound edge
  int orientation;      // +1 when the frame's axis points from vertices[0] to vertices[1], -1 otherwise
  int valence;          // hexes round the edge: 3, 5, 2, 6; 0 for a compound edge
  double off_axis_deg;  // angle between the edge and the frame's axis
};

// The chart axis along the edge, pointing towards its end vertex or away from it.
SignedAxis axis_at(const SingularEdge& edge, int vertex, bool towards);

struct SingularArc {
  std::vector<int> edges;     // indices into SingularGraph::edges, in order along the arc
  std::vector<int> vertices;  // one more than edges; first == last for a loop
  int valence;                // of its first edge
};

struct SingularGraph {
  std::vector<SingularEdge> edges;
  std::vector<SingularArc> arcs;
  std::vector<int> nodes;                         // interior vertices with other than two singular edges
  std::vector<std::vector<int>> edges_of_vertex;  // per mesh vertex: indices into edges
};

SingularGraph find_singular_graph(const FieldMesh& mesh, const EdgeRings& rings);

}  // namespace neurframe
