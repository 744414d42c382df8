// tets.mesh: reader and adjacency.
#include "core/edge_rings.hpp"
#include "core/tet_io.hpp"
#include "fuzz/fuzz_target.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace neurframe;
  return end_as_documented([&] {
    TextReader reader("tets.mesh", as_text(data, size), '#');
    const TetMesh mesh = parse_tet_mesh(reader);
    edge_rings(mesh.T, half_face_twins(mesh.T, mesh.V.size()));
  });
}
