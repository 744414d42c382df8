// Shape and size of the corners of quads and hexes as one energy, regularised so that it can untangle.
//
// At each corner, S has the d edge vectors divided by their target lengths as columns, D = det S (for quads
// with the normal as third column) and chi(D) = (D + sqrt(D^2 + epsilon^2)) / 2:
//
//     phi = (1 - size) tr(S^T S) / (d chi^(2/d))  +  size (1 + D^2) / (2 chi)    (Garanzha et al. 2021,
//     equation 2)
//
// Both parts are 1 for the target corner and more otherwise; with epsilon = 0 the energy is infinite where D
// <= 0.
//
// A shared library with C functions over the caller's arrays, which they do not keep.  Nothing is allocated
// but what the threads need, nothing is thrown, and the result does not depend on the number of threads.
#pragma once

#include <cstdint>

extern "C" {

// Corners of a mesh with n vertices.
struct NeurframeCorners {
  std::int64_t vertex_count;      // n
  std::int64_t count;             // m
  std::int64_t dimension;         // d: 2 for quads, 3 for hexes
  const std::int64_t* vertices;   // (m, 1 + d): each corner and the ends of its edges, right-handed
  const double* inverse;          // (m, d): one over the target lengths
  const std::int64_t* first_use;  // (n + 1): where the uses of each vertex begin in `uses`
  const std::int64_t* uses;  // (m (1 + d)): places in `vertices`, those of one vertex together and in order
};

struct NeurframeWeights {
  double size;
  double power;  // of phi: the energy is the sum of phi^power / power
  double epsilon;
};

// The energy at positions x (n, 3), and its gradient (n, 3); infinite, with an undefined gradient, where a
// corner is inverted and epsilon is 0, or past the range of floats.  normals (m, 3) unit for quads, null for
// hexes. parts (m, 1 + d, 3) is room to work in.
double neurframe_corner_energy(const NeurframeCorners* corners, const double* x, const double* normals,
                               const NeurframeWeights* weights, int threads, double* parts, double* gradient);

// The least D over all corners; infinity if there are none.
double neurframe_least_determinant(const NeurframeCorners* corners, const double* x, const double* normals,
                                   int threads);

// D over the product of the edges' lengths, the scaled Jacobian, of `chosen` corners (k): quality (k).
// normals (k, 3) of these.
void neurframe_scaled_jacobians(const NeurframeCorners* corners, const double* x, const double* normals,
                                const std::int64_t* chosen, std::int64_t chosen_count, int threads,
                                double* quality);
}
