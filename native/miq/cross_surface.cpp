#include "miq/cross_surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/triangle_mesh.hpp"

namespace neurframe {

Eigen::Vector3d CrossSurface::normal(int f) const {
  return along(3 * f).cross(along(3 * f + 1)).normalized();
}

double CrossSurface::area(int f) const {
  return along(3 * f).cross(along(3 * f + 1)).norm() / 2;
}

double CrossSurface::corner_angle(int h) const {
  const Eigen::Vector3d out = along(h);
  const Eigen::Vector3d in = -along(previous(h));
  return std::atan2(out.cross(in).norm(), out.dot(in));
}

Eigen::Vector3d CrossSurface::second_axis(int f) const {
  return normal(f).cross(axis[static_cast<size_t>(f)]);
}

void pair_half_edges(CrossSurface& surface) {
  surface.opposite = half_edge_twins(surface.triangles, surface.positions.size());
}

std::vector<int> outgoing_half_edges(const CrossSurface& surface) {
  std::vector<int> out(surface.positions.size(), -1);
  for (int h = 0; h < surface.half_edge_count(); ++h) {
    int& first = out[static_cast<size_t>(surface.from(h))];
    if (first < 0 || surface.twin(h) < 0) first = h;
  }
  return out;
}

std::vector<int> fan(const CrossSurface& surface, int start) {
  std::vector<int> out;
  int h = start;
  do {
    out.push_back(h);
    h = surface.twin(CrossSurface::previous(h));
  } while (h >= 0 && h != start);
  return out;
}

int split_nonmanifold_vertices(CrossSurface& surface) {
  const int before = surface.vertex_count();
  std::vector<char> reached(static_cast<size_t>(surface.half_edge_count()), 0);
  std::vector<char> taken(surface.positions.size(), 0);
  const auto claim = [&](int start) {
    int vertex = surface.from(start);
    const std::vector<int> corners = fan(surface, start);
    if (taken[static_cast<size_t>(vertex)]) {
      surface.positions.push_back(surface.at(vertex));
      vertex = surface.vertex_count() - 1;
    } else {
      taken[static_cast<size_t>(vertex)] = 1;
    }
    for (const int h : corners) {
      reached[static_cast<size_t>(h)] = 1;
      surface.triangles[static_cast<size_t>(h / 3)][static_cast<size_t>(h % 3)] = vertex;
    }
  };
  // open fans first, from their clockwise end; what is left then are closed ones
  for (int h = 0; h < surface.half_edge_count(); ++h) {
    if (surface.twin(h) < 0) claim(h);
  }
  for (int h = 0; h < surface.half_edge_count(); ++h) {
    if (!reached[static_cast<size_t>(h)]) claim(h);
  }
  return surface.vertex_count() - before;
}

double total_area(const CrossSurface& surface) {
  double sum = 0;
  for (int f = 0; f < surface.triangle_count(); ++f) sum += surface.area(f);
  return sum;
}

double bounding_box_diagonal(const std::vector<Eigen::Vector3d>& positions) {
  Eigen::Vector3d low = positions.front();
  Eigen::Vector3d high = low;
  for (const Eigen::Vector3d& p : positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return (high - low).norm();
}

}  // namespace neurframe
