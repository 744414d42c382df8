// neurframe-cubecover whole, on a few tets: refined they are some fifty, and a solve under ASan takes tenths
// of a second.
#include "cubecover/parametrize.hpp"
#include "fuzz/field_parts.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace neurframe;
  return end_as_documented([&] {
    const FieldMesh mesh = parse_field_parts({data, size});
    if (mesh.tets.size() > 8) return;
    parametrize(mesh, {diagonal(mesh) / 3, 0, 1}, [](double, const std::string&) {});
  });
}
