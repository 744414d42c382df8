#include "cubecover/surface_labels.hpp"

#include <algorithm>
#include <limits>
#include <set>

#include "cubecover/label_faults.hpp"

namespace neurframe {

namespace {

constexpr double given_up = 1e4;  // fidelity cost of a label that a patch must not have again
constexpr int most_repairs = 12;
constexpr int most_relabellings = 40;  // of a few faces at a fault
constexpr int most_mends_of_a_strip = 4;
constexpr std::size_t most_faults_to_mend = 20;  // more are no accident of a few faces
constexpr double stretch_cost = 2;               // of a radian at a corner; one face across is about 1
constexpr int relabelling_budget = 1000000;  // boundary faces that may be judged again, all choices together

class Labelling {
 public:
  Labelling(const FieldMesh& mesh, const std::vector<BoundaryEdge>& edges, const LabelCosts& costs)
      : mesh_(mesh),
        edges_(edges),
        energy_(mesh, edges, costs),
        label_(energy_.most_faithful()),
        forced_(label_.size(), 0) {}

  // Repairs may be in vain, or one undo the other: the labels with the fewest faults are kept.
  void solve() {
    std::vector<int> best;
    std::size_t fewest = std::numeric_limits<std::size_t>::max();
    for (int repair = 0; repair <= most_repairs && fewest > 0; ++repair) {
      energy_.lower(label_);
      const LabelFaults faults = find_faults();
      if (faults.count() < fewest) best = label_;
      fewest = std::min(fewest, faults.count());
      give_up(faults.small_patches);
      if (faults.small_patches.empty()) split(faults.borders);
    }
    label_ = best;
    if (fewest > most_faults_to_mend) return;
    for (int i = 0; i < most_relabellings && (mend_corners() || mend_borders()); ++i) {
    }
  }

  std::vector<SignedAxis> axes() const { return axes_of(energy_, label_); }

 private:
  LabelFaults find_faults() const { return find_label_faults(mesh_, edges_, energy_, label_); }

  struct Relabelling {
    std::vector<int> half_faces;
    int label;
  };

  // At an impossible corner the faces of one label may take that of others: two patches of one label that
  // meet in the vertex are then parted by an edge, or are one patch.
  static void add_fans(const LabelCorner& corner, const std::vector<SignedAxis>& labels,
                       std::vector<Relabelling>& found) {
    for (const LabelCorner::Fan& fan : corner.fans) {
      for (const LabelCorner::Fan& other : corner.fans) {
        const SignedAxis label = at(labels, other.half_faces.front());
        if (!(label == at(labels, fan.half_faces.front())))
          found.push_back({fan.half_faces, label_of(label)});
      }
    }
  }

  // Beside either part of a turning border a strip may take the third axis: the faces that touch that part,
  // so that the strip has width everywhere.
  void add_strips(const TurningBorder& border, const std::vector<SignedAxis>& labels,
                  const std::vector<std::vector<int>>& faces_of_vertex,
                  std::vector<Relabelling>& found) const {
    const int third = 3 - border.axes[0] - border.axes[1];
    for (std::size_t part = 0; part < 4; ++part) {
      std::set<int> strip(border.parts[part].begin(), border.parts[part].end());
      for (std::size_t i = 0; i < border.parts[part].size(); ++i) {
        for (const int v : half_face_vertices(mesh_.tets, border.parts[part][i])) {
          const std::vector<int>& around = at(faces_of_vertex, v);
          const auto is_beside = [&](int h) {
            return at(labels, h) == at(labels, border.parts[part][i]) ||
                   at(labels, h) == at(labels, border.parts[part ^ 1][i]);
          };
          const bool on_border = std::any_of(around.begin(), around.end(), [&](int h) {
            return at(labels, h) == at(labels, border.parts[part ^ 1][i]);
          });
          if (!on_border || !std::all_of(around.begin(), around.end(), is_beside)) continue;
          for (const int h : around) {
            if (at(labels, h) == at(labels, border.parts[part][i])) strip.insert(h);
          }
        }
      }
      for (const int label : {2 * third, 2 * third + 1})
        found.push_back({{strip.begin(), strip.end()}, label});
    }
  }

  std::vector<Relabelling> relabelled_fans(const LabelFaults& faults) const {
    std::vector<Relabelling> found;
    const std::vector<SignedAxis> labels = axes();
    for (const LabelCorner& corner : faults.corners) add_fans(corner, labels, found);
    return found;
  }

