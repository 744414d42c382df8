// Minimum cuts of small sparse graphs.
#pragma once

#include <vector>

namespace neurframe {

// A graph between a source and a sink with real capacities; Dinic's algorithm (1970).  Nodes are numbered
// from zero; source and sink are extra.
class MinimumCut {
 public:
  explicit MinimumCut(int node_count);

  // The cost of a node on the source's side, and of one on the sink's side; negative costs may be given.
  void add_node_cost(int node, double source_side, double sink_side);

  // The cost of a cut between two nodes: with `from` on the source's side and `to` on the sink's side.
  void add_edge(int from, int to, double capacity);

  // Per node, whether it is on the sink's side of a cut of least cost.
  std::vector<char> sink_side();

 private:
  struct Arc {
    int to;
    double capacity;
  };

  void connect(int from, int to, double capacity, double back);
  bool find_levels();
  double push(int node, double limit);
  std::vector<char> reached_from_source() const;

  int source_;
  int sink_;
  std::vector<Arc> arcs_;  // arc i runs against arc i ^ 1
  std::vector<std::vector<int>> arcs_of_node_;
  std::vector<double> surplus_;  // per node: cost on the sink's side less that on the source's side
  std::vector<int> level_;       // arcs to the sink; -1 for nodes farther than the source
  std::vector<std::size_t> next_arc_;
};

}  // namespace neurframe
