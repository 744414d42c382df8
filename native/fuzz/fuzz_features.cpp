// features.json, or text, of a mesh with 100 vertices.
#include "cubecover/map_io.hpp"
#include "fuzz/fuzz_target.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace neurframe;
  constexpr int vertices = 100;
  return end_as_documented([&] {
    for (const EdgeKey& edge : parse_features("features.json", as_text(data, size), vertices)) {
      if (edge[0] < 0 || edge[1] >= vertices || edge[0] > edge[1]) std::abort();
    }
  });
}
