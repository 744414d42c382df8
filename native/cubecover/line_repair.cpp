#include "cubecover/line_repair.hpp"

#include <algorithm>
#include <utility>

#include "cubecover/arc_removal.hpp"
#include "cubecover/ribbons.hpp"
#include "cubecover/settling.hpp"

namespace neurframe {

namespace {

constexpr int repair_budget = 60000;  // tets that moves across single faces may prepare again
constexpr double move_radius = 1.5;   // mean edge lengths

class RepairSearch : private FieldSearch {
 public:
  explicit RepairSearch(PreparedField& prepared) : FieldSearch(prepared, repair_budget) {}

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
      return !faces.empty() && attempt(std::move(moved), faces);
    });
  }

  bool improve_by_ribbon(const EdgeRings& rings) {
    const std::vector<Ribbon> ribbons = unzipping_ribbons(prepared_.framed, rings);
    return std::any_of(ribbons.begin(), ribbons.end(),
                       [&](const Ribbon& ribbon) { return attempt(ribbon, rings); });
  }

  bool improve_by_moves(const EdgeRings& rings) {
    for (const Eigen::Vector3d& place : grave_places(prepared_.defects)) {
      for (const LineMove& move : line_moves(prepared_.framed, rings, place, move_radius * edge_length_)) {
        if (!may_try()) return false;
        if (attempt({move}, rings)) return true;
      }
    }
    return false;
  }

  bool attempt(const Ribbon& moves, const EdgeRings& rings) {
    FieldMesh moved = prepared_.framed;
    std::vector<int> faces;
    for (const LineMove& move : moves) {
      move_line(moved, rings, move);
      faces.push_back(move.half_face);
    }
    return attempt(std::move(moved), faces);
  }

  // Whether the field with other matchings of some faces is sounder.
  bool attempt(FieldMesh moved, const std::vector<int>& faces) {
    settle_frames(moved, alignments_, faces);
    PreparedField candidate = judged_field(std::move(moved), prepared_.preparation, prepared_.score() - 1);
    candidate.restarts = prepared_.restarts;
    candidate.preparation.line_moves = prepared_.preparation.line_moves + 1;
    return keep_if_sounder(std::move(candidate));
  }
};

// No move of a line gives room to a cusp or a sector of the boundary that has none.
bool is_beyond_moves(const Defect& defect) {
  return defect.kind == Defect::Kind::empty_sector || defect.kind == Defect::Kind::overfull_sector ||
         defect.kind == Defect::Kind::cusp;
}

}  // namespace

PreparedField with_line_repairs(PreparedField prepared) {
  if (std::any_of(prepared.defects.begin(), prepared.defects.end(), is_beyond_moves)) return prepared;
  RepairSearch search(prepared);
  while (prepared.score() > 0 && search.improve()) {
  }
  return prepared;
}

}  // namespace neurframe
