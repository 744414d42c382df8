// Which interior nodes a hex mesh can have.
#pragma once

#include <array>
#include <utility>

namespace neurframe {

// Numbers of edges of valence 3 and of valence 5 that meet in an interior vertex of a hex mesh whose edges
// have the valences 3, 4 and 5.
using NodeType = std::pair<int, int>;

// The hexes round an interior vertex cut a small sphere into triangles, one a hex; a corner of the triangles
// is an edge, and their number there its valence.  By Euler's formula 3 n3 + 2 n4 + n5 = 12, and of the
// triangulations with such degrees only these exist (Liu, Zhang, Chien, Solomon and Bommes 2018).  The table
// is made anew, from all triangulations of 4 to 11 corners, in tests/test_nodes.cpp.
constexpr std::array<NodeType, 11> node_types = {
    {{4, 0}, {2, 0}, {0, 0}, {2, 2}, {0, 2}, {1, 3}, {0, 4}, {2, 6}, {0, 6}, {0, 8}, {0, 12}}};

bool is_node_type(const NodeType& type);

}  // namespace neurframe
