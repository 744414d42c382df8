// Hex meshes as MEDIT .mesh, legacy VTK .vtk and OpenVolumeMesh .ovm, all ASCII.
//
// Vertex order of a hex is VTK's: 0 1 2 3 counter-clockwise seen from 4 5 6 7 above them, i + 4 above i.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/text_writer.hpp"
#include "core/triangle_mesh.hpp"

namespace neurframe {

using Hex = std::array<int, 8>;

struct HexMesh {
  std::vector<Point3> V;
  std::vector<Hex> H;
};

// The six faces of a hex with outward normals.
inline constexpr std::array<std::array<int, 4>, 6> hex_faces{
    {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}};

inline void write_hex_medit(TextWriter& out, const HexMesh& mesh) {
  out << "MeshVersionFormatted 2\nDimension 3\nVertices\n" << mesh.V.size() << '\n';
  for (const Point3& p : mesh.V) out << p[0] << ' ' << p[1] << ' ' << p[2] << " 0\n";
  out << "Hexahedra\n" << mesh.H.size() << '\n';
  for (const Hex& hex : mesh.H) {
    for (const int v : hex) out << v + 1 << ' ';
    out << "0\n";
  }
  out << "End\n";
}

inline void write_hex_vtk(TextWriter& out, const HexMesh& mesh) {
  out << "# vtk DataFile Version 3.0\nneurframe hex mesh\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS "
      << mesh.V.size() << " double\n";
  for (const Point3& p : mesh.V) out << p[0] << ' ' << p[1] << ' ' << p[2] << '\n';
  out << "CELLS " << mesh.H.size() << ' ' << 9 * mesh.H.size() << '\n';
  for (const Hex& hex : mesh.H) {
    out << 8;
    for (const int v : hex) out << ' ' << v;
    out << '\n';
  }
  out << "CELL_TYPES " << mesh.H.size() << '\n';
  for (std::size_t h = 0; h < mesh.H.size(); ++h) out << "12\n";
}

}  // namespace neurframe
