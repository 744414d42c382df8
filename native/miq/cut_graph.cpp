#include "miq/cut_graph.hpp"

namespace neurframe {
namespace {

void turn_cross(CrossSurface& surface, int f, int quarter_turns) {
  Eigen::Vector3d& axis = surface.axis[static_cast<size_t>(f)];
  for (int i = 0; i < (quarter_turns & 3); ++i) axis = Eigen::Vector3d(surface.second_axis(f));
  for (int h = 3 * f; h < 3 * f + 3; ++h) {
    const int o = surface.twin(h);
    if (o < 0) continue;
    int& there = surface.matching[static_cast<size_t>(h)];
    int& back = surface.matching[static_cast<size_t>(o)];
    there = (there + quarter_turns) & 3;
    back = (back - quarter_turns) & 3;
  }
}

bool is_seam(const CutGraph& graph, int h) {
  return graph.seam[static_cast<size_t>(h)] != 0;
}

void set_seam(const CrossSurface& surface, CutGraph& graph, int h, char value) {
  graph.seam[static_cast<size_t>(h)] = value;
  graph.seam[static_cast<size_t>(surface.twin(h))] = value;
}

// number of seam and boundary edges at each vertex
std::vector<int> seam_degrees(const CrossSurface& surface, const CutGraph& graph) {
  std::vector<int> degree(surface.positions.size(), 0);
  for (int h = 0; h < surface.half_edge_count(); ++h) {
    const bool boundary = surface.twin(h) < 0;
    if (!boundary && !is_seam(graph, h)) continue;
    ++degree[static_cast<size_t>(surface.from(h))];
    if (boundary) ++degree[static_cast<size_t>(surface.to(h))];
  }
  return degree;
}

void prune(const CrossSurface& surface, const std::vector<char>& critical, CutGraph& graph) {
  std::vector<int> degree = seam_degrees(surface, graph);
  const std::vector<int> outgoing = outgoing_half_edges(surface);
  const auto is_tip = [&](int v) {
    return degree[static_cast<size_t>(v)] == 1 && !critical[static_cast<size_t>(v)];
  };
  std::vector<int> tips;
  for (int v = 0; v < surface.vertex_count(); ++v) {
    if (is_tip(v)) tips.push_back(v);
  }
  while (!tips.empty()) {
    const int v = tips.back();
    tips.pop_back();
    if (!is_tip(v)) continue;
    for (const int h : fan(surface, outgoing[static_cast<size_t>(v)])) {
      if (!is_seam(graph, h)) continue;
      set_seam(surface, graph, h, 0);
      --degree[static_cast<size_t>(v)];
      --degree[static_cast<size_t>(surface.to(h))];
      if (is_tip(surface.to(h))) tips.push_back(surface.to(h));
      break;
    }
  }
}

// The seam half-edge that goes on from the head of h with the same side of the cut on its left.
int next_on_left(const CrossSurface& surface, const CutGraph& graph, int h) {
  int k = CrossSurface::next(h);
  while (!is_seam(graph, k)) k = CrossSurface::next(surface.twin(k));
  return k;
}

void trace_branches(const CrossSurface& surface, const std::vector<char>& critical, CutGraph& graph) {
  const std::vector<int> degree = seam_degrees(surface, graph);
  const auto is_node = [&](int v) {
    return degree[static_cast<size_t>(v)] != 2 || critical[static_cast<size_t>(v)];
  };
  std::vector<char> traced(graph.seam.size(), 0);
  const auto trace = [&](int start) {
    SeamBranch branch;
    int h = start;
    while (true) {
      branch.half_edges.push_back(h);
      traced[static_cast<size_t>(h)] = traced[static_cast<size_t>(surface.twin(h))] = 1;
      if (is_node(surface.to(h))) break;
      h = next_on_left(surface, graph, h);
      if (h == start) break;
    }
    graph.branches.push_back(std::move(branch));
  };
  for (int h = 0; h < surface.half_edge_count(); ++h) {
    if (is_seam(graph, h) && !traced[static_cast<size_t>(h)] && is_node(surface.from(h))) trace(h);
  }
  for (int h = 0; h < surface.half_edge_count(); ++h) {
    if (is_seam(graph, h) && !traced[static_cast<size_t>(h)]) trace(h);
  }
}

}  // namespace

std::vector<char> comb(CrossSurface& surface) {
  std::vector<char> crossed(static_cast<size_t>(surface.half_edge_count()), 0);
  std::vector<char> reached(surface.triangles.size(), 0);
  for (int root = 0; root < surface.triangle_count(); ++root) {
    if (reached[static_cast<size_t>(root)]) continue;
    reached[static_cast<size_t>(root)] = 1;
    std::vector<int> queue{root};
    for (size_t i = 0; i < queue.size(); ++i) {
      for (int h = 3 * queue[i]; h < 3 * queue[i] + 3; ++h) {
        const int o = surface.twin(h);
        if (o < 0 || reached[static_cast<size_t>(o / 3)]) continue;
        reached[static_cast<size_t>(o / 3)] = 1;
        crossed[static_cast<size_t>(h)] = crossed[static_cast<size_t>(o)] = 1;
        turn_cross(surface, o / 3, surface.matching[static_cast<size_t>(h)]);
        queue.push_back(o / 3);
      }
    }
  }
  return crossed;
}

CutGraph build_cut_graph(const CrossSurface& surface, const std::vector<char>& crossed,
                         const std::vector<char>& critical) {
  CutGraph graph;
  graph.seam.assign(crossed.size(), 0);
  for (int h = 0; h < surface.half_edge_count(); ++h) {
    graph.seam[static_cast<size_t>(h)] = surface.twin(h) >= 0 && !crossed[static_cast<size_t>(h)];
  }
  prune(surface, critical, graph);
  trace_branches(surface, critical, graph);
  return graph;
}

std::vector<int> corner_sectors(const CrossSurface& surface, const std::vector<char>& seam,
                                int& sector_count) {
  std::vector<int> sector(seam.size(), -1);
  sector_count = 0;
  for (const int start : outgoing_half_edges(surface)) {
    if (start < 0) continue;
    const std::vector<int> corners = fan(surface, start);
    size_t first = 0;
    while (first < corners.size() && !seam[static_cast<size_t>(corners[first])]) ++first;
    first %= corners.size();
    for (size_t i = 0; i < corners.size(); ++i) {
      const int h = corners[(first + i) % corners.size()];
      if (i == 0 || seam[static_cast<size_t>(h)] || surface.twin(h) < 0) ++sector_count;
      sector[static_cast<size_t>(h)] = sector_count - 1;
    }
  }
  return sector;
}

}  // namespace neurframe
