#include "cubecover/label_energy.hpp"

#include <algorithm>
#include <cmath>

#include "cubecover/max_flow.hpp"

namespace neurframe {

namespace {

constexpr double fidelity_width = 0.2;      // of 1 - cosine, as in PolyCut
constexpr double compactness_width = 0.25;  // of 1 - cosine between neighbours, as in PolyCut
constexpr double fold_cost = 10;            // of a border between opposite labels, beside its length
constexpr double slant_cost = 1e-3;         // of 1 - cosine, where the fidelity is level
constexpr int most_sweeps = 6;              // over the labels; two or three suffice

double bell(double offset, double width) {
  return std::exp(-0.5 * offset * offset / (width * width));
}

double border_cost(const LabelEnergy::Link& link, int a, int b) {
  if (a == b) return 0;
  return a / 2 == b / 2 ? link.opposite : link.cost + link.crooked[3 - a / 2 - b / 2];
}

}  // namespace

LabelEnergy::LabelEnergy(const FieldMesh& mesh, const std::vector<BoundaryEdge>& edges,
                         const LabelCosts& costs)
    : face_of(mesh.twin.size(), -1) {
  double area = 0;
  for (int h = 0; h < mesh.half_face_count(); ++h) {
    if (at(mesh.twin, h) >= 0) continue;
    at(face_of, h) = static_cast<int>(half_faces.size());
    half_faces.push_back(h);
    area += area_vector(mesh, h).norm();
  }
  mean_area_ = area / face_count();
  for (const BoundaryEdge& edge : edges) links.push_back(link_of(mesh, edge, costs));
  set_fidelity(mesh);
}

LabelEnergy::Link LabelEnergy::link_of(const FieldMesh& mesh, const BoundaryEdge& edge,
                                       const LabelCosts& costs) const {
  Link link{{at(face_of, edge.begin_face), at(face_of, edge.end_face)}, 0, 0, {}};
  const Eigen::Vector3d along = at(mesh.points, edge.vertices[1]) - at(mesh.points, edge.vertices[0]);
  const double length = along.norm() / std::sqrt(mean_area_);
  const double bend =
      1 - area_vector(mesh, edge.begin_face).normalized().dot(area_vector(mesh, edge.end_face).normalized());
  link.cost = costs.compactness * length * bell(bend, compactness_width);
  link.opposite = 2 * link.cost + fold_cost * length;
  for (int axis = 0; axis < 3; ++axis) {
    const double cosine = at(mesh.frames, edge.begin_face / 4).col(axis).dot(along.normalized());
    // up to 45 degrees off is what the triangles of a smooth surface do by chance
    link.crooked[axis] = costs.straightness * length * std::max(0.0, 1 - 2 * cosine * cosine);
  }
  return link;
}

void LabelEnergy::set_fidelity(const FieldMesh& mesh) {
  fidelity_.resize(label_count * half_faces.size());
  for (int f = 0; f < face_count(); ++f) {
    const int h = at(half_faces, f);
    const double share = area_vector(mesh, h).norm() / mean_area_;
    for (int l = 0; l < label_count; ++l) {
      const Eigen::Vector3d direction = direction_of(at(mesh.frames, h / 4), axis_of_label(l));
      const double off = 1 - direction.dot(area_vector(mesh, h).normalized());
      fidelity(f, l) = share * (1 - bell(off, fidelity_width) + slant_cost * off);
    }
  }
}

std::vector<int> LabelEnergy::most_faithful() const {
  std::vector<int> labels;
  for (int f = 0; f < face_count(); ++f) {
    int best = 0;
    for (int l = 1; l < label_count; ++l) best = fidelity_of(f, l) < fidelity_of(f, best) ? l : best;
    labels.push_back(best);
  }
  return labels;
}

void LabelEnergy::lower(std::vector<int>& labels) const {
  for (int sweep = 0; sweep < most_sweeps; ++sweep) {
    bool changed = false;
    for (int l = 0; l < label_count; ++l) changed = expand(l, labels) || changed;
    if (!changed) return;
  }
}

// The best labels in which faces keep theirs or take this one: a minimum cut (Kolmogorov and Zabih 2004,
// section 4), in which a face on the sink's side takes it.  With x = 1 for such faces a link costs
//   neither + (first - neither) x_i - first x_j + (first + second - neither) (1 - x_i) x_j.
// The last coefficient is negative where a fold would be traded for two borders along a sharp edge: it is
// then left out, and the energy itself judges what comes of it.
bool LabelEnergy::expand(int label, std::vector<int>& labels) const {
  MinimumCut cut(face_count());
  for (int f = 0; f < face_count(); ++f)
    cut.add_node_cost(f, fidelity_of(f, at(labels, f)), fidelity_of(f, label));
  for (const Link& link : links) {
    const auto [i, j] = link.face;
    const double neither = border_cost(link, at(labels, i), at(labels, j));
    const double second = border_cost(link, at(labels, i), label);  // only j takes it
    const double first = border_cost(link, label, at(labels, j));   // only i takes it
    cut.add_node_cost(i, 0, first - neither);
    cut.add_node_cost(j, 0, -first);
    cut.add_edge(i, j, first + second - neither);
  }
  std::vector<int> expanded = labels;
  const std::vector<char> takes = cut.sink_side();
  for (int f = 0; f < face_count(); ++f) {
    if (at(takes, f)) at(expanded, f) = label;
  }
  if (of(expanded) >= of(labels) - 1e-9) return false;
  labels = std::move(expanded);
  return true;
}

double LabelEnergy::of(const std::vector<int>& labels) const {
  double sum = 0;
  for (int f = 0; f < face_count(); ++f) sum += fidelity_of(f, at(labels, f));
  for (const Link& link : links) sum += border_cost(link, at(labels, link.face[0]), at(labels, link.face[1]));
  return sum;
}

}  // namespace neurframe
