// What labels have that no polycube has.
#pragma once

#include <set>

#include "cubecover/label_corners.hpp"
#include "cubecover/label_energy.hpp"
#include "cubecover/turning_borders.hpp"

namespace neurframe {

// Patches are named by one of their faces.
struct LabelFaults {
  std::set<int> small_patches;  // with too few corners
  std::vector<TurningBorder> borders;
  std::vector<LabelCorner> corners;  // impossible ones
  std::set<int> bent_patches;  // whose angles at the corners do not close to an outline of straight edges
  double stretch = 0;          // radians, of all possible corners

  std::size_t count() const {
    return small_patches.size() + borders.size() + corners.size() + bent_patches.size();
  }
};

// Per half-face.
std::vector<SignedAxis> axes_of(const LabelEnergy& energy, const std::vector<int>& labels);

// Per face, the patch of one label that it belongs to.
std::vector<int> patches_of(const LabelEnergy& energy, const std::vector<int>& labels);

LabelFaults find_label_faults(const FieldMesh& mesh, const std::vector<BoundaryEdge>& edges,
                              const LabelEnergy& energy, const std::vector<int>& labels);

}  // namespace neurframe
