// What neurframe-cubecover starts from.
#include "fuzz/field_parts.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace neurframe;
  return end_as_documented([&] { sharp_edges(parse_field_parts({data, size}), 45); });
}
