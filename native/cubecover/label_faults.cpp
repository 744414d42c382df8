#include "cubecover/label_faults.hpp"

#include <map>
#include <numeric>

namespace neurframe {

std::vector<SignedAxis> axes_of(const LabelEnergy& energy, const std::vector<int>& labels) {
  std::vector<SignedAxis> axes(energy.face_of.size());
  for (int f = 0; f < energy.face_count(); ++f)
    at(axes, at(energy.half_faces, f)) = axis_of_label(at(labels, f));
  return axes;
}

std::vector<int> patches_of(const LabelEnergy& energy, const std::vector<int>& labels) {
  std::vector<int> parent(energy.half_faces.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int f) {
    while (at(parent, f) != f) f = at(parent, f) = at(parent, at(parent, f));
    return f;
  };
  for (const LabelEnergy::Link& link : energy.links) {
    if (at(labels, link.face[0]) == at(labels, link.face[1]))
      at(parent, root(link.face[0])) = root(link.face[1]);
  }
  std::vector<int> patch(energy.half_faces.size());
  for (int f = 0; f < energy.face_count(); ++f) at(patch, f) = root(f);
  return patch;
}

namespace {

constexpr int fewest_corners = 4;

std::vector<std::set<int>> patches_around(const FieldMesh& mesh, const LabelEnergy& energy,
                                          const std::vector<int>& patch) {
  std::vector<std::set<int>> around(mesh.points.size());
  for (int f = 0; f < energy.face_count(); ++f) {
    for (const int v : half_face_vertices(mesh.tets, at(energy.half_faces, f)))
      at(around, v).insert(at(patch, f));
  }
  return around;
}

// Per patch, named by one of its faces: the vertices where it meets two other patches.
std::vector<int> corner_counts(const FieldMesh& mesh, const LabelEnergy& energy,
                               const std::vector<int>& patch) {
  std::vector<int> corners(energy.half_faces.size(), 0);
  for (const std::set<int>& patches_here : patches_around(mesh, energy, patch)) {
    if (patches_here.size() < 3) continue;
    for (const int p : patches_here) ++at(corners, p);
  }
  return corners;
}

std::set<int> small_patches(const FieldMesh& mesh, const LabelEnergy& energy, const std::vector<int>& patch) {
  const std::vector<int> corners = corner_counts(mesh, energy, patch);
  std::set<int> small;
  for (const int p : patch) {
    if (at(corners, p) < fewest_corners) small.insert(p);
  }
  return small;
}

// Vertices less edges plus faces of each patch, which is cut open where it meets itself in a vertex.
std::vector<int> euler_characteristics(const FieldMesh& mesh, const LabelEnergy& energy,
                                       const std::vector<int>& patch,
                                       const std::vector<LabelCorner>& corners) {
  std::vector<std::set<int>> around = patches_around(mesh, energy, patch);
  std::vector<int> euler(patch.size(), 0);
  for (const LabelCorner& corner : corners) {
    for (const LabelCorner::Fan& fan : corner.fans)
      ++at(euler, at(patch, at(energy.face_of, fan.half_faces.front())));
    at(around, corner.vertex).clear();
  }
  for (const std::set<int>& patches_here : around) {
    for (const int p : patches_here) ++at(euler, p);
  }
  for (const LabelEnergy::Link& link : energy.links) {
    const int first = at(patch, link.face[0]), second = at(patch, link.face[1]);
    --at(euler, first);
    if (second != first) --at(euler, second);
  }
  for (const int p : patch) ++at(euler, p);
  return euler;
}

// Straight edges turn by four right angles round a disc: at the corners of a patch the angles, in quarter
// turns, must be short of two by four times its Euler characteristic in all.
std::set<int> bent_patches(const FieldMesh& mesh, const LabelEnergy& energy, const std::vector<int>& patch,
                           const std::vector<LabelCorner>& corners) {
  std::vector<int> euler = euler_characteristics(mesh, energy, patch, corners);
  std::map<int, std::array<int, 2>> turning;  // least and most
  std::set<int> unknown;
  for (const LabelCorner& corner : corners) {
    for (const LabelCorner::Fan& fan : corner.fans) {
      const int p = at(patch, at(energy.face_of, fan.half_faces.front()));
      turning[p][0] += 2 - fan.most_quarter_turns;
      turning[p][1] += 2 - fan.least_quarter_turns;
      if (!corner.is_possible) unknown.insert(p);
    }
  }
  std::set<int> bent;
  for (const auto& [p, turns] : turning) {
    const int needed = 4 * at(euler, p);
    if (!unknown.contains(p) && (needed < turns[0] || needed > turns[1])) bent.insert(p);
  }
  return bent;
}

}  // namespace

LabelFaults find_label_faults(const FieldMesh& mesh, const std::vector<BoundaryEdge>& edges,
                              const LabelEnergy& energy, const std::vector<int>& labels) {
  const std::vector<SignedAxis> axes = axes_of(energy, labels);
  const std::vector<int> patch = patches_of(energy, labels);
  std::vector<LabelCorner> corners = find_label_corners(mesh, edges, axes);
  const std::set<int> bent = bent_patches(mesh, energy, patch, corners);
  double stretch = 0;
  for (const LabelCorner& corner : corners) stretch += corner.stretch;
  std::erase_if(corners, [](const LabelCorner& corner) { return corner.is_possible; });
  return {small_patches(mesh, energy, patch), find_turning_borders(mesh, edges, axes), std::move(corners),
          bent, stretch};
}

}  // namespace neurframe
