#include "cubecover/node_types.hpp"

#include <algorithm>

namespace neurframe {

bool is_node_type(const NodeType& type) {
  return std::find(node_types.begin(), node_types.end(), type) != node_types.end();
}

}  // namespace neurframe
