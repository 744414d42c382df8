// The input files of neurframe-miq: each reader takes a path, or with parse_ in its name a TextReader.
#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "core/text_reader.hpp"
#include "core/triangle_mesh.hpp"

namespace neurframe {

// Vertices and triangles of an OBJ file; corners may carry /vt/vn, which are ignored.  Raises InputError for
// other polygons and for a file without triangles.
TriangleMesh read_surface_obj(const std::string& path);
TriangleMesh parse_surface_obj(TextReader& reader);

// Two tangent vectors per triangle: 6 numbers a line, or a .rosy file (count, 4, then one vector a line),
// whose second vector is left zero.  Raises InputError unless there is one per triangle.
std::vector<std::array<double, 6>> read_crosses(const std::string& path, const TriangleMesh& mesh);
std::vector<std::array<double, 6>> parse_crosses(TextReader& reader, bool rosy, const TriangleMesh& mesh);

// Raises InputError for a vertex outside [0, vertices).
std::vector<std::pair<int, int>> read_vertex_pairs(const std::string& path, std::size_t vertices);
std::vector<std::pair<int, int>> parse_vertex_pairs(TextReader& reader, std::size_t vertices);

// Positive numbers, one per vertex.  Raises InputError.
std::vector<double> read_sizing(const std::string& path, std::size_t vertices);
std::vector<double> parse_sizing(TextReader& reader, std::size_t vertices);

void write_integers(const std::string& path, const std::vector<int>& values);

double diagonal(const std::vector<Point3>& positions);

}  // namespace neurframe
