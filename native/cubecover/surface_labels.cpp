#include "cubecover/surface_labels.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "cubecover/max_flow.hpp"
#include "cubecover/turning_borders.hpp"

namespace neurframe {

namespace {

constexpr int label_count = 6;
constexpr double fidelity_width = 0.2;      // of 1 - cosine, as in PolyCut
constexpr double compactness_width = 0.25;  // of 1 - cosine between neighbours, as in PolyCut
constexpr double given_up = 1e4;            // fidelity cost of a label that a patch must not have again
constexpr double fold_cost = 10;            // of a border between opposite labels, beside its length
constexpr int most_sweeps = 6;              // over the labels; two or three suffice
constexpr int most_repairs = 12;
constexpr int fewest_corners = 4;

SignedAxis axis_of_label(int label) {
  return {label / 2, label % 2 == 0 ? 1 : -1};
}

double bell(double offset, double width) {
  return std::exp(-0.5 * offset * offset / (width * width));
}

class Labelling {
 public:
  Labelling(const FieldMesh& mesh, const std::vector<BoundaryEdge>& edges, const LabelCosts& costs)
      : mesh_(mesh), edges_(edges), face_of_(mesh.twin.size(), -1) {
    for (int h = 0; h < mesh.half_face_count(); ++h) {
      if (at(mesh.twin, h) >= 0) continue;
      at(face_of_, h) = static_cast<int>(half_faces_.size());
      half_faces_.push_back(h);
    }
    double area = 0;
    for (const int h : half_faces_) area += area_vector(mesh, h).norm();
    mean_area_ = area / static_cast<double>(half_faces_.size());
    for (const BoundaryEdge& edge : edges) links_.push_back(link_of(edge, costs));
    set_fidelity();
  }

