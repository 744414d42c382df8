// Files in and out: tets, frames and features to a FieldMesh, and the finished map to map.hexex.
#pragma once

#include <string>
#include <vector>

#include "core/hex_map_io.hpp"
#include "core/tet_io.hpp"
#include "cubecover/exact_map.hpp"

namespace neurframe {

// The mesh with one frame per tet.  Raises InputError.
FieldMesh to_field_mesh(const TetMesh& tets, const std::vector<Frame>& frames, std::vector<EdgeKey> features);

// The "edges" of a features.json, pairs of vertex numbers from 0, or of a text file with two numbers a line.
// Raises InputError for anything else and for numbers outside [0, vertices).
std::vector<EdgeKey> read_features(const std::string& path, int vertices);
// ... in a text that is already read; complaints call it `name`.
std::vector<EdgeKey> parse_features(const std::string& name, std::string text, int vertices);

// Fixed-point parameters are decimals of at most 24 binary places: they read back exactly.
HexMap to_hex_map(const FieldMesh& mesh, const ExactMap& map);

}  // namespace neurframe
