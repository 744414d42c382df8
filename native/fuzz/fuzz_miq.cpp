// neurframe-miq whole, on surfaces of a few triangles: surface, crosses, feature pairs and sizing.
#include "fuzz/fuzz_target.hpp"
#include "miq/parametrize.hpp"
#include "miq/surface_io.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace neurframe;
  return end_as_documented([&] {
    std::string_view rest(reinterpret_cast<const char*>(data), size);
    TextReader surface("surface.obj", next_part(rest), 0);
    const TriangleMesh mesh = parse_surface_obj(surface);
    if (mesh.F.size() > 40) return;
    TextReader cross_reader("crosses.txt", next_part(rest), '#');
    TextReader pairs("features.txt", next_part(rest), '#');
    TextReader sizing("sizing.txt", next_part(rest), '#');
    const auto crosses = parse_crosses(cross_reader, false, mesh);
    ParametrizeOptions options;
    options.edge_length = diagonal(mesh.V) / 3;
    options.preparation.features.pairs = parse_vertex_pairs(pairs, mesh.V.size());
    options.preparation.features.given = !options.preparation.features.pairs.empty();
    Json statistics;
    parametrize(mesh, crosses, parse_sizing(sizing, mesh.V.size()), options, statistics);
  });
}
