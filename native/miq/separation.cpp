#include "miq/separation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

namespace neurframe {
namespace {

using Vector2d = Eigen::Vector2d;

double cross(const Vector2d& a, const Vector2d& b) {
  return a[0] * b[1] - a[1] * b[0];
}

Vector2d turned(const Vector2d& x, int turns) {
  switch (turns & 3) {
    case 0:
      return x;
    case 1:
      return {-x[1], x[0]};
    case 2:
      return -x;
    default:
      return {x[1], -x[0]};
  }
}

using SymbolicPoint = std::array<IntegerCombination, 2>;

SymbolicPoint turned(const SymbolicPoint& x, int turns) {
  switch (turns & 3) {
    case 0:
      return x;
    case 1:
      return {scaled(x[1], -1), x[0]};
    case 2:
      return {scaled(x[0], -1), scaled(x[1], -1)};
    default:
      return {x[1], scaled(x[0], -1)};
  }
}

// from the chart of a triangle into the chart of the source: x -> turns(x) + offset
struct Chart {
  int turns = 0;
  SymbolicPoint offset;
  Vector2d value{0, 0};  // of offset
};

// the part of half-edge `edge` (to be crossed out of its triangle) that the source sees, by its two rays
struct Window {
  int edge;
  int chart;
  Vector2d right, left;
};

class Sight {
 public:
  Sight(const CrossSurface& surface, const ReducedVariables& variables, const std::vector<char>& singular,
        const MapSystem& system, const Eigen::VectorXd& real, const Eigen::VectorXd& integer, double reach)
      : surface_(surface), variables_(variables), singular_(singular), integer_(integer), reach_(reach) {
    for (int f = 0; f < surface.triangle_count(); ++f) {
      const Vector6 uv = system.corner_parameters(f, real, integer);
      for (int i = 0; i < 3; ++i) parameters_.emplace_back(uv[2 * i], uv[2 * i + 1]);
    }
  }

  void look_from(int corner);
  void follow_feature(int h);
  std::vector<SeparationRow> rows() const {
    std::vector<SeparationRow> out;
    for (const auto& terms : rows_) out.push_back({terms, 0});
    return out;
  }

 private:
  const ReducedCoordinate& coordinate(int corner, int parameter) const {
    const int sector = variables_.sector[static_cast<size_t>(corner)];
    return variables_.coordinates[static_cast<size_t>(2 * sector + parameter)];
  }
  bool is_integer(int corner, int parameter) const { return coordinate(corner, parameter).real < 0; }
  static IntegerCombination combination(const std::vector<std::pair<int, int>>& terms);
  SymbolicPoint symbolic(int corner) const {
    return {combination(coordinate(corner, 0).integers), combination(coordinate(corner, 1).integers)};
  }
  double value(const IntegerCombination& x) const {
    double sum = 0;
    for (const auto& [index, factor] : x.terms) sum += static_cast<double>(factor) * integer_[index];
    return sum;
  }
  Vector2d place(int corner, const Chart& chart) const {
    return turned(parameters_[static_cast<size_t>(corner)], chart.turns) + chart.value - source_place_;
  }
  int cross_edge(int h, int chart);
  void see_vertex(int corner, const Chart& chart);
  void see_feature(const Window& window);
  void add_row(int corner, const Chart& chart, int parameter, double distance);
  void advance(const Window& window);