  std::vector<Relabelling> relabelled_strips(const LabelFaults& faults) const {
    const std::vector<SignedAxis> labels = axes();
    std::vector<std::vector<int>> faces_of_vertex(mesh_.points.size());
    for (const int h : energy_.half_faces) {
      for (const int v : half_face_vertices(mesh_.tets, h)) at(faces_of_vertex, v).push_back(h);
    }
    std::vector<Relabelling> found;
    for (const TurningBorder& border : faults.borders) add_strips(border, labels, faces_of_vertex, found);
    return found;
  }

  void apply(const Relabelling& relabelling) {
    for (const int h : relabelling.half_faces) at(label_, at(energy_.face_of, h)) = relabelling.label;
  }

  // Of what may be labelled anew, each followed by `then`, what leaves the fewest faults, and of those the
  // lowest energy, stretched corners included.  Returns whether there are fewer.
  template <class Then>
  bool relabel(std::size_t fault_count, const std::vector<Relabelling>& choices, const Then& then) {
    std::pair<std::size_t, double> least(fault_count, -std::numeric_limits<double>::infinity());
    std::vector<int> best;
    for (const Relabelling& choice : choices) {
      if (faces_left_ < 0) break;
      faces_left_ -= energy_.face_count();
      const std::vector<int> before = label_;
      apply(choice);
      then();
      const LabelFaults left = find_faults();
      const std::pair<std::size_t, double> found(left.count(),
                                                 energy_.of(label_) + stretch_cost * left.stretch);
      if (found < least) least = found, best = label_;
      label_ = before;
    }
    if (best.empty()) return false;
    label_ = std::move(best);
    return true;
  }

  bool mend_corners() {
    const LabelFaults faults = find_faults();
    return relabel(faults.count(), relabelled_fans(faults), [] {});
  }

  // The end of a strip may be an impossible corner itself.
  bool mend_borders() {
    const LabelFaults faults = find_faults();
    return relabel(faults.count(), relabelled_strips(faults), [&] {
      for (int i = 0; i < most_mends_of_a_strip && mend_corners(); ++i) {
      }
    });
  }

  void give_up(const std::set<int>& bad) {
    const std::vector<int> patch = patches_of(energy_, label_);
    for (int f = 0; f < energy_.face_count(); ++f) {
      if (bad.contains(at(patch, f))) energy_.fidelity(f, at(label_, f)) += given_up;
    }
  }

  // Where a border turns from convex to concave, a part of one patch beside it takes the third axis, so that
  // three patches meet at the turn.
  void split(const std::vector<TurningBorder>& borders) {
    for (const TurningBorder& border : borders) {
      const int third = 3 - border.axes[0] - border.axes[1];
      const std::vector<int>* cheapest = nullptr;
      double least = given_up;
      for (const std::vector<int>& part : border.parts) {
        const double cost = cost_of_axis(part, third);
        if (!was_forced(part) && cost < least) cheapest = &part, least = cost;
      }
      if (cheapest == nullptr) continue;
      for (const int h : *cheapest) force_axis(at(energy_.face_of, h), third);
    }
  }

  double cost_of_axis(const std::vector<int>& half_faces, int axis) {
    double cost = 0;
    for (const int h : half_faces) {
      const int f = at(energy_.face_of, h);
      cost += std::min(energy_.fidelity(f, 2 * axis), energy_.fidelity(f, 2 * axis + 1)) -
              energy_.fidelity(f, at(label_, f));
    }
    return cost;
  }

  // A part that was moved before and came back did so because its new patch had too few corners.
  bool was_forced(const std::vector<int>& half_faces) const {
    return std::any_of(half_faces.begin(), half_faces.end(),
                       [&](int h) { return at(forced_, at(energy_.face_of, h)) != 0; });
  }

  void force_axis(int face, int axis) {
    at(forced_, face) = 1;
    const int taken =
        energy_.fidelity(face, 2 * axis) <= energy_.fidelity(face, 2 * axis + 1) ? 2 * axis : 2 * axis + 1;
    for (int l = 0; l < label_count; ++l) {
      if (l != taken) energy_.fidelity(face, l) += given_up;
    }
  }

  const FieldMesh& mesh_;
  const std::vector<BoundaryEdge>& edges_;
  LabelEnergy energy_;
  std::vector<int> label_;
  int faces_left_ = relabelling_budget;
  std::vector<char> forced_;  // per face: its axis was chosen to end a turning border
};

}  // namespace

std::vector<SignedAxis> surface_labels(const FieldMesh& mesh, const std::vector<BoundaryEdge>& edges,
                                       const LabelCosts& costs) {
  Labelling labelling(mesh, edges, costs);
  labelling.solve();
  return labelling.axes();
}

}  // namespace neurframe
