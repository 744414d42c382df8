#include "miq/intrinsic_triangulation.hpp"

#include <algorithm>
#include <utility>

#include "core/quarter_turn.hpp"

namespace neurframe {
namespace {

Vector2<Fixed> plus(const Vector2<Fixed>& a, const Vector2<Fixed>& b) {
  return {a[0] + b[0], a[1] + b[1]};
}

Vector2<Fixed> minus(const Vector2<Fixed>& a) {
  return {-a[0], -a[1]};
}

void turn(IntrinsicEdge& edge, int turns) {
  const QuarterTurn rotation(turns);
  if (rotation.turns() == 0) return;
  for (Vector2<Fixed>& x : edge.along) x = rotation(x);
  if (rotation.turns() != 2) std::swap(edge.symbolic[0], edge.symbolic[1]);
  if (rotation.turns() != 3) edge.symbolic[0] = scaled(edge.symbolic[0], -1);
  if (rotation.turns() != 1) edge.symbolic[1] = scaled(edge.symbolic[1], -1);
}

// a then b, in one chart; a's twin and turns
IntrinsicEdge chained(const IntrinsicEdge& a, const IntrinsicEdge& b) {
  IntrinsicEdge out = a;
  for (size_t i = 0; i < 2; ++i) {
    out.along[i] = plus(a.along[i], b.along[i]);
    out.symbolic[i] = sum(a.symbolic[i], b.symbolic[i]);
  }
  return out;
}

}  // namespace

IntrinsicTriangulation::IntrinsicTriangulation(std::vector<IntrinsicEdge> edges, int vertex_count)
    : edges_(std::move(edges)), outgoing_(static_cast<size_t>(vertex_count), -1) {
  for (int h = 0; h < half_edge_count(); ++h) outgoing_[static_cast<size_t>(edge(h).from)] = h;
}

Vector2<double> IntrinsicTriangulation::along_at(int h, double t) const {
  const auto& [start, end] = edge(h).along;
  return {(1 - t) * static_cast<double>(start[0]) + t * static_cast<double>(end[0]),
          (1 - t) * static_cast<double>(start[1]) + t * static_cast<double>(end[1])};
}

int IntrinsicTriangulation::area_sign(int f, size_t end) const {
  return sign_of(determinant(edge(3 * f).along[end], edge(3 * f + 1).along[end]));
}

// x becomes R^turns x in triangle f
void IntrinsicTriangulation::turn_chart(int f, int turns) {
  for (int h = 3 * f; h < 3 * f + 3; ++h) {
    turn(edge(h), turns);
    edge(h).turns = (edge(h).turns - turns) & 3;
    if (edge(h).twin >= 0) edge(edge(h).twin).turns = (edge(edge(h).twin).turns + turns) & 3;
  }
}

// Writes half-edges that had one number to another; neighbours are told, also where they are among them.
void IntrinsicTriangulation::relocate(const std::vector<std::pair<int, int>>& moved,
                                      const std::vector<IntrinsicEdge>& data) {
  for (size_t i = 0; i < moved.size(); ++i) {
    IntrinsicEdge& written = edge(moved[i].second);
    written = data[i];
    for (const auto& [old_number, new_number] : moved) {
      if (data[i].twin == old_number) written.twin = new_number;
    }
    outgoing_[static_cast<size_t>(written.from)] = moved[i].second;
  }
  for (const auto& entry : moved) {
    const int twin = edge(entry.second).twin;
    if (twin >= 0) edge(twin).twin = entry.second;
  }
}

void IntrinsicTriangulation::flip(int h) {
  const int o = edge(h).twin;
  turn_chart(o / 3, -edge(h).turns);
  const int base = 3 * (h / 3);
  const int other = 3 * (o / 3);
  const std::vector<std::pair<int, int>> moved{
      {next(o), base}, {previous(h), base + 2}, {next(h), other}, {previous(o), other + 2}};
  std::vector<IntrinsicEdge> data;
  for (const auto& entry : moved) data.push_back(edge(entry.first));
  // from the apex on the right to the one on the left, and back
  IntrinsicEdge diagonal = chained(data[1], data[0]);
  for (Vector2<Fixed>& x : diagonal.along) x = minus(x);
  for (IntegerCombination& x : diagonal.symbolic) x = scaled(x, -1);
  diagonal.turns = 0;
  diagonal.feature = false;
  diagonal.from = data[3].from;
  diagonal.twin = other + 1;
  IntrinsicEdge back = diagonal;
  turn(back, 2);
  back.from = data[1].from;
  back.twin = base + 1;
  relocate(moved, data);
  edge(base + 1) = std::move(diagonal);
  edge(other + 1) = std::move(back);
  outgoing_[static_cast<size_t>(edge(base + 1).from)] = base + 1;
  outgoing_[static_cast<size_t>(edge(other + 1).from)] = other + 1;
}

// outgoing half-edges counter-clockwise, from the most clockwise one at the boundary
std::vector<int> IntrinsicTriangulation::star(int v) const {
  const int start = outgoing_[static_cast<size_t>(v)];
  int h = start;
  while (edge(h).twin >= 0) {
    h = next(edge(h).twin);
    if (h == start) break;
  }
  std::vector<int> spokes;
  const int first = h;
  do {
    spokes.push_back(h);
    h = edge(previous(h)).twin;
  } while (h >= 0 && h != first);
  return spokes;
}

// True if both triangles after the flip of spoke h have an area, the one that keeps its vertex perhaps none.
bool IntrinsicTriangulation::may_flip_away(int h) const {
  const int o = edge(h).twin;
  if (edge(h).feature || o < 0 || o / 3 == h / 3) return false;
  const QuarterTurn back(-edge(h).turns);
  const Vector2<Fixed> to_right = back(edge(next(o)).along[0]);
  const Vector2<Fixed> head_to_right = minus(back(edge(previous(o)).along[0]));
  const Vector2<Fixed> to_left = minus(edge(previous(h)).along[0]);
  return sign_of(determinant(edge(next(h)).along[0], head_to_right)) > 0 &&
         sign_of(determinant(to_right, to_left)) >= 0;
}

bool IntrinsicTriangulation::remove_interior(const std::vector<int>& spokes) {
  const int a = spokes[0];
  const int b = spokes[1];
  const int c = spokes[2];
  const int v = edge(a).from;
  if (a / 3 == b / 3 || b / 3 == c / 3 || c / 3 == a / 3) return false;
  if (to(a) == v || to(b) == v || to(c) == v) return false;
  turn_chart(b / 3, -edge(previous(a)).turns);
  turn_chart(c / 3, -edge(previous(b)).turns);
  if (sign_of(determinant(edge(next(a)).along[0], edge(next(b)).along[0])) <= 0) return false;
  const int base = 3 * (a / 3);
  const std::vector<std::pair<int, int>> moved{{next(a), base}, {next(b), base + 1}, {next(c), base + 2}};
  const std::vector<IntrinsicEdge> data{edge(next(a)), edge(next(b)), edge(next(c))};
  for (int i = 0; i < 3; ++i) edge(3 * (b / 3) + i).from = edge(3 * (c / 3) + i).from = -1;
  relocate(moved, data);
  outgoing_[static_cast<size_t>(v)] = -1;
  return true;
}

// The feature line runs in along the last half-edge of the fan of `out` and on along `out`: its two triangles
// become one, on the other side as well (`back` = -1 on the boundary).
bool IntrinsicTriangulation::remove_straight(int out, int back) {
  const int v = edge(out).from;
  std::vector<std::pair<int, int>> moved;
  std::vector<IntrinsicEdge> data, lines;
  std::vector<int> slots, dead;
  for (const int spoke : {out, back}) {
    if (spoke < 0) continue;
    const int inner = edge(previous(spoke)).twin;
    if (inner < 0 || to(inner) == v || to(spoke) == v) return false;
    slots.insert(slots.end(), {spoke / 3, inner / 3});
  }
  std::sort(slots.begin(), slots.end());
  if (std::adjacent_find(slots.begin(), slots.end()) != slots.end()) return false;
  for (const int spoke : {out, back}) {
    if (spoke < 0) continue;
    const int inner = edge(previous(spoke)).twin;
    turn_chart(inner / 3, -edge(previous(spoke)).turns);
    const IntrinsicEdge line = chained(edge(previous(inner)), edge(spoke));
    if (sign_of(determinant(line.along[0], edge(next(spoke)).along[0])) <= 0) return false;
  }
  // copied only now: turning the charts of one side may have changed the other
  for (const int spoke : {out, back}) {
    if (spoke < 0) continue;
    const int inner = edge(previous(spoke)).twin;
    lines.push_back(chained(edge(previous(inner)), edge(spoke)));
    const int base = 3 * (spoke / 3);
    for (const auto& entry : {std::pair{next(spoke), base + 1}, std::pair{next(inner), base + 2}}) {
      moved.push_back(entry);
      data.push_back(edge(entry.first));
    }
    dead.push_back(inner / 3);
  }
  const int turns = edge(out).turns;
  for (const int f : dead) {
    for (int i = 0; i < 3; ++i) edge(3 * f + i).from = -1;
  }
  relocate(moved, data);
  const int base = 3 * (out / 3);
  const int behind = back < 0 ? -1 : 3 * (back / 3);
  lines[0].twin = behind;
  lines[0].turns = turns;
  edge(base) = lines[0];
  outgoing_[static_cast<size_t>(lines[0].from)] = base;
  if (behind >= 0) {
    lines[1].twin = base;
    lines[1].turns = -turns & 3;
    edge(behind) = lines[1];
    outgoing_[static_cast<size_t>(lines[1].from)] = behind;
  }
  outgoing_[static_cast<size_t>(v)] = -1;
  return true;
}

IntrinsicTriangulation IntrinsicTriangulation::compacted() const {
  std::vector<int> number(edges_.size(), -1);
  std::vector<IntrinsicEdge> kept;
  for (int h = 0; h < half_edge_count(); ++h) {
    if (!alive(h / 3)) continue;
    number[static_cast<size_t>(h)] = static_cast<int>(kept.size());
    kept.push_back(edge(h));
  }
  for (IntrinsicEdge& edge : kept) {
    if (edge.twin >= 0) edge.twin = number[static_cast<size_t>(edge.twin)];
  }
  return {std::move(kept), static_cast<int>(outgoing_.size())};
}

bool IntrinsicTriangulation::remove_vertex(int v) {
  constexpr int kMostFlips = 1000;
  for (int flips = 0; flips < kMostFlips; ++flips) {
    std::vector<int> spokes = star(v);
    const auto is_line = [&](int h) { return edge(h).feature; };
    const auto lines = std::count_if(spokes.begin(), spokes.end(), is_line);
    const bool boundary = edge(previous(spokes.back())).twin < 0;
    if (lines == 0 && spokes.size() == 3) return remove_interior(spokes);
    if (lines != 0 && lines != (boundary ? 1 : 2)) return false;
    if (lines != 0) {
      std::rotate(spokes.begin(), std::find_if(spokes.begin(), spokes.end(), is_line), spokes.end());
      const auto second = std::find_if(spokes.begin() + 1, spokes.end(), is_line);
      const auto left = second - spokes.begin();
      const auto right = spokes.end() - second;
      if (left == 2 && (boundary || right == 2)) {
        return remove_straight(spokes[0], boundary ? -1 : *second);
      }
      // a side of two triangles keeps its inner edge
      if (left == 2)
        spokes.erase(spokes.begin(), second);
      else if (right == 2)
        spokes.erase(second, spokes.end());
    }
    const auto away = std::find_if(spokes.begin(), spokes.end(), [&](int h) { return may_flip_away(h); });
    if (away == spokes.end()) return false;
    flip(*away);
  }
  return false;
}

}  // namespace neurframe
