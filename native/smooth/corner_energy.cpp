#include "smooth/corner_energy.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "core/parallel.hpp"

namespace neurframe {

namespace {

using Vector = std::array<double, 3>;

constexpr double smallest_length =
    1e-300;  // a zero edge gives a scaled Jacobian of 0, not a division by zero

double dot(const Vector& a, const Vector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Vector read(const double* from) {
  return {from[0], from[1], from[2]};
}

// One corner: the columns of S, and the derivatives of its determinant by them.
template <int d>
struct Corner {
  std::array<Vector, d> columns;
  std::array<Vector, d> cofactors;

  Corner(const NeurframeCorners& mesh, std::int64_t corner, const double* x, const double* normal) {
    const std::int64_t* vertices = mesh.vertices + corner * (1 + d);
    const double* inverse = mesh.inverse + corner * d;
    const double* origin = x + 3 * vertices[0];
    for (int k = 0; k < d; ++k) {
      const double* end = x + 3 * vertices[1 + k];
      for (int c = 0; c < 3; ++c) columns[k][c] = (end[c] - origin[c]) * inverse[k];
    }
    if constexpr (d == 2) {
      cofactors = {cross(columns[1], read(normal)), cross(read(normal), columns[0])};
    } else {
      cofactors = {cross(columns[1], columns[2]), cross(columns[2], columns[0]),
                   cross(columns[0], columns[1])};
    }
  }

  double determinant() const { return dot(columns[0], cofactors[0]); }

  double trace() const {
    double sum = 0;
    for (const Vector& column : columns) sum += dot(column, column);
    return sum;
  }
};

template <int d>
const double* normal_of(const double* normals, std::int64_t corner) {
  return d == 2 ? normals + 3 * corner : nullptr;
}

// phi and its derivatives by tr(S^T S) and by D.
struct Density {
  double value;
  double by_trace;
  double by_determinant;
};

template <int d>
Density density(double trace, double D, const NeurframeWeights& weights) {
  const double root = std::sqrt(D * D + weights.epsilon * weights.epsilon);
  // the second form is the same number without cancellation where D < 0
  const double chi = D > 0 ? (D + root) / 2 : weights.epsilon * weights.epsilon / (2 * (root - D));
  const double chi_by_D = chi / root;
  const double root_of_chi = d == 2 ? chi : std::exp(2.0 / 3 * std::log(chi));  // half the time of cbrt
  const double by_trace = (1 - weights.size) / (d * root_of_chi);
  const double shape = by_trace * trace;
  const double size = weights.size * (1 + D * D) / (2 * chi);
  return {shape + size, by_trace, weights.size * D / chi - (2.0 / d * shape + size) / chi * chi_by_D};
}

double power_of(double base, double exponent) {
  if (exponent == 0) return 1;
  if (exponent == 1) return base;
  if (exponent == 3) return base * base * base;
  return std::pow(base, exponent);
}

// The energy of one corner; its derivatives by the corner's vertex and by the ends of its edges go to
// `parts`.
template <int d>
double corner_energy(const NeurframeCorners& mesh, std::int64_t i, const double* x, const double* normals,
                     const NeurframeWeights& weights, double* parts) {
  const Corner<d> corner(mesh, i, x, normal_of<d>(normals, i));
  const double D = corner.determinant();
  if (weights.epsilon == 0 && D <= 0) return std::numeric_limits<double>::infinity();
  const Density phi = density<d>(corner.trace(), D, weights);
  const double outer = power_of(phi.value, weights.power - 1);
  const double along_column = 2 * outer * phi.by_trace, along_cofactor = outer * phi.by_determinant;
  double* part = parts + i * 3 * (1 + d);
  for (int c = 0; c < 3; ++c) part[c] = 0;
  for (int k = 0; k < d; ++k) {
    const double inverse = mesh.inverse[i * d + k];
    for (int c = 0; c < 3; ++c) {
      const double derivative =
          (along_column * corner.columns[k][c] + along_cofactor * corner.cofactors[k][c]) * inverse;
      part[3 * (1 + k) + c] = derivative;
      part[c] -= derivative;
    }
  }
  return outer * phi.value / weights.power;
}

template <int d>
double energy(const NeurframeCorners& mesh, const double* x, const double* normals,
              const NeurframeWeights& weights, int threads, double* parts, double* gradient) {
  std::vector<double> sums(static_cast<std::size_t>(chunk_count(mesh.count)), 0);
  parallel_chunks(mesh.count, threads, [&](std::int64_t begin, std::int64_t end, std::int64_t chunk) {
    double sum = 0;
    for (std::int64_t i = begin; i < end && std::isfinite(sum); ++i)
      sum += corner_energy<d>(mesh, i, x, normals, weights, parts);
    sums[static_cast<std::size_t>(chunk)] = sum;
  });
  double value = 0;
  for (const double sum : sums) value += sum;
  if (!std::isfinite(value)) return std::numeric_limits<double>::infinity();
  std::vector<char> broken(static_cast<std::size_t>(chunk_count(mesh.vertex_count)), 0);
  parallel_chunks(mesh.vertex_count, threads, [&](std::int64_t begin, std::int64_t end, std::int64_t chunk) {
    for (std::int64_t v = begin; v < end; ++v) {
      Vector sum = {0, 0, 0};
      for (std::int64_t u = mesh.first_use[v]; u < mesh.first_use[v + 1]; ++u) {
        for (int c = 0; c < 3; ++c) sum[c] += parts[3 * mesh.uses[u] + c];
      }
      if (!std::isfinite(sum[0] + sum[1] + sum[2])) broken[static_cast<std::size_t>(chunk)] = 1;
      for (int c = 0; c < 3; ++c) gradient[3 * v + c] = sum[c];
    }
  });
  for (const char is_broken : broken) {
    if (is_broken) return std::numeric_limits<double>::infinity();
  }
  return value;
}

template <int d>
double least_determinant(const NeurframeCorners& mesh, const double* x, const double* normals, int threads) {
  std::vector<double> least(static_cast<std::size_t>(chunk_count(mesh.count)),
                            std::numeric_limits<double>::infinity());
  parallel_chunks(mesh.count, threads, [&](std::int64_t begin, std::int64_t end, std::int64_t chunk) {
    for (std::int64_t i = begin; i < end; ++i) {
      const double D = Corner<d>(mesh, i, x, normal_of<d>(normals, i)).determinant();
      least[static_cast<std::size_t>(chunk)] = std::min(least[static_cast<std::size_t>(chunk)], D);
    }
  });
  double smallest = std::numeric_limits<double>::infinity();
  for (const double value : least) smallest = std::min(smallest, value);
  return smallest;
}

template <int d>
void scaled_jacobians(const NeurframeCorners& mesh, const double* x, const double* normals,
                      const std::int64_t* chosen, std::int64_t chosen_count, int threads, double* quality) {
  parallel_for(chosen_count, threads, [&](std::int64_t i) {
    const Corner<d> corner(mesh, chosen[i], x, normal_of<d>(normals, i));
    double lengths = 1;
    for (const Vector& column : corner.columns) lengths *= std::sqrt(dot(column, column));
    quality[i] = corner.determinant() / std::max(lengths, smallest_length);
  });
}

}  // namespace

}  // namespace neurframe

double neurframe_corner_energy(const NeurframeCorners* corners, const double* x, const double* normals,
                               const NeurframeWeights* weights, int threads, double* parts,
                               double* gradient) {
  const auto energy = corners->dimension == 2 ? neurframe::energy<2> : neurframe::energy<3>;
  return energy(*corners, x, normals, *weights, threads, parts, gradient);
}

double neurframe_least_determinant(const NeurframeCorners* corners, const double* x, const double* normals,
                                   int threads) {
  const auto least =
      corners->dimension == 2 ? neurframe::least_determinant<2> : neurframe::least_determinant<3>;
  return least(*corners, x, normals, threads);
}

void neurframe_scaled_jacobians(const NeurframeCorners* corners, const double* x, const double* normals,
                                const std::int64_t* chosen, std::int64_t chosen_count, int threads,
                                double* quality) {
  const auto measure =
      corners->dimension == 2 ? neurframe::scaled_jacobians<2> : neurframe::scaled_jacobians<3>;
  measure(*corners, x, normals, chosen, chosen_count, threads, quality);
}
