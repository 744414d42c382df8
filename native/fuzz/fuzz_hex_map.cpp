// map.hexex: reader, exact map and extraction.
#include "core/hex_map_io.hpp"
#include "fuzz/extraction_target.hpp"
#include "fuzz/fuzz_target.hpp"
#include "hexex/build_hex_grid_map.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace neurframe;
  return end_as_documented([&] {
    TextReader reader("map.hexex", as_text(data, size), 0);
    OrientationReport orientation;
    MapReport report;
    extract_if_small(build_hex_grid_map(parse_hex_map(reader), true, 1, orientation, report));
  });
}
