// Analytic surfaces with crosses for the tests of neurframe-miq.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <vector>

#include "core/triangle_mesh.hpp"

namespace neurframe::test {

struct CrossedMesh {
  TriangleMesh mesh;
  std::vector<std::array<double, 6>> crosses;
};

inline Eigen::Vector3d vector(const Point3& p) {
  return {p[0], p[1], p[2]};
}

// Crosses whose first axis is the tangent part of direction(centroid, normal).
inline CrossedMesh with_crosses(
    TriangleMesh mesh,
    const std::function<Eigen::Vector3d(const Eigen::Vector3d&, const Eigen::Vector3d&)>& direction) {
  CrossedMesh out{std::move(mesh), {}};
  for (const Triangle& t : out.mesh.F) {
    const Eigen::Vector3d a = vector(out.mesh.V[static_cast<size_t>(t[0])]);
    const Eigen::Vector3d b = vector(out.mesh.V[static_cast<size_t>(t[1])]);
    const Eigen::Vector3d c = vector(out.mesh.V[static_cast<size_t>(t[2])]);
    const Eigen::Vector3d normal = (b - a).cross(c - a).normalized();
    Eigen::Vector3d axis = direction((a + b + c) / 3, normal);
    axis = (axis - normal * normal.dot(axis)).normalized();
    const Eigen::Vector3d second = normal.cross(axis);
    out.crosses.push_back({axis[0], axis[1], axis[2], second[0], second[1], second[2]});
  }
  return out;
}

// (columns x rows) cells of two triangles; `wrap` closes a direction; position(s, t) on [0,1]^2
inline TriangleMesh parametric_grid(int columns, int rows, bool wrap_s, bool wrap_t,
                                    const std::function<Point3(double, double)>& position) {
  TriangleMesh mesh;
  const int width = wrap_s ? columns : columns + 1;
  const int height = wrap_t ? rows : rows + 1;
  for (int j = 0; j < height; ++j) {
    for (int i = 0; i < width; ++i) mesh.V.push_back(position(i / double(columns), j / double(rows)));
  }
  const auto at = [&](int i, int j) { return (j % height) * width + i % width; };
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const int a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d = at(i, j + 1);
      if ((i + j) % 2) {
        mesh.F.push_back({a, b, c});
        mesh.F.push_back({a, c, d});
      } else {
        mesh.F.push_back({a, b, d});
        mesh.F.push_back({b, c, d});
      }
    }
  }
  return mesh;
}

// The surface of the cube [0,1]^3 with n x n squares a side, outward normals.
inline TriangleMesh cube(int n) {
  TriangleMesh mesh;
  std::map<std::array<int, 3>, int> index;
  const auto vertex = [&](const std::array<int, 3>& p) {
    const auto [found, fresh] = index.emplace(p, static_cast<int>(mesh.V.size()));
    if (fresh) mesh.V.push_back({p[0] / double(n), p[1] / double(n), p[2] / double(n)});
    return found->second;
  };
  for (size_t axis = 0; axis < 3; ++axis) {
    for (int side = 0; side < 2; ++side) {
      const auto corner = [&](int i, int j) {
        std::array<int, 3> p{};
        p[axis] = side * n;
        p[(axis + 1) % 3] = i;
        p[(axis + 2) % 3] = j;
        return vertex(p);
      };
      for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
          const int a = corner(i, j), b = corner(i + 1, j), c = corner(i + 1, j + 1), d = corner(i, j + 1);
          mesh.F.push_back(side ? Triangle{a, b, c} : Triangle{a, c, b});
          mesh.F.push_back(side ? Triangle{a, c, d} : Triangle{a, d, c});
        }
      }
    }
  }
  return mesh;
}

// The surface of the tetrahedron with three right angles at the origin, n edges a side, outward normals: its
// tips are corners of 45 degrees between two features.
inline TriangleMesh right_tetrahedron(int n) {
  TriangleMesh mesh;
  std::map<std::array<int, 3>, int> index;
  const std::array<std::array<int, 3>, 4> corners{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  const std::array<std::array<size_t, 3>, 4> faces{{{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
  for (const auto& face : faces) {
    const auto vertex = [&](int i, int j) {
      std::array<int, 3> p{};
      for (size_t k = 0; k < 3; ++k) {
        p[k] = (n - i - j) * corners[face[0]][k] + i * corners[face[1]][k] + j * corners[face[2]][k];
      }
      const auto [found, fresh] = index.emplace(p, static_cast<int>(mesh.V.size()));
      if (fresh) mesh.V.push_back({p[0] / double(n), p[1] / double(n), p[2] / double(n)});
      return found->second;
    };
    for (int i = 0; i < n; ++i) {
      for (int j = 0; i + j < n; ++j) {
        mesh.F.push_back({vertex(i, j), vertex(i + 1, j), vertex(i, j + 1)});
        if (i + j + 1 < n) mesh.F.push_back({vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
      }
    }
  }
  return mesh;
}

// crosses of a cube: of the coordinate axes, the first that is tangent
inline Eigen::Vector3d cube_direction(const Eigen::Vector3d&, const Eigen::Vector3d& normal) {
  Eigen::Index main = 0;
  normal.cwiseAbs().maxCoeff(&main);
  return Eigen::Vector3d::Unit((main + 1) % 3);
}

inline CrossedMesh moved(CrossedMesh in, const Eigen::Matrix3d& rotation, const Eigen::Vector3d& shift) {
  for (Point3& p : in.mesh.V) {
    const Eigen::Vector3d q = rotation * vector(p) + shift;
    p = {q[0], q[1], q[2]};
  }
  for (auto& cross : in.crosses) {
    const Eigen::Vector3d a = rotation * Eigen::Vector3d(cross[0], cross[1], cross[2]);
    const Eigen::Vector3d b = rotation * Eigen::Vector3d(cross[3], cross[4], cross[5]);
    cross = {a[0], a[1], a[2], b[0], b[1], b[2]};
  }
  return in;
}

inline CrossedMesh joined(const CrossedMesh& a, const CrossedMesh& b) {
  CrossedMesh out = a;
  const int shift = static_cast<int>(a.mesh.V.size());
  out.mesh.V.insert(out.mesh.V.end(), b.mesh.V.begin(), b.mesh.V.end());
  for (const Triangle& t : b.mesh.F) out.mesh.F.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
  out.crosses.insert(out.crosses.end(), b.crosses.begin(), b.crosses.end());
  return out;
}

}  // namespace neurframe::test
