// map.obj with texture coordinates and transition lines: reader, exact map and extraction.
#include "core/quad_map_io.hpp"
#include "fuzz/extraction_target.hpp"
#include "fuzz/fuzz_target.hpp"
#include "qex/build_quad_grid_map.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace neurframe;
  return end_as_documented([&] {
    TextReader reader("map.obj", as_text(data, size), 0);
    bool mirrored = false;
    MapReport report;
    extract_if_small(build_quad_grid_map(parse_quad_map(reader), 1, mirrored, report));
  });
}
