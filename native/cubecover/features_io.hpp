// Reading feature edges.
#pragma once

#include <string>
#include <vector>

#include "cubecover/field_mesh.hpp"

namespace neurframe {

// The "edges" of a features.json, pairs of vertex numbers from 0, or of a text file with two numbers a line.
// Raises InputError for anything else and for numbers outside [0, vertices).
std::vector<EdgeKey> read_features(const std::string& path, int vertices);

}  // namespace neurframe
