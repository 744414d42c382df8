#include "cubecover/surface_labels.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <set>

#include "cubecover/label_energy.hpp"
#include "cubecover/turning_borders.hpp"

namespace neurframe {

namespace {

constexpr double given_up = 1e4;  // fidelity cost of a label that a patch must not have again
constexpr int most_repairs = 12;
constexpr int fewest_corners = 4;

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
      const std::set<int> bad = bad_patches();
      const std::vector<TurningBorder> turning = find_turning_borders(mesh_, edges_, axes());
      if (bad.size() + turning.size() < fewest) best = label_;
      fewest = std::min(fewest, bad.size() + turning.size());
      give_up(bad);
      if (bad.empty()) split(turning);
    }
    label_ = best;
  }

  std::vector<SignedAxis> axes() const {
    std::vector<SignedAxis> axes(mesh_.twin.size());
    for (int f = 0; f < energy_.face_count(); ++f)
      at(axes, at(energy_.half_faces, f)) = axis_of_label(at(label_, f));
    return axes;
  }

 private:
  std::vector<int> patches() const {
    std::vector<int> parent(energy_.half_faces.size());
    std::iota(parent.begin(), parent.end(), 0);
    const auto root = [&](int f) {
      while (at(parent, f) != f) f = at(parent, f) = at(parent, at(parent, f));
      return f;
    };
    for (const LabelEnergy::Link& link : energy_.links) {
      if (at(label_, link.face[0]) == at(label_, link.face[1]))
        at(parent, root(link.face[0])) = root(link.face[1]);
    }
    std::vector<int> patch(energy_.half_faces.size());
    for (int f = 0; f < energy_.face_count(); ++f) at(patch, f) = root(f);
    return patch;
  }

  // Per patch, named by one of its faces: the vertices where it meets two other patches.
  std::vector<int> corner_counts(const std::vector<int>& patch) const {
    std::vector<std::set<int>> around(mesh_.points.size());
    for (int f = 0; f < energy_.face_count(); ++f) {
      for (const int v : half_face_vertices(mesh_.tets, at(energy_.half_faces, f)))
        at(around, v).insert(at(patch, f));
    }
    std::vector<int> corners(energy_.half_faces.size(), 0);
    for (const std::set<int>& patches_here : around) {
      if (patches_here.size() < 3) continue;
      for (const int p : patches_here) ++at(corners, p);
    }
    return corners;
  }

  std::set<int> bad_patches() const {
    const std::vector<int> patch = patches();
    const std::vector<int> corners = corner_counts(patch);
    std::set<int> bad;
    for (const int p : patch) {
      if (at(corners, p) < fewest_corners) bad.insert(p);
    }
    return bad;
  }

  void give_up(const std::set<int>& bad) {
    const std::vector<int> patch = patches();
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
