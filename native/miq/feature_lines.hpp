// Which edges are to become integer isolines.
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "miq/cross_surface.hpp"

namespace neurframe {

struct FeatureOptions {
  double angle_deg = 45;
  double shortest_line = 0;
  bool given = false;  // only `pairs`, no detection
  std::vector<std::pair<int, int>> pairs;
  std::vector<Eigen::Vector3d> released_at;  // lines through these points are left out
};

// Marks boundary edges, given vertex pairs, and edges whose normals differ by more than the angle; detected
// lines shorter than `shortest_line` in all are taken for noise and left out.
void mark_features(CrossSurface& surface, const FeatureOptions& options);

// Makes ordinary edges of every feature line, between its ends, corners and crossings, that passes through
// one of the points.  Boundary lines stay.  Returns the number of edges.
int release_lines(CrossSurface& surface, const std::vector<Eigen::Vector3d>& points);

// Midpoints of the feature edges, boundary aside, that are nearest to these triangles in rings of neighbours;
// none if that is more than `rings`.
std::vector<Eigen::Vector3d> feature_points_near(const CrossSurface& surface,
                                                 const std::vector<int>& triangles, int rings);

}  // namespace neurframe
