// tets.fra.
#include "core/tet_io.hpp"
#include "fuzz/fuzz_target.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace neurframe;
  return end_as_documented([&] {
    TextReader reader("tets.fra", as_text(data, size), 0);
    parse_frames(reader);
  });
}
