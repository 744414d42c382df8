// The files of neurframe-miq in one input: surface, crosses, feature pairs and sizing.
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "fuzz/fuzz_target.hpp"
#include "miq/surface_io.hpp"

namespace neurframe {

struct SurfaceFiles {
  TriangleMesh mesh;
  std::vector<std::array<double, 6>> crosses;
  std::vector<std::pair<int, int>> feature_pairs;
  std::vector<double> sizing;
};

inline SurfaceFiles parse_surface_parts(Parts& parts) {
  SurfaceFiles files;
  TextReader surface = parts.reader("surface.obj", 0);
  TextReader crosses = parts.reader("crosses.txt", '#');
  TextReader pairs = parts.reader("features.txt", '#');
  TextReader sizing = parts.reader("sizing.txt", '#');
  files.mesh = parse_surface_obj(surface);
  files.crosses = parse_crosses(crosses, false, files.mesh);
  files.feature_pairs = parse_vertex_pairs(pairs, files.mesh.V.size());
  files.sizing = parse_sizing(sizing, files.mesh.V.size());
  return files;
}

}  // namespace neurframe
