// What neurframe-miq reads, and crosses as .rosy after it.
#include "fuzz/surface_parts.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace neurframe;
  return end_as_documented([&] {
    Parts parts(data, size);
    const TriangleMesh mesh = parse_surface_parts(parts).mesh;
    TextReader rosy = parts.reader("field.rosy", '#');
    parse_crosses(rosy, true, mesh);
  });
}
