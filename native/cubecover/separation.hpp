// Rows "these two lie at least one cell apart", found by rays in the injective seamless map.
#pragma once

#include "cubecover/reduced_map.hpp"

namespace neurframe {

// row . integers >= 1
using SeparationRow = std::vector<double>;

// From every boundary face, feature edge and singular edge a ray runs along the chart axes that point away
// from it into the solid.  Every boundary face that it meets, and every critical edge that it passes within
// about a third of a cell, lies at a different integer along the ray.  Without these rows rounding collapses
// thin parts (notes: 38 to 1947 folded tets on 7 of 16 coarse maps, none with them).  `rows` are the
// coordinates of the map.
std::vector<SeparationRow> separation_rows(const CombedField& field, Elimination& elimination,
                                           const ReducedMap& map, const Eigen::VectorXd& rows);

// For each of the tets, which rounding has left without volume: the two of its corners that lie at one
// integer although the seamless map has them apart, the farthest apart, shall be so again.
std::vector<SeparationRow> collapsed_rows(const CombedField& field, Elimination& elimination,
                                          const ReducedMap& map, const Eigen::VectorXd& seamless_rows,
                                          const Eigen::VectorXd& rounded_rows, const std::vector<int>& tets);

}  // namespace neurframe
