// Where a point lies with respect to the four faces of a tet: fast in doubles, exact where doubles cannot
// tell.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "hexex/perturbation.hpp"

namespace neurframe {

// Signs per face (by opposite corner): 1 inside of the face plane, 0 on it, -1 outside.
using FaceSigns = std::array<int, 4>;

inline bool all_positive(const FaceSigns& signs) {
  return signs[0] > 0 && signs[1] > 0 && signs[2] > 0 && signs[3] > 0;
}
inline bool none_negative(const FaceSigns& signs) {
  return signs[0] >= 0 && signs[1] >= 0 && signs[2] >= 0 && signs[3] >= 0;
}

// Exact face signs of a point in the chart of tet t, which must not be flat.
inline int exact_face_sign(const GridMap& map, int t, int face, const FixedPoint3& p) {
  const int h = 4 * t + face;
  const int side = plane_side(face_corner(map, h, 0), face_corner(map, h, 1), face_corner(map, h, 2), p);
  return -side * map.orientation[static_cast<std::size_t>(t)];
}

class TetPlanes {
 public:
  TetPlanes(const GridMap& map, int t) : map_(&map), t_(t), origin_(map.P[static_cast<std::size_t>(t)][0]) {
    double extent = static_cast<double>(map.one());
    for (int i = 1; i < 4; ++i) {
      for (const double x : local(map.P[static_cast<std::size_t>(t)][static_cast<std::size_t>(i)])) {
        extent = std::max(extent, std::abs(x));
      }
    }
    // For points within 2M of the origin (M the extent, u = 2^-53): differences are exact; an entry of the
    // normal is below 8 M^2 with error 16 u M^2; the value is below 72 M^3 with error (144 + 72 + 144) u M^3
    // < 2^-44 M^3.
    error_ = std::ldexp(extent * extent * extent, -43);
    for (int i = 0; i < 4; ++i) set_plane(static_cast<std::size_t>(i));
  }

  double error() const { return error_; }
  const Vector3<double>& normal(std::size_t face) const { return normals_[face]; }

  // Proportional to the distance inside of a face plane, with absolute error at most error().
  double value(std::size_t face, const FixedPoint3& p) const {
    const Vector3<double> x = difference(local(p), bases_[face]);
    return normals_[face][0] * x[0] + normals_[face][1] * x[1] + normals_[face][2] * x[2];
  }

  int sign(std::size_t face, const FixedPoint3& p) const {
    const double v = value(face, p);
    if (std::abs(v) > error_) return v > 0 ? 1 : -1;
    return exact_face_sign(*map_, t_, static_cast<int>(face), p);
  }

  // Stops at the first face that p is outside of.
  FaceSigns signs(const FixedPoint3& p) const {
    FaceSigns all{-1, -1, -1, -1};
    for (std::size_t face = 0; face < 4; ++face) {
      all[face] = sign(face, p);
      if (all[face] < 0) break;
    }
    return all;
  }

 private:
  Vector3<double> local(const FixedPoint3& p) const {
    return {static_cast<double>(p[0] - origin_[0]), static_cast<double>(p[1] - origin_[1]),
            static_cast<double>(p[2] - origin_[2])};
  }

  void set_plane(std::size_t face) {
    const int h = 4 * t_ + static_cast<int>(face);
    const Vector3<double> a = local(face_corner(*map_, h, 0));
    const Vector3<double> b = difference(local(face_corner(*map_, h, 1)), a);
    const Vector3<double> c = difference(local(face_corner(*map_, h, 2)), a);
    const double inward = -map_->orientation[static_cast<std::size_t>(t_)];
    bases_[face] = a;
    normals_[face] = {inward * (b[1] * c[2] - b[2] * c[1]), inward * (b[2] * c[0] - b[0] * c[2]),
                      inward * (b[0] * c[1] - b[1] * c[0])};
  }

  const GridMap* map_;
  int t_;
  FixedPoint3 origin_;
  double error_ = 0.0;
  std::array<Vector3<double>, 4> bases_;
  std::array<Vector3<double>, 4> normals_;
};

}  // namespace neurframe