  const CrossSurface& surface_;
  const ReducedVariables& variables_;
  const std::vector<char>& singular_;
  const Eigen::VectorXd& integer_;
  const double reach_;
  std::vector<Vector2d> parameters_;  // per corner
  std::set<std::vector<std::pair<int, int64_t>>> rows_;
  int source_ = 0;
  Vector2d source_place_{0, 0};
  SymbolicPoint source_symbolic_;
  std::vector<Chart> charts_;
  std::vector<Window> stack_;
};

IntegerCombination Sight::combination(const std::vector<std::pair<int, int>>& terms) {
  IntegerCombination out;
  for (const auto& [index, factor] : terms) out = sum(out, symbol(index), factor);
  return out;
}

// the chart of the triangle on the other side of h
int Sight::cross_edge(int h, int chart_id) {
  const int left_branch = variables_.branch_of[static_cast<size_t>(h)];
  const int right_branch = variables_.branch_of[static_cast<size_t>(surface_.twin(h))];
  if (left_branch < 0 && right_branch < 0) return chart_id;
  const Chart chart = charts_[static_cast<size_t>(chart_id)];
  const SeamTransition& seam =
      variables_.transitions[static_cast<size_t>(std::max(left_branch, right_branch))];
  const SymbolicPoint translation{combination(seam.translation[0]), combination(seam.translation[1])};
  Chart next;
  // right = R left + t.  Going left to right we need left in terms of right: R^-1 (right - t).
  const int turns = left_branch >= 0 ? chart.turns - seam.turns : chart.turns + seam.turns;
  next.turns = turns & 3;
  const SymbolicPoint shift = turned(translation, left_branch >= 0 ? next.turns : chart.turns);
  const int64_t sign = left_branch >= 0 ? -1 : 1;
  for (size_t k = 0; k < 2; ++k) {
    next.offset[k] = sum(chart.offset[k], shift[k], sign);
    next.value[static_cast<Eigen::Index>(k)] = value(next.offset[k]);
  }
  charts_.push_back(std::move(next));
  return static_cast<int>(charts_.size()) - 1;
}

void Sight::add_row(int corner, const Chart& chart, int parameter, double distance) {
  const auto k = static_cast<size_t>(parameter);
  const SymbolicPoint there = turned(symbolic(corner), chart.turns);
  IntegerCombination row = sum(sum(there[k], chart.offset[k]), source_symbolic_[k], -1);
  if (distance < 0) row = scaled(row, -1);
  if (!row.terms.empty()) rows_.insert(row.terms);
}

void Sight::see_vertex(int corner, const Chart& chart) {
  if (!singular_[static_cast<size_t>(surface_.from(corner))]) return;
  const Vector2d at = place(corner, chart);
  const int larger = std::abs(at[0]) >= std::abs(at[1]) ? 0 : 1;
  if (std::abs(at[larger]) > reach_ || !is_integer(source_, larger)) return;
  add_row(corner, chart, larger, at[larger]);
}

void Sight::see_feature(const Window& window) {
  const Chart& chart = charts_[static_cast<size_t>(window.chart)];
  const int own = constant_parameter(surface_, window.edge);
  const int k = (own + chart.turns) & 1;
  const Vector2d at = place(window.edge, chart);
  const double distance = at[k];
  if (std::abs(distance) > reach_ || !is_integer(source_, k)) return;
  // along the line, the visible part runs from one ray to the other
  const auto along = [&](const Vector2d& ray) {
    return ray[k] == 0 ? INFINITY : ray[1 - k] / ray[k] * distance;
  };
  const double low = std::min(along(window.right), along(window.left));
  const double high = std::max(along(window.right), along(window.left));
  if (low > std::abs(distance) || high < -std::abs(distance)) return;
  add_row(window.edge, chart, k, distance);
}

void Sight::advance(const Window& window) {
  const int o = surface_.twin(window.edge);
  if (o < 0 || surface_.is_feature(window.edge)) return see_feature(window);
  const int chart_id = cross_edge(window.edge, window.chart);
  const Chart chart = charts_[static_cast<size_t>(chart_id)];
  const int apex = CrossSurface::previous(o);
  // o runs from the left end of the window's edge to its right end
  const Vector2d right = place(CrossSurface::next(o), chart);
  const Vector2d left = place(o, chart);
  const Vector2d top = place(apex, chart);
  if (cross(left - top, right - top) <= 0) return;
  if (cross(window.right, top) >= 0 && cross(top, window.left) >= 0) see_vertex(apex, chart);
  const auto push = [&](int edge, const Vector2d& low, const Vector2d& high, const Vector2d& a,
                        const Vector2d& b) {
    if (cross(low, high) <= 0) return;
    if (std::min(a.cwiseAbs().maxCoeff(), b.cwiseAbs().maxCoeff()) > 4 * reach_) return;
    stack_.push_back({edge, chart_id, low, high});
  };
  push(CrossSurface::next(o), window.right, cross(top, window.left) > 0 ? top : window.left, right, top);
  push(apex, cross(window.right, top) > 0 ? top : window.right, window.left, top, left);
}

void Sight::look_from(int corner) {
  constexpr int kMostSteps = 20000;
  source_ = corner;
  source_place_ = parameters_[static_cast<size_t>(corner)];
  source_symbolic_ = symbolic(corner);
  charts_.assign(1, Chart{});
  const int edge = CrossSurface::next(corner);
  const int last = CrossSurface::previous(corner);
  const Chart start{};
  const Vector2d right = place(edge, start);
  const Vector2d left = place(last, start);
  if (cross(right, left) <= 0) return;
  see_vertex(edge, start);
  see_vertex(last, start);
  stack_.assign(1, Window{edge, 0, right, left});
  for (int step = 0; !stack_.empty() && step < kMostSteps; ++step) {
    const Window window = stack_.back();
    stack_.pop_back();
    advance(window);
  }
}

// Along the feature from the singular vertex at its start to the next singular vertex.
void Sight::follow_feature(int h) {
  source_ = h;
  source_place_ = parameters_[static_cast<size_t>(h)];
  source_symbolic_ = symbolic(h);
  charts_.assign(1, Chart{});
  int chart = 0;
  const int parameter = 1 - constant_parameter(surface_, h);
  for (int step = 0; step < surface_.half_edge_count(); ++step) {
    const int head = CrossSurface::next(h);
    if (singular_[static_cast<size_t>(surface_.from(head))]) {
      const Chart end = charts_[static_cast<size_t>(chart)];
      return add_row(head, end, parameter, place(head, end)[parameter]);
    }
    int k = head;
    while (!surface_.is_feature(k)) {
      chart = cross_edge(k, chart);
      k = CrossSurface::next(surface_.twin(k));
    }
    h = k;
    // back at a feature line's loose end
    if (surface_.from(h) == surface_.to(source_) && surface_.to(h) == surface_.from(source_)) return;
  }
}

}  // namespace

std::vector<SeparationRow> separation_rows(const CrossSurface& surface, const ReducedVariables& variables,
                                           const std::vector<char>& singular, const MapSystem& system,
                                           const Eigen::VectorXd& real, const Eigen::VectorXd& integer,
                                           double reach) {
  Sight sight(surface, variables, singular, system, real, integer, reach);
  std::vector<char> source(singular);
  for (int h = 0; h < surface.half_edge_count(); ++h) {
    if (surface.is_feature(h))
      source[static_cast<size_t>(surface.from(h))] = source[static_cast<size_t>(surface.to(h))] = 1;
  }
  for (int h = 0; h < surface.half_edge_count(); ++h) {
    const auto v = static_cast<size_t>(surface.from(h));
    if (source[v]) sight.look_from(h);
    if (singular[v] && surface.is_feature(h)) sight.follow_feature(h);
  }
  return sight.rows();
}

}  // namespace neurframe
