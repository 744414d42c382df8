// The files of neurframe-cubecover in one input: tets.mesh, tets.fra and features.json.
#pragma once

#include <vector>

#include "cubecover/map_io.hpp"
#include "fuzz/fuzz_target.hpp"

namespace neurframe {

inline FieldMesh parse_field_parts(Parts parts) {
  TextReader tet_reader = parts.reader("tets.mesh", '#');
  TextReader frame_reader = parts.reader("tets.fra", 0);
  const TetMesh tets = parse_tet_mesh(tet_reader);
  std::vector<EdgeKey> features =
      parse_features("features.json", parts.next(), static_cast<int>(tets.V.size()));
  return to_field_mesh(tets, parse_frames(frame_reader), std::move(features));
}

}  // namespace neurframe
