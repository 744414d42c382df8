// The energy of corners against closed forms and difference quotients, whatever the number of threads.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <vector>

#include "core/testing.hpp"
#include "smooth/corner_energy.hpp"

namespace {

using Index = std::int64_t;

// A corner mesh that owns its arrays.
struct Mesh {
  Index vertex_count = 0;
  Index dimension = 3;
  std::vector<Index> vertices;
  std::vector<double> inverse;
  std::vector<Index> first_use;
  std::vector<Index> uses;

  Index corner_count() const { return static_cast<Index>(vertices.size()) / (1 + dimension); }

  void collect_uses() {
    uses.resize(vertices.size());
    std::iota(uses.begin(), uses.end(), 0);
    std::stable_sort(uses.begin(), uses.end(), [&](Index a, Index b) {
      return vertices[static_cast<std::size_t>(a)] < vertices[static_cast<std::size_t>(b)];
    });
    first_use.assign(static_cast<std::size_t>(vertex_count) + 1, 0);
    for (const Index v : vertices) ++first_use[static_cast<std::size_t>(v) + 1];
    std::partial_sum(first_use.begin(), first_use.end(), first_use.begin());
  }

  NeurframeCorners corners() const {
    return {vertex_count,   corner_count(),   dimension,  vertices.data(),
            inverse.data(), first_use.data(), uses.data()};
  }
};

// The corners of many unit cubes, or squares in the plane z = 0, whose edges have the target length.
Mesh cells(Index dimension, Index count, double target_length, std::vector<double>& x) {
  Mesh mesh;
  mesh.dimension = dimension;
  const Index size = dimension == 2 ? 4 : 8;
  for (Index cell = 0; cell < count; ++cell) {
    for (Index v = 0; v < size; ++v) {
      mesh.vertices.push_back(cell * size + v);
      const bool is_mirrored = std::popcount(static_cast<unsigned>(v)) % 2 == 1;
      for (Index k = 0; k < dimension; ++k) {
        const Index axis = is_mirrored ? dimension - 1 - k : k;
        mesh.vertices.push_back(cell * size + (v ^ (Index{1} << axis)));
        mesh.inverse.push_back(1 / target_length);
      }
      x.insert(x.end(),
               {static_cast<double>(v & 1), static_cast<double>(v >> 1 & 1), static_cast<double>(v >> 2)});
    }
  }
  mesh.vertex_count = count * size;
  mesh.collect_uses();
  return mesh;
}

std::vector<double> upwards(const Mesh& mesh) {
  std::vector<double> normals;
  for (Index i = 0; i < mesh.corner_count(); ++i) normals.insert(normals.end(), {0, 0, 1});
  return normals;
}

double energy(const Mesh& mesh, const std::vector<double>& x, const std::vector<double>& normals,
              const NeurframeWeights& weights, int threads, std::vector<double>& gradient) {
  std::vector<double> parts(3 * mesh.vertices.size());
  gradient.assign(x.size(), 0);
  const NeurframeCorners corners = mesh.corners();
  return neurframe_corner_energy(&corners, x.data(), normals.data(), &weights, threads, parts.data(),
                                 gradient.data());
}

// Some displacement that is different for every coordinate.
double wave(std::size_t i) {
  return 0.13 * std::sin(1.7 * static_cast<double>(i) + 0.3);
}

void test_target_corners_have_energy_one() {
  for (const Index dimension : {2, 3}) {
    std::vector<double> x, gradient;
    const Mesh mesh = cells(dimension, 3, 1, x);
    const double value = energy(mesh, x, upwards(mesh), {0.1, 2, 0}, 1, gradient);
    CHECK_NEAR(value, static_cast<double>(mesh.corner_count()) / 2, 1e-12);
    for (const double g : gradient) CHECK_NEAR(g, 0, 1e-12);
  }
}

void test_gradient_is_that_of_the_energy() {
  for (const Index dimension : {2, 3}) {
    for (const NeurframeWeights weights : {NeurframeWeights{0.1, 1, 0}, NeurframeWeights{0.3, 3, 0.2}}) {
      std::vector<double> x, gradient, unused;
      const Mesh mesh = cells(dimension, 2, 0.9, x);
      for (std::size_t i = 0; i < x.size(); ++i) x[i] += wave(i);
      energy(mesh, x, upwards(mesh), weights, 1, gradient);
      const double step = 1e-6;
      for (std::size_t i = 0; i < x.size(); ++i) {
        std::vector<double> ahead = x, behind = x;
        ahead[i] += step;
        behind[i] -= step;
        const double slope = (energy(mesh, ahead, upwards(mesh), weights, 1, unused) -
                              energy(mesh, behind, upwards(mesh), weights, 1, unused)) /
                             (2 * step);
        CHECK_NEAR(gradient[i], slope, 1e-6 * std::max(1.0, std::abs(slope)));
      }
    }
  }
}

void test_inverted_corners() {
  std::vector<double> x, gradient;
  const Mesh mesh = cells(3, 1, 1, x);
  for (std::size_t i = 2; i < x.size(); i += 3) x[i] = -x[i];
  const NeurframeCorners corners = mesh.corners();
  CHECK(energy(mesh, x, {}, {0.1, 1, 0}, 1, gradient) == std::numeric_limits<double>::infinity());
  CHECK(std::isfinite(energy(mesh, x, {}, {0.1, 1, 0.1}, 1, gradient)));
  CHECK_NEAR(neurframe_least_determinant(&corners, x.data(), nullptr, 1), -1, 1e-15);
}

void test_scaled_jacobian_is_free_of_scale() {
  std::vector<double> x;
  const Mesh mesh = cells(3, 1, 7, x);
  x[3 * 1] = 2;      // one edge twice as long leaves a right angle
  x[3 * 4 + 0] = 1;  // vertex 4 above vertex 1: the edge from vertex 0 leans by 45 degrees
  const std::vector<Index> chosen = {0, 7};
  std::vector<double> quality(2, 0);
  const NeurframeCorners corners = mesh.corners();
  neurframe_scaled_jacobians(&corners, x.data(), nullptr, chosen.data(), 2, 1, quality.data());
  CHECK_NEAR(quality[0], std::sqrt(0.5), 1e-15);
  CHECK_NEAR(quality[1], 1, 1e-15);
}

void test_threads_change_nothing() {
  std::vector<double> x, one, four;
  const Mesh mesh = cells(3, 2000, 0.8, x);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += wave(i);
  const double value = energy(mesh, x, {}, {0.1, 4, 0.1}, 1, one);
  CHECK(value == energy(mesh, x, {}, {0.1, 4, 0.1}, 4, four));
  CHECK(one == four);
}

}  // namespace

int main() {
  test_target_corners_have_energy_one();
  test_gradient_is_that_of_the_energy();
  test_inverted_corners();
  test_scaled_jacobian_is_free_of_scale();
  test_threads_change_nothing();
  return neurframe::test_result();
}
