// neurframe-cubecover whole, on a few tets: tets.mesh, tets.fra and features.json.
#include "cubecover/map_io.hpp"
#include "cubecover/parametrize.hpp"
#include "fuzz/fuzz_target.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace neurframe;
  return end_as_documented([&] {
    std::string_view rest(reinterpret_cast<const char*>(data), size);
    TextReader tet_reader("tets.mesh", next_part(rest), '#');
    TextReader frame_reader("tets.fra", next_part(rest), 0);
    const TetMesh tets = parse_tet_mesh(tet_reader);
    if (tets.T.size() > 20) return;
    std::vector<EdgeKey> features =
        parse_features("features.json", next_part(rest), static_cast<int>(tets.V.size()));
    const FieldMesh mesh = to_field_mesh(tets, parse_frames(frame_reader), std::move(features));
    parametrize(mesh, {diagonal(mesh) / 3, 0, 1}, [](double, const std::string&) {});
  });
}
