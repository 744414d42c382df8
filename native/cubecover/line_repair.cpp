#include "cubecover/line_repair.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "cubecover/arc_orientation.hpp"
#include "cubecover/arc_removal.hpp"
#include "cubecover/parting_ribbons.hpp"
#include "cubecover/settling.hpp"

namespace neurframe {

namespace {

// tets that may be prepared again: by moves across single faces, by partings of lines
constexpr int repair_budget = 60000;
constexpr int parting_budget = 300000;
constexpr double move_radius = 1.5;  // mean edge lengths

// What searches by moves of lines share.
class LineSearch : protected FieldSearch {
 protected:
  using FieldSearch::FieldSearch;
  ~LineSearch() = default;

  FieldMesh moved_along(const Ribbon& moves, const EdgeRings& rings) const {
    FieldMesh moved = prepared_.framed;
    std::vector<int> faces;
    for (const LineMove& move : moves) {
      move_line(moved, rings, move);
      faces.push_back(move.half_face);
    }
    settle_frames(moved, alignments_, faces);
    return moved;
  }

  // The field with other matchings of some faces.
  PreparedField judged(FieldMesh moved, double most_score) const {
    PreparedField candidate = judged_field(std::move(moved), prepared_.preparation, most_score);
    ++candidate.preparation.line_moves;
    return candidate;
  }
};

class RepairSearch : private LineSearch {
 public:
  explicit RepairSearch(PreparedField& prepared) : LineSearch(prepared, repair_budget) {}

  // Whole arcs first, single faces last: those are many.
  bool improve() {
    const EdgeRings rings = edge_rings(prepared_.framed.tets, prepared_.framed.twin);
    return improve_by_removal(rings) || improve_by_ribbon(rings) || improve_by_moves(rings);
  }

 private:
  bool improve_by_removal(const EdgeRings& rings) {
    const SingularGraph graph = find_singular_graph(prepared_.framed, rings);
    return std::any_of(graph.arcs.begin(), graph.arcs.end(), [&](const SingularArc& arc) {
      FieldMesh moved = prepared_.framed;
      const std::vector<int> faces = remove_arc(moved, rings, graph, arc);
      if (faces.empty()) return false;
      settle_frames(moved, alignments_, faces);
      return attempt(std::move(moved));
    });
  }

  bool improve_by_ribbon(const EdgeRings& rings) {
    const std::vector<Ribbon> ribbons = unzipping_ribbons(prepared_.framed, rings);
    return std::any_of(ribbons.begin(), ribbons.end(),
                       [&](const Ribbon& ribbon) { return attempt(moved_along(ribbon, rings)); });
  }

  bool improve_by_moves(const EdgeRings& rings) {
    for (const Eigen::Vector3d& place : grave_places(prepared_.defects)) {
      for (const LineMove& move : line_moves(prepared_.framed, rings, place, move_radius * edge_length_)) {
        if (!may_try()) return false;
        if (attempt(moved_along({move}, rings))) return true;
      }
    }
    return false;
  }

  bool attempt(FieldMesh moved) { return keep_if_sounder(judged(std::move(moved), prepared_.score() - 1)); }
};

using NodeChoice = std::vector<int> (*)(const SingularGraph&);

std::vector<int> all_nodes(const SingularGraph& graph) {
  return graph.nodes;
}

// Parts lines from chosen nodes while fewer edges meet at such nodes for it and the score does not rise.
class PartingSearch : private LineSearch {
 public:
  PartingSearch(PreparedField& prepared, NodeChoice choice)
      : LineSearch(prepared, parting_budget), choice_(choice) {}

  bool improve() {
    const EdgeRings rings = edge_rings(prepared_.framed.tets, prepared_.framed.twin);
    const SingularGraph graph = oriented_singular_graph(prepared_.framed, rings);
    for (const Ribbon& ribbon : parting_ribbons(prepared_.framed, rings, graph, choice_(graph))) {
      if (failed_.contains(key_of(ribbon))) continue;
      if (!may_try()) return false;
      PreparedField candidate = judged(moved_along(ribbon, rings), prepared_.score());
      if (candidate.score() <= prepared_.score() && edges_at_nodes(candidate) < edges_at_nodes(prepared_)) {
        prepared_ = std::move(candidate);
        return true;
      }
      failed_.insert(key_of(ribbon));
    }
    return false;
  }

 private:
  std::size_t edges_at_nodes(const PreparedField& prepared) const {
    const SingularGraph& graph = prepared.field.singular;
    std::size_t count = 0;
    for (const int node : choice_(graph)) count += at(graph.edges_of_vertex, node).size();
    return count;
  }

  // Its first edge and its last face.
  static std::pair<int, int> key_of(const Ribbon& ribbon) {
    return {ribbon.front().ring, ribbon.back().half_face};
  }

  NodeChoice choice_;
  std::set<std::pair<int, int>> failed_;
};

void repair(PreparedField& prepared) {
  RepairSearch search(prepared);
  while (prepared.score() > 0 && search.improve()) {
  }
}

// Whether any was parted.
bool part_lines(PreparedField& prepared, NodeChoice choice) {
  PartingSearch search(prepared, choice);
  bool parted = false;
  while (search.improve()) parted = true;
  return parted;
}

// No move of a line gives room to a cusp or a sector of the boundary that has none.
bool is_beyond_moves(const Defect& defect) {
  return defect.kind == Defect::Kind::empty_sector || defect.kind == Defect::Kind::overfull_sector ||
         defect.kind == Defect::Kind::cusp;
}

}  // namespace

PreparedField with_line_repairs(PreparedField prepared) {
  if (std::any_of(prepared.defects.begin(), prepared.defects.end(), is_beyond_moves)) return prepared;
  repair(prepared);
  if (part_lines(prepared, impossible_nodes)) repair(prepared);
  return prepared;
}

PreparedField with_lines_parted(FieldMesh mesh, const Preparation& preparation) {
  PreparedField prepared = judged_field(std::move(mesh), preparation);
  part_lines(prepared, impossible_nodes);
  part_lines(prepared, all_nodes);
  return prepared;
}

}  // namespace neurframe