  // Repairs may be in vain, or one undo the other: the labels with the fewest faults are kept.
  void solve() {
    std::vector<int> best;
    std::size_t fewest = std::numeric_limits<std::size_t>::max();
    for (int repair = 0; repair <= most_repairs && fewest > 0; ++repair) {
      expand_all();
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
    for (int f = 0; f < face_count(); ++f) at(axes, at(half_faces_, f)) = axis_of_label(at(label_, f));
    return axes;
  }

 private:
  struct Link {
    int face[2];
    double cost;        // of a border between the two
    double opposite;    // ... with opposite labels: a fold, however sharp the edge
    double crooked[3];  // added where the border should run along this axis: how far it does not
  };

  int face_count() const { return static_cast<int>(half_faces_.size()); }
  Eigen::Vector3d normal(int face) const { return area_vector(mesh_, at(half_faces_, face)).normalized(); }

  Link link_of(const BoundaryEdge& edge, const LabelCosts& costs) const {
    Link link{{at(face_of_, edge.begin_face), at(face_of_, edge.end_face)}, 0, 0, {}};
    const double bend = 1 - normal(link.face[0]).dot(normal(link.face[1]));
    // in units of the mean edge of the surface, as fidelity is in units of the mean face
    const double length =
        edge_length(mesh_, edge_key(edge.vertices[0], edge.vertices[1])) / std::sqrt(mean_area_);
    link.cost = costs.compactness * length * bell(bend, compactness_width);
    link.opposite = 2 * link.cost + fold_cost * length;
    const Eigen::Vector3d along =
        (at(mesh_.points, edge.vertices[1]) - at(mesh_.points, edge.vertices[0])).normalized();
    for (int axis = 0; axis < 3; ++axis) {
      const double cosine = at(mesh_.frames, edge.begin_face / 4).col(axis).dot(along);
      // up to 45 degrees off is what the triangles of a smooth surface do by chance
      link.crooked[axis] = costs.straightness * length * std::max(0.0, 1 - 2 * cosine * cosine);
    }
    return link;
  }

  void set_fidelity() {
    fidelity_.resize(static_cast<std::size_t>(label_count * face_count()));
    label_.resize(half_faces_.size());
    forced_.resize(half_faces_.size());
    for (int f = 0; f < face_count(); ++f) {
      const int h = at(half_faces_, f);
      const double share = area_vector(mesh_, h).norm() / mean_area_;
      for (int l = 0; l < label_count; ++l) {
        const double cosine = direction_of(at(mesh_.frames, h / 4), axis_of_label(l)).dot(normal(f));
        fidelity(f, l) = share * (1 - bell(1 - cosine, fidelity_width)) + 1e-3 * share * (1 - cosine);
        if (fidelity(f, l) < fidelity(f, at(label_, f))) at(label_, f) = l;
      }
    }
  }

  double& fidelity(int face, int label) { return at(fidelity_, label_count * face + label); }

  static double border_cost(const Link& link, int a, int b) {
    if (a == b) return 0;
    return a / 2 == b / 2 ? link.opposite : link.cost + link.crooked[3 - a / 2 - b / 2];
  }

  void expand_all() {
    for (int sweep = 0; sweep < most_sweeps; ++sweep) {
      bool changed = false;
      for (int l = 0; l < label_count; ++l) changed = expand(l) || changed;
      if (!changed) return;
    }
  }

  // The best labelling in which faces keep their labels or take this one: a minimum cut (Kolmogorov and Zabih
  // 2004, section 4); a face on the sink's side takes it.
  bool expand(int label) {
    MinimumCut cut(face_count());
    for (int f = 0; f < face_count(); ++f)
      cut.add_node_cost(f, fidelity(f, at(label_, f)), fidelity(f, label));
    for (const Link& link : links_) {
      const auto [i, j] = link.face;
      const double neither = border_cost(link, at(label_, i), at(label_, j));
      const double second = border_cost(link, at(label_, i), label);  // only j takes it
      const double first = border_cost(link, label, at(label_, j));   // only i takes it
      // with x = 1 for a face that takes it: neither + (first - neither) x_i - first x_j + (...) (1 - x_i)
      // x_j
      cut.add_node_cost(i, 0, first - neither);
      cut.add_node_cost(j, 0, -first);
      // negative where both sides would trade a fold for two sharp borders: then left out, and energy()
      // judges
      cut.add_edge(i, j, first + second - neither);
    }
    const std::vector<int> before = label_;
    const double energy_before = energy();
    const std::vector<char> takes = cut.sink_side();
    for (int f = 0; f < face_count(); ++f) {
      if (at(takes, f)) at(label_, f) = label;
    }
    if (energy() < energy_before - 1e-9) return true;
    label_ = before;
    return false;
  }

  double energy() {
    double sum = 0;
    for (int f = 0; f < face_count(); ++f) sum += fidelity(f, at(label_, f));
    for (const Link& link : links_)
      sum += border_cost(link, at(label_, link.face[0]), at(label_, link.face[1]));
    return sum;
  }

  std::vector<int> patches() const {
    std::vector<int> parent(half_faces_.size());
    std::iota(parent.begin(), parent.end(), 0);
    const auto root = [&](int f) {
      while (at(parent, f) != f) f = at(parent, f) = at(parent, at(parent, f));
      return f;
    };
    for (const Link& link : links_) {
      if (at(label_, link.face[0]) == at(label_, link.face[1]))
        at(parent, root(link.face[0])) = root(link.face[1]);
    }
    std::vector<int> patch(half_faces_.size());
    for (int f = 0; f < face_count(); ++f) at(patch, f) = root(f);
    return patch;
  }

  // Per patch, named by one of its faces: the vertices where it meets two other patches.
  std::vector<int> corner_counts(const std::vector<int>& patch) const {
    std::vector<std::set<int>> around(mesh_.points.size());
    for (int f = 0; f < face_count(); ++f) {
      for (const int v : half_face_vertices(mesh_.tets, at(half_faces_, f)))
        at(around, v).insert(at(patch, f));
    }
    std::vector<int> corners(half_faces_.size(), 0);
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
    for (int f = 0; f < face_count(); ++f) {
      if (bad.contains(at(patch, f))) fidelity(f, at(label_, f)) += given_up;
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
      for (const int h : *cheapest) force_axis(at(face_of_, h), third);
    }
  }

  double cost_of_axis(const std::vector<int>& half_faces, int axis) {
    double cost = 0;
    for (const int h : half_faces) {
      const int f = at(face_of_, h);
      cost += std::min(fidelity(f, 2 * axis), fidelity(f, 2 * axis + 1)) - fidelity(f, at(label_, f));
    }
    return cost;
  }

  // A part that was moved before and came back did so because its new patch had too few corners.
  bool was_forced(const std::vector<int>& half_faces) const {
    return std::any_of(half_faces.begin(), half_faces.end(),
                       [&](int h) { return at(forced_, at(face_of_, h)) != 0; });
  }

  void force_axis(int face, int axis) {
    at(forced_, face) = 1;
    const int taken = fidelity(face, 2 * axis) <= fidelity(face, 2 * axis + 1) ? 2 * axis : 2 * axis + 1;
    for (int l = 0; l < label_count; ++l) {
      if (l != taken) fidelity(face, l) += given_up;
    }
  }

  const FieldMesh& mesh_;
  const std::vector<BoundaryEdge>& edges_;
  std::vector<int> face_of_;     // per half-face
  std::vector<int> half_faces_;  // per face of the boundary
  std::vector<Link> links_;
  std::vector<double> fidelity_;
  std::vector<int> label_;
  std::vector<char> forced_;  // per face: its axis was chosen to end a turning border
  double mean_area_ = 0;
};

}  // namespace

std::vector<SignedAxis> surface_labels(const FieldMesh& mesh, const std::vector<BoundaryEdge>& edges,
                                       const LabelCosts& costs) {
  Labelling labelling(mesh, edges, costs);
  labelling.solve();
  return labelling.axes();
}

}  // namespace neurframe
