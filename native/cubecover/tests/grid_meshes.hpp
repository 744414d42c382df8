// Test meshes: cubes of a grid, each cut into six tets round its diagonal (Kuhn's subdivision, which
// conforms), with frames in closed form.
#pragma once

#include <complex>
#include <functional>
#include <map>
#include <random>

#include "cubecover/field_mesh.hpp"
#include "cubecover/matching.hpp"

namespace neurframe {

using Cell = std::array<int, 3>;
using Warp = std::function<Eigen::Vector3d(const Eigen::Vector3d&)>;
using FrameField = std::function<Eigen::Matrix3d(const Eigen::Vector3d&)>;

struct GridMesh {
  std::vector<Eigen::Vector3d> points;
  std::vector<Tet> tets;
};

// The tets of all cells in [0, size) that `keep` accepts; cell corners are at integer positions.
inline GridMesh grid_mesh(const Cell& size, const std::function<bool(const Cell&)>& keep) {
  constexpr int orders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
  GridMesh mesh;
  std::map<Cell, int> number;
  const auto vertex = [&](const Cell& at_corner) {
    const auto [found, added] = number.try_emplace(at_corner, static_cast<int>(mesh.points.size()));
    if (added) mesh.points.emplace_back(at_corner[0], at_corner[1], at_corner[2]);
    return found->second;
  };
  for (int i = 0; i < size[0]; ++i) {
    for (int j = 0; j < size[1]; ++j) {
      for (int k = 0; k < size[2]; ++k) {
        if (!keep({i, j, k})) continue;
        for (const auto& order : orders) {
          Cell corner{i, j, k};
          Tet tet{vertex(corner), 0, 0, 0};
          for (int step = 0; step < 3; ++step) {
            ++at(corner, order[step]);
            at(tet, step + 1) = vertex(corner);
          }
          mesh.tets.push_back(tet);
        }
      }
    }
  }
  return mesh;
}

inline bool keep_all(const Cell&) {
  return true;
}

// The grid warped into its shape, with the field's frame at every tet's centre and sharp edges as features.
inline FieldMesh field_mesh(GridMesh grid, const Warp& warp, const FrameField& field,
                            double feature_angle_deg = 45) {
  for (Eigen::Vector3d& point : grid.points) point = warp(point);
  std::vector<Eigen::Matrix3d> frames;
  for (const Tet& tet : grid.tets) {
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    for (const int v : tet) center += at(grid.points, v) / 4;
    frames.push_back(field(center));
  }
  FieldMesh mesh = make_field_mesh(std::move(grid.points), std::move(grid.tets), std::move(frames), {});
  mesh.features = sharp_edges(mesh, feature_angle_deg);
  return mesh;
}

inline Eigen::Matrix3d constant_frame(const Eigen::Vector3d&) {
  return Eigen::Matrix3d::Identity();
}
inline Eigen::Vector3d unwarped(const Eigen::Vector3d& point) {
  return point;
}

// The box [0, size] with axis-aligned frames.
inline FieldMesh box(const Cell& size) {
  return field_mesh(grid_mesh(size, keep_all), unwarped, constant_frame);
}

// A box with one edge cut away: an L times an interval, with one concave feature edge.
inline FieldMesh l_shape(int width, int height) {
  const auto keep = [width](const Cell& cell) { return 2 * cell[0] < width || 2 * cell[1] < width; };
  return field_mesh(grid_mesh({width, width, height}, keep), unwarped, constant_frame);
}

// The unit disc times [0, 1]: the square grid pulled onto the disc, and the cross field with four singular
// lines of index 1/4 at distance `radius` from the axis that is tangential to the circle: e^(4 i angle) has
// the phase of (z^4 - r^4) (1 - r^4 z^4), which is that of z^4 where |z| = 1.
inline FieldMesh cylinder(int width, int height, double radius) {
  const auto warp = [=](const Eigen::Vector3d& p) -> Eigen::Vector3d {
    const Eigen::Vector2d q(2 * p.x() / width - 1, 2 * p.y() / width - 1);
    const double stretch = q.norm() > 0 ? q.cwiseAbs().maxCoeff() / q.norm() : 1;
    return {q.x() * stretch, q.y() * stretch, p.z() / height};
  };
  const auto field = [=](const Eigen::Vector3d& p) -> Eigen::Matrix3d {
    const std::complex<double> z(p.x(), p.y());
    const double r4 = std::pow(radius, 4);
    const double angle = std::arg((z * z * z * z - r4) * (1.0 - r4 * z * z * z * z)) / 4;
    return Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  };
  return field_mesh(grid_mesh({width, width, height}, keep_all), warp, field);
}

// The same mesh and field, moved rigidly.
inline FieldMesh moved(const FieldMesh& mesh, const Eigen::Matrix3d& rotation, const Eigen::Vector3d& shift) {
  FieldMesh copy = mesh;
  for (Eigen::Vector3d& point : copy.points) point = rotation * point + shift;
  for (Eigen::Matrix3d& frame : copy.frames) frame = rotation * frame;
  return copy;
}

// The same field with every tet's axes named anew at random: a frame is its axes without names.
inline FieldMesh relabelled(const FieldMesh& mesh, std::mt19937_64& random) {
  FieldMesh copy = mesh;
  std::uniform_int_distribution<int> any(0, OctahedralRotation::count - 1);
  for (Eigen::Matrix3d& frame : copy.frames) frame = frame * to_matrix(OctahedralRotation(any(random)));
  return copy;
}

}  // namespace neurframe
