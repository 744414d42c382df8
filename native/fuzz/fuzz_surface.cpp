// What neurframe-miq reads: surface, crosses, feature pairs and sizing, between separators.
#include "fuzz/fuzz_target.hpp"
#include "miq/surface_io.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace neurframe;
  return end_as_documented([&] {
    std::string_view rest(reinterpret_cast<const char*>(data), size);
    TextReader surface("surface.obj", next_part(rest), 0);
    const TriangleMesh mesh = parse_surface_obj(surface);
    TextReader crosses("crosses.txt", next_part(rest), '#');
    TextReader pairs("features.txt", next_part(rest), '#');
    TextReader sizing("sizing.txt", next_part(rest), '#');
    parse_crosses(crosses, false, mesh);
    parse_vertex_pairs(pairs, mesh.V.size());
    parse_sizing(sizing, mesh.V.size());
    TextReader rosy("field.rosy", next_part(rest), '#');
    parse_crosses(rosy, true, mesh);
  });
}
