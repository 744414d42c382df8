#include "miq/critical_triangulation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "miq/fixed_point_map.hpp"

namespace neurframe {
namespace {

using Plane = Vector2<double>;

double cross(const Plane& a, const Plane& b) {
  return a[0] * b[1] - a[1] * b[0];
}
double dot(const Plane& a, const Plane& b) {
  return a[0] * b[0] + a[1] * b[1];
}
double length(const Plane& a) {
  return std::hypot(a[0], a[1]);
}

// one vertex more of every connected part of the graph of these edges that has no critical vertex yet
template <class Wanted>
void anchor_parts(const CrossSurface& surface, const Wanted& wanted, std::vector<char>& critical) {
  std::vector<std::vector<int>> neighbours(surface.positions.size());
  for (int h = 0; h < surface.half_edge_count(); ++h) {
    if (!wanted(h)) continue;
    neighbours[static_cast<size_t>(surface.from(h))].push_back(surface.to(h));
    neighbours[static_cast<size_t>(surface.to(h))].push_back(surface.from(h));
  }
  std::vector<char> reached(surface.positions.size(), 0);
  for (size_t seed = 0; seed < neighbours.size(); ++seed) {
    if (reached[seed] || neighbours[seed].empty()) continue;
    reached[seed] = 1;
    std::vector<int> part{static_cast<int>(seed)};
    bool anchored = false;
    for (size_t i = 0; i < part.size(); ++i) {
      anchored = anchored || critical[static_cast<size_t>(part[i])];
      for (const int v : neighbours[static_cast<size_t>(part[i])]) {
        if (reached[static_cast<size_t>(v)]) continue;
        reached[static_cast<size_t>(v)] = 1;
        part.push_back(v);
      }
    }
    if (!anchored) critical[seed] = 1;
  }
}

std::vector<char> critical_vertices(const MapProblem& problem) {
  const CrossSurface& surface = problem.surface;
  std::vector<char> critical = problem.singular;
  std::vector<int> lines(surface.positions.size(), 0);
  for (int h = 0; h < surface.half_edge_count(); ++h) {
    if (!surface.is_feature(h)) continue;
    ++lines[static_cast<size_t>(surface.from(h))];
    if (surface.twin(h) < 0) ++lines[static_cast<size_t>(surface.to(h))];
  }
  for (size_t v = 0; v < lines.size(); ++v) critical[v] |= lines[v] != 0 && lines[v] != 2;
  anchor_parts(surface, [&](int h) { return surface.is_feature(h); }, critical);
  anchor_parts(surface, [](int) { return true; }, critical);
  return critical;
}

// In the unknowns: integer variable i is symbol i, real variable r is symbol integer_count + r.
IntegerCombination symbolic(const ReducedCoordinate& x, int integer_count) {
  IntegerCombination out;
  for (const auto& [index, factor] : x.integers) out = sum(out, symbol(index), factor);
  return x.real < 0 ? out : sum(out, symbol(integer_count + x.real), x.sign);
}

IntrinsicTriangulation whole_map(const MapProblem& problem, const FixedPointMap& map) {
  const CrossSurface& surface = problem.surface;
  const ReducedVariables& variables = problem.variables;
  std::vector<IntrinsicEdge> edges;
  for (int h = 0; h < surface.half_edge_count(); ++h) {
    IntrinsicEdge edge;
    edge.from = surface.from(h);
    edge.twin = surface.twin(h);
    edge.turns = edge.twin < 0 ? 0 : surface.matching[static_cast<size_t>(h)];
    edge.feature = surface.is_feature(h);
    const int n = CrossSurface::next(h);
    edge.along[0] = difference(map.corners[static_cast<size_t>(n)], map.corners[static_cast<size_t>(h)]);
    for (size_t k = 0; k < 2; ++k) {
      const auto at = [&](int corner) {
        const auto sector = static_cast<size_t>(variables.sector[static_cast<size_t>(corner)]);
        return symbolic(variables.coordinates[2 * sector + k], variables.integer_count);
      };
      edge.symbolic[k] = sum(at(n), at(h), -1);
    }
    edges.push_back(std::move(edge));
  }
  return {std::move(edges), surface.vertex_count()};
}

bool has_area(const IntrinsicTriangulation& mesh, int f, double t) {
  return mesh.alive(f) && cross(mesh.along_at(3 * f, t), mesh.along_at(3 * f + 1, t)) > 0;
}

double cotangent_opposite(const IntrinsicTriangulation& mesh, int h, double t) {
  const Plane a = mesh.along_at(IntrinsicTriangulation::next(h), t);
  const Plane b = mesh.along_at(IntrinsicTriangulation::previous(h), t);
  return -dot(a, b) / cross(a, b);
}

// Flips until no edge but features violates the Delaunay condition at time t; returns the number of flips.
int make_delaunay(IntrinsicTriangulation& mesh, double t) {
  const int most_flips = 20 * mesh.half_edge_count();
  int flips = 0;
  for (bool changed = true; changed && flips < most_flips;) {
    changed = false;
    for (int h = 0; h < mesh.half_edge_count(); ++h) {
      const IntrinsicEdge& edge = mesh.edge(h);
      if (!mesh.alive(h / 3) || edge.feature || edge.twin < h || edge.twin / 3 == h / 3) continue;
      if (!has_area(mesh, h / 3, t) || !has_area(mesh, edge.twin / 3, t)) continue;
      if (cotangent_opposite(mesh, h, t) + cotangent_opposite(mesh, edge.twin, t) > -1e-9) continue;
      mesh.flip(h);
      ++flips;
      changed = true;
    }
  }
  return flips;
}

// The first time after `now` when the triangle has no area, 1 at the latest if it has none at the end,
// infinity if that does not happen.
double collapse_time(const IntrinsicTriangulation& mesh, int f, double now) {
  const auto area = [&](double t) { return cross(mesh.along_at(3 * f, t), mesh.along_at(3 * f + 1, t)); };
  const double last = mesh.area_sign(f, 1) <= 0 ? 1 : std::numeric_limits<double>::infinity();
  // the quadratic through three values
  const double c = area(0);
  const double middle = area(0.5);
  const double end = area(1);
  const double a = 2 * (end - 2 * middle + c);
  const double b = end - c - a;
  const double root2 = b * b - 4 * a * c;
  if (root2 < 0) return last;
  const double q = -(b + std::copysign(std::sqrt(root2), b)) / 2;
  double first = last;
  for (const double t : {q / a, c / q}) {
    if (t > now && t < first && t <= 1) first = t;
  }
  return first;
}

int longest_edge(const IntrinsicTriangulation& mesh, int f, double t) {
  int longest = 3 * f;
  for (int h = 3 * f; h < 3 * f + 3; ++h) {
    if (length(mesh.along_at(h, t)) > length(mesh.along_at(longest, t))) longest = h;
  }
  return longest;
}

}  // namespace

CriticalTriangulation::CriticalTriangulation(const MapProblem& problem, const Eigen::VectorXd& real,
                                             const Eigen::VectorXd& integer)
    : mesh_({}, 0), integer_count_(problem.variables.integer_count) {
  const FixedPointMap map = fixed_point_map(problem.variables, real, integer);
  fraction_bits_ = map.fraction_bits;
  IntrinsicTriangulation whole = whole_map(problem, map);
  const std::vector<char> critical = critical_vertices(problem);
  std::vector<int> waiting;
  for (int v = 0; v < problem.surface.vertex_count(); ++v) {
    if (!critical[static_cast<size_t>(v)]) waiting.push_back(v);
  }
  // a vertex that cannot go now may go when its neighbours have gone
  for (size_t before = 0; before != waiting.size();) {
    before = waiting.size();
    std::erase_if(waiting, [&](int v) { return whole.remove_vertex(v); });
  }
  vertices_left_ = static_cast<int>(waiting.size());
  mesh_ = whole.compacted();
  make_delaunay(mesh_, 0);
}

Fixed CriticalTriangulation::value(const IntegerCombination& x, const Eigen::VectorXd& real,
                                   const Eigen::VectorXd& integer) const {
  Fixed total = 0;
  for (const auto& [index, factor] : x.terms) {
    total += factor *
             to_fixed(index < integer_count_ ? integer[index] : real[index - integer_count_], fraction_bits_);
  }
  return total;
}

bool CriticalTriangulation::in_integers(const IntegerCombination& x) const {
  return !x.terms.empty() && x.terms.back().first < integer_count_;
}

// The ends of half-edge h keep the direction in which they see each other at time t.
void CriticalTriangulation::keep_apart(const IntrinsicTriangulation& mesh, int h, double t,
                                       SeparationRows& rows) const {
  // a smaller part of the difference may have either sign in the end
  constexpr double kLeastPart = 0.3;
  const Plane d = mesh.along_at(h, t);
  const auto& symbolic = mesh.edge(h).symbolic;
  SeparationRow row;
  for (size_t k = 0; k < 2; ++k) {
    if (std::abs(d[k]) < kLeastPart * std::abs(d[1 - k])) continue;
    if (!in_integers(symbolic[k])) return;
    row = sum(row, symbolic[k], d[k] > 0 ? 1 : -1);
  }
  if (row.terms.empty()) return;
  // a way from a vertex to itself, around a thin part: less than three cells are no mesh
  if (mesh.edge(h).from == mesh.to(h)) row.constant = -2;
  rows.insert(row);
}

// The vertex opposite to the feature edge stays on its side.
void CriticalTriangulation::keep_from_line(const IntrinsicTriangulation& mesh, int line, double t,
                                           SeparationRows& rows) const {
  const Plane along = mesh.along_at(line, t);
  const size_t across = std::abs(along[0]) > std::abs(along[1]) ? 1 : 0;
  const int h = IntrinsicTriangulation::next(line);
  const IntegerCombination& distance = mesh.edge(h).symbolic[across];
  if (!in_integers(distance)) return;
  rows.insert(scaled(distance, mesh.along_at(h, t)[across] > 0 ? 1 : -1));
}

SeparationRows CriticalTriangulation::near_rows(double reach) const {
  SeparationRows rows;
  const double near = std::ldexp(reach, fraction_bits_);
  for (int h = 0; h < mesh_.half_edge_count(); ++h) {
    if (!has_area(mesh_, h / 3, 0)) continue;
    const Plane along = mesh_.along_at(h, 0);
    const double extent = std::max(std::abs(along[0]), std::abs(along[1]));
    const double enough = mesh_.edge(h).from == mesh_.to(h) ? 2 * near : near;
    if (extent < enough && h > mesh_.edge(h).twin) keep_apart(mesh_, h, 0, rows);
    if (!mesh_.edge(h).feature) continue;
    const Plane side = mesh_.along_at(IntrinsicTriangulation::next(h), 0);
    const double height = cross(along, side) / length(along);
    const double foot = 1 + dot(along, side) / dot(along, along);
    const double slack = height / length(along);
    if (height < near && foot > -slack && foot < 1 + slack) keep_from_line(mesh_, h, 0, rows);
  }
  return rows;
}

// The row that keeps triangle f, about to collapse, from doing so.
void CriticalTriangulation::prevent(const IntrinsicTriangulation& mesh, int f, double t, double collapse,
                                    SeparationRows& rows) const {
  const int longest = longest_edge(mesh, f, t);
  int shortest = 3 * f;
  for (int h = 3 * f; h < 3 * f + 3; ++h) {
    if (length(mesh.along_at(h, collapse)) < length(mesh.along_at(shortest, collapse))) shortest = h;
  }
  const bool collision = length(mesh.along_at(shortest, collapse)) < 1e-3 * length(mesh.along_at(longest, t));
  if (!collision && mesh.edge(longest).feature) return keep_from_line(mesh, longest, t, rows);
  keep_apart(mesh, shortest, 0, rows);
}

SeparationRows CriticalTriangulation::broken_rows(const Eigen::VectorXd& real, const Eigen::VectorXd& integer,
                                                  int& collapsed) const {
  constexpr int kMostSteps = 5000;
  constexpr double kPart = 0.9;  // of the way to the next collapse, then the flips that avoid it
  constexpr double kNow = 1e-6;
  IntrinsicTriangulation mesh = mesh_;
  for (int h = 0; h < mesh.half_edge_count(); ++h) {
    IntrinsicEdge& edge = mesh.edge(h);
    for (size_t k = 0; k < 2; ++k) edge.along[1][k] = value(edge.symbolic[k], real, integer);
  }
  SeparationRows rows;
  collapsed = 0;
  std::vector<char> lost(static_cast<size_t>(mesh.triangle_count()), 0);
  double now = 0;
  for (int step = 0; step < kMostSteps; ++step) {
    int next = -1;
    double collapse = std::numeric_limits<double>::infinity();
    for (int f = 0; f < mesh.triangle_count(); ++f) {
      if (lost[static_cast<size_t>(f)]) continue;
      const double at = has_area(mesh, f, now) ? collapse_time(mesh, f, now) : now;
      if (at >= collapse) continue;
      collapse = at;
      next = f;
    }
    if (next < 0) return rows;
    const double before = now + kPart * (collapse - now);
    const int flips = make_delaunay(mesh, before);
    now = before;
    if (flips > 0 || collapse - now > kNow) continue;
    lost[static_cast<size_t>(next)] = 1;
    ++collapsed;
    prevent(mesh, next, now, collapse, rows);
  }
  ++collapsed;
  return rows;
}

}  // namespace neurframe
