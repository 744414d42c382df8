#include "miq/reduced_variables.hpp"

#include <array>
#include <cmath>
#include <map>

#include "core/errors.hpp"
#include "miq/signed_relations.hpp"

namespace neurframe {
namespace {

class Reduction {
 public:
  Reduction(const CrossSurface& surface, const CutGraph& graph)
      : surface_(surface),
        sector_(corner_sectors(surface, graph.seam, sector_count_)),
        relations_(2 * sector_count_, integers_) {}

  void impose_seams(const CutGraph& graph);
  void impose_features();
  void impose_singular(const std::vector<char>& singular);
  void fix_translations();
  ReducedVariables result(const CutGraph& graph);

 private:
  int variable(int corner, int parameter) const {
    return 2 * sector_[static_cast<size_t>(corner)] + parameter;
  }
  void glue(int left_corner, int right_corner, int turns, const std::array<int, 2>& translation);
  std::vector<std::pair<int, int>> integer_terms(const IntegerCombination& combination);
  static void require(bool possible) {
    if (!possible) {
      throw StageError("no integers satisfy the seam, feature and singularity conditions together");
    }
  }

  const CrossSurface& surface_;
  int sector_count_ = 0;
  std::vector<int> sector_;
  IntegerEquations integers_;
  SignedRelations relations_;
  std::vector<std::array<int, 2>> translation_;  // per branch: the symbols
  std::map<int, int> integer_index_;             // free symbol -> integer variable
};

void Reduction::glue(int left_corner, int right_corner, int turns, const std::array<int, 2>& translation) {
  // rotation by quarter turns: (u,v) -> (u,v), (-v,u), (-u,-v), (v,-u)
  constexpr std::array<int, 4> kSignU{1, -1, -1, 1};
  constexpr std::array<int, 4> kSignV{1, 1, -1, -1};
  const auto t = static_cast<size_t>(turns);
  const int swap = turns & 1;
  require(relations_.relate(variable(right_corner, 0), variable(left_corner, swap), kSignU[t],
                            symbol(translation[0])));
  require(relations_.relate(variable(right_corner, 1), variable(left_corner, 1 - swap), kSignV[t],
                            symbol(translation[1])));
}

void Reduction::impose_seams(const CutGraph& graph) {
  for (const SeamBranch& branch : graph.branches) {
    const std::array<int, 2> translation{integers_.add_symbol(), integers_.add_symbol()};
    translation_.push_back(translation);
    for (const int h : branch.half_edges) {
      const int o = surface_.twin(h);
      const int turns = surface_.matching[static_cast<size_t>(h)];
      glue(h, CrossSurface::next(o), turns, translation);
      glue(CrossSurface::next(h), o, turns, translation);
    }
  }
}

void Reduction::impose_features() {
  for (int h = 0; h < surface_.half_edge_count(); ++h) {
    if (!surface_.is_feature(h)) continue;
    const int parameter = constant_parameter(surface_, h);
    const int start = variable(h, parameter);
    require(relations_.relate(start, variable(CrossSurface::next(h), parameter), 1, IntegerCombination{}));
    require(relations_.make_integer(start));
  }
}

void Reduction::impose_singular(const std::vector<char>& singular) {
  for (int h = 0; h < surface_.half_edge_count(); ++h) {
    if (!singular[static_cast<size_t>(surface_.from(h))]) continue;
    require(relations_.make_integer(variable(h, 0)));
    require(relations_.make_integer(variable(h, 1)));
  }
}

// A chart may move by integers without any change of the map: the first integer u and the first integer v of
// each component are set to zero, or the first real one where nothing is integer.
void Reduction::fix_translations() {
  std::vector<char> reached(surface_.triangles.size(), 0);
  for (int root = 0; root < surface_.triangle_count(); ++root) {
    if (reached[static_cast<size_t>(root)]) continue;
    reached[static_cast<size_t>(root)] = 1;
    std::vector<int> component{root};
    for (size_t i = 0; i < component.size(); ++i) {
      for (int h = 3 * component[i]; h < 3 * component[i] + 3; ++h) {
        const int o = surface_.twin(h);
        if (o < 0 || reached[static_cast<size_t>(o / 3)]) continue;
        reached[static_cast<size_t>(o / 3)] = 1;
        component.push_back(o / 3);
      }
    }
    for (int parameter = 0; parameter < 2; ++parameter) {
      int chosen = variable(3 * root, parameter);
      for (size_t i = 0; i < 3 * component.size(); ++i) {
        const int candidate = variable(3 * component[i / 3] + static_cast<int>(i % 3), parameter);
        if (relations_.find(candidate).sign != 0) continue;
        chosen = candidate;
        break;
      }
      require(relations_.fix(chosen, IntegerCombination{}));
    }
  }
}

std::vector<std::pair<int, int>> Reduction::integer_terms(const IntegerCombination& combination) {
  std::vector<std::pair<int, int>> terms;
  for (const auto& [free_symbol, coefficient] : integers_.resolve(combination).terms) {
    const int fresh = static_cast<int>(integer_index_.size());
    terms.emplace_back(integer_index_.emplace(free_symbol, fresh).first->second,
                       static_cast<int>(coefficient));
  }
  return terms;
}

ReducedVariables Reduction::result(const CutGraph& graph) {
  ReducedVariables out;
  std::map<int, int> real_index;
  for (int i = 0; i < 2 * sector_count_; ++i) {
    const SignedAffine x = relations_.find(i);
    ReducedCoordinate coordinate{-1, 1, integer_terms(x.offset)};
    if (x.sign != 0) {
      const int fresh = static_cast<int>(real_index.size());
      coordinate.real = real_index.emplace(x.root, fresh).first->second;
      coordinate.sign = x.sign;
    }
    out.coordinates.push_back(std::move(coordinate));
  }
  out.branch_of.assign(sector_.size(), -1);
  for (size_t b = 0; b < graph.branches.size(); ++b) {
    SeamTransition transition;
    transition.turns = surface_.matching[static_cast<size_t>(graph.branches[b].half_edges.front())];
    for (size_t k = 0; k < 2; ++k) transition.translation[k] = integer_terms(symbol(translation_[b][k]));
    out.transitions.push_back(std::move(transition));
    for (const int h : graph.branches[b].half_edges)
      out.branch_of[static_cast<size_t>(h)] = static_cast<int>(b);
  }
  out.sector = sector_;
  out.real_count = static_cast<int>(real_index.size());
  out.integer_count = static_cast<int>(integer_index_.size());
  return out;
}

}  // namespace

int constant_parameter(const CrossSurface& surface, int h) {
  const Eigen::Vector3d edge = surface.along(h);
  const double first = std::abs(edge.dot(surface.axis[static_cast<size_t>(h / 3)]));
  return first > std::abs(edge.dot(surface.second_axis(h / 3))) ? 1 : 0;
}

ReducedVariables reduce_variables(const CrossSurface& surface, const CutGraph& graph,
                                  const std::vector<char>& singular) {
  Reduction reduction(surface, graph);
  reduction.impose_seams(graph);
  reduction.impose_singular(singular);
  reduction.impose_features();
  reduction.fix_translations();
  return reduction.result(graph);
}

}  // namespace neurframe
