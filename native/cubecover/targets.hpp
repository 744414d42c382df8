// The gradients that the map should have, tet by tet.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "cubecover/reduced_map.hpp"

namespace neurframe {

// With U the 3x4 parameters of a tet's corners, S = U relative[t] is the map's gradient measured against
// frame and edge length: the identity for a map whose cells are cubes of that edge length along the frame.
struct TetTargets {
  std::vector<Eigen::Matrix<double, 4, 3>> relative;
  std::vector<double> weight;  // volumes, floored so that slivers count
};

TetTargets make_targets(const FieldMesh& mesh, double cell_length);

inline Eigen::Matrix3d relative_gradient(const TetTargets& targets, const ReducedMap& map,
                                         const Eigen::VectorXd& rows, int tet) {
  return corner_parameters(map, rows, tet) * at(targets.relative, tet);
}

// The smallest determinant of the relative gradients, and how many are not positive.
struct Foldover {
  int count = 0;
  double smallest = 0;
};

Foldover measure_foldover(const TetTargets& targets, const ReducedMap& map, const Eigen::VectorXd& rows);

// Power mean over the volume of the foldover-free energy without its regularisation: 5 where cells are cubes
// of the edge length asked for, infinite where the map folds.
double mean_distortion(const TetTargets& targets, const ReducedMap& map, const Eigen::VectorXd& rows);

// Parametric volume: the number of hexes that an injective map contains.
double parametric_volume(const ReducedMap& map, const Eigen::VectorXd& rows);

}  // namespace neurframe
