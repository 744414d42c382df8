#include "cubecover/max_flow.hpp"

#include <algorithm>
#include <limits>

#include "cubecover/indexing.hpp"

namespace neurframe {

namespace {

constexpr double negligible = 1e-9;  // capacity; what rounding leaves of an arc that is full

}  // namespace

MinimumCut::MinimumCut(int node_count)
    : source_(node_count),
      sink_(node_count + 1),
      arcs_of_node_(static_cast<std::size_t>(node_count) + 2),
      surplus_(static_cast<std::size_t>(node_count), 0) {}

void MinimumCut::add_node_cost(int node, double source_side, double sink_side) {
  at(surplus_, node) += sink_side - source_side;
}

void MinimumCut::add_edge(int from, int to, double capacity) {
  if (capacity > 0) connect(from, to, capacity, 0);
}

void MinimumCut::connect(int from, int to, double capacity, double back) {
  at(arcs_of_node_, from).push_back(static_cast<int>(arcs_.size()));
  arcs_.push_back({to, capacity});
  at(arcs_of_node_, to).push_back(static_cast<int>(arcs_.size()));
  arcs_.push_back({from, back});
}

// Backwards from the sink: what cannot reach it any more, which in the end is most of the graph, is not
// visited.
bool MinimumCut::find_levels() {
  level_.assign(arcs_of_node_.size(), -1);
  at(level_, sink_) = 0;
  std::vector<int> queue = {sink_};
  for (std::size_t i = 0; i < queue.size() && at(level_, source_) < 0; ++i) {
    for (const int a : at(arcs_of_node_, queue[i])) {
      const int before = at(arcs_, a).to;
      if (at(arcs_, a ^ 1).capacity <= negligible || at(level_, before) >= 0) continue;
      at(level_, before) = at(level_, queue[i]) + 1;
      queue.push_back(before);
    }
  }
  return at(level_, source_) >= 0;
}

// Pushes flow from the node to the sink along arcs that lead one level down; paths are as long as the graph
// has levels, which is few on a surface of bounded labels.
double MinimumCut::push(int node, double limit) {
  if (node == sink_) return limit;
  double pushed = 0;
  for (std::size_t& next = at(next_arc_, node); next < at(arcs_of_node_, node).size(); ++next) {
    const int a = at(arcs_of_node_, node)[next];
    const Arc arc = at(arcs_, a);
    if (arc.capacity <= negligible || at(level_, arc.to) != at(level_, node) - 1) continue;
    const double flow = push(arc.to, std::min(limit - pushed, arc.capacity));
    at(arcs_, a).capacity -= flow;
    at(arcs_, a ^ 1).capacity += flow;
    pushed += flow;
    if (limit - pushed <= negligible) return pushed;
  }
  return pushed;
}

std::vector<char> MinimumCut::reached_from_source() const {
  std::vector<char> reached(arcs_of_node_.size(), 0);
  at(reached, source_) = 1;
  std::vector<int> queue = {source_};
  for (std::size_t i = 0; i < queue.size(); ++i) {
    for (const int a : at(arcs_of_node_, queue[i])) {
      const Arc& arc = at(arcs_, a);
      if (arc.capacity <= negligible || at(reached, arc.to)) continue;
      at(reached, arc.to) = 1;
      queue.push_back(arc.to);
    }
  }
  return reached;
}

std::vector<char> MinimumCut::sink_side() {
  for (int node = 0; node < source_; ++node) {
    const double surplus = at(surplus_, node);
    // a node that is dearer on the sink's side is held to the source
    if (surplus > 0) connect(source_, node, surplus, 0);
    if (surplus < 0) connect(node, sink_, -surplus, 0);
  }
  while (find_levels()) {
    next_arc_.assign(arcs_of_node_.size(), 0);
    push(source_, std::numeric_limits<double>::max());
  }
  const std::vector<char> reached = reached_from_source();
  std::vector<char> sink_side(surplus_.size());
  for (int node = 0; node < source_; ++node) at(sink_side, node) = !at(reached, node);
  return sink_side;
}

}  // namespace neurframe
