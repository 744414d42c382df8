#include "cubecover/turning_borders.hpp"

#include <cmath>

#include "cubecover/borders.hpp"

namespace neurframe {

namespace {

struct Turn {
  std::size_t step = 0;  // the first one behind it
  double before = 0;     // bends
  double behind = 0;
};

// The step after which the bends before and behind differ most.
Turn turn_of(const Border& border) {
  const double total = bend_of(border);
  Turn turn;
  double sum = 0, most = -1;
  for (std::size_t i = 0; i + 1 < border.size(); ++i) {
    sum += border[i].bend;
    if (std::abs(sum - (total - sum)) <= most) continue;
    most = std::abs(sum - (total - sum));
    turn = {i + 1, sum, total - sum};
  }
  return turn;
}

}  // namespace

std::vector<TurningBorder> find_turning_borders(const FieldMesh& mesh, const std::vector<BoundaryEdge>& edges,
                                                const std::vector<SignedAxis>& labels) {
  std::vector<TurningBorder> found;
  const double enough = least_bend(mesh, edges);
  for (const Border& border : find_borders(mesh, edges, labels)) {
    const Turn turn = turn_of(border);
    if (turn.before * turn.behind >= 0 || std::min(std::abs(turn.before), std::abs(turn.behind)) < enough)
      continue;
    const BoundaryEdge& first = at(edges, border.front().edge);
    const int begin = at(labels, first.begin_face).axis;
    const int end = at(labels, first.end_face).axis;
    if (begin == end) continue;
    TurningBorder turning{{begin, end}, {}};
    for (std::size_t i = 0; i < border.size(); ++i) {
      const std::size_t part = (i < turn.step) == (turn.before > 0) ? 0 : 2;
      const BoundaryEdge& edge = at(edges, border[i].edge);
      turning.parts[part].push_back(border[i].forwards ? edge.begin_face : edge.end_face);
      turning.parts[part + 1].push_back(border[i].forwards ? edge.end_face : edge.begin_face);
    }
    found.push_back(std::move(turning));
  }
  return found;
}

}  // namespace neurframe
