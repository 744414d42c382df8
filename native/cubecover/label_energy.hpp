// The energy of labels on the boundary, and its minimum by alpha-expansion.
#pragma once

#include "cubecover/boundary_axes.hpp"
#include "cubecover/surface_labels.hpp"

namespace neurframe {

inline constexpr int label_count = 6;

inline SignedAxis axis_of_label(int label) {
  return {label / 2, label % 2 == 0 ? 1 : -1};
}

inline int label_of(SignedAxis axis) {
  return 2 * axis.axis + (axis.sign > 0 ? 0 : 1);
}

// Sum over the boundary's faces of the fidelity of their labels, and over its edges of the cost of the border
// between two labels (Livesu et al. 2013, section 4).  Lengths and areas are in units of the mean face.
class LabelEnergy {
 public:
  LabelEnergy(const FieldMesh& mesh, const std::vector<BoundaryEdge>& edges, const LabelCosts& costs);

  int face_count() const { return static_cast<int>(half_faces.size()); }
  double& fidelity(int face, int label) { return at(fidelity_, label_count * face + label); }
  std::vector<int> most_faithful() const;

  // Labels of no higher energy, by expansions of each label until none helps (Boykov, Veksler and Zabih
  // 2001).
  void lower(std::vector<int>& labels) const;

  double of(const std::vector<int>& labels) const;

  struct Link {  // an edge of the boundary
    int face[2];
    double cost;        // of a border between the two
    double opposite;    // ... with opposite labels: a fold, however sharp the edge
    double crooked[3];  // added where the border should run along this axis: how far it does not
  };

  std::vector<int> half_faces;  // per face
  std::vector<int> face_of;     // per half-face; -1 inside
  std::vector<Link> links;

 private:
  Link link_of(const FieldMesh& mesh, const BoundaryEdge& edge, const LabelCosts& costs) const;
  void set_fidelity(const FieldMesh& mesh);
  bool expand(int label, std::vector<int>& labels) const;
  double fidelity_of(int face, int label) const { return at(fidelity_, label_count * face + label); }

  double mean_area_ = 0;
  std::vector<double> fidelity_;
};

}  // namespace neurframe
