// neurframe-miq whole, on surfaces of a few triangles.
#include "fuzz/surface_parts.hpp"
#include "miq/parametrize.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace neurframe;
  return end_as_documented([&] {
    Parts parts(data, size);
    const SurfaceFiles files = parse_surface_parts(parts);
    if (files.mesh.F.size() > 40) return;
    ParametrizeOptions options;
    options.edge_length = diagonal(files.mesh.V) / 3;
    options.preparation.features.pairs = files.feature_pairs;
    options.preparation.features.given = !files.feature_pairs.empty();
    Json statistics;
    parametrize(files.mesh, files.crosses, files.sizing, options, statistics);
  });
}
