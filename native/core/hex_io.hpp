// Hex meshes as MEDIT .mesh, legacy VTK .vtk and OpenVolumeMesh .ovm, all ASCII.
//
// Vertex order of a hex is VTK's: 0 1 2 3 counter-clockwise seen from 4 5 6 7 above them, i + 4 above i.
#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <vector>

#include "core/errors.hpp"
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

namespace detail {

// The distinct edges and faces of a hex mesh, as OpenVolumeMesh lists them: half-edge 2 e (2 e + 1) runs
// along (against) edge e, half-face 2 f (2 f + 1) sees face f from its front (back).
struct HexSkeleton {
  std::vector<std::array<int, 2>> edges;
  std::vector<std::array<int, 4>> faces;  // half-edges
  std::vector<std::array<int, 6>> cells;  // half-faces
};

inline HexSkeleton hex_skeleton(const HexMesh& mesh) {
  HexSkeleton skeleton;
  std::map<std::array<int, 2>, int> edge_numbers;
  std::map<std::array<int, 4>, int> face_numbers;
  const auto half_edge = [&](int a, int b) {
    const std::array<int, 2> edge{std::min(a, b), std::max(a, b)};
    const auto [found, added] = edge_numbers.try_emplace(edge, static_cast<int>(skeleton.edges.size()));
    if (added) skeleton.edges.push_back(edge);
    return 2 * found->second + (a < b ? 0 : 1);
  };
  for (const Hex& hex : mesh.H) {
    std::array<int, 6> cell{};
    for (std::size_t f = 0; f < 6; ++f) {
      std::array<int, 4> face{};
      for (std::size_t k = 0; k < 4; ++k) face[k] = hex[static_cast<std::size_t>(hex_faces[f][k])];
      std::array<int, 4> key = face;
      std::sort(key.begin(), key.end());
      const auto [found, added] = face_numbers.try_emplace(key, static_cast<int>(skeleton.faces.size()));
      if (added) {
        skeleton.faces.push_back({half_edge(face[0], face[1]), half_edge(face[1], face[2]),
                                  half_edge(face[2], face[3]), half_edge(face[3], face[0])});
      }
      // the half-faces of a cell look inward, as OpenVolumeMesh and AlgoHex write them; the first hex has
      // added the face as seen from outside
      cell[f] = 2 * found->second + (added ? 1 : 0);
    }
    skeleton.cells.push_back(cell);
  }
  return skeleton;
}

template <std::size_t N>
void write_ovm_list(TextWriter& out, const char* name, const std::vector<std::array<int, N>>& items,
                    bool with_size) {
  out << name << '\n' << items.size() << '\n';
  for (const auto& item : items) {
    if (with_size) out << static_cast<int>(N) << ' ';
    for (std::size_t k = 0; k < N; ++k) out << item[k] << (k + 1 < N ? ' ' : '\n');
  }
}

}  // namespace detail

inline void write_hex_ovm(TextWriter& out, const HexMesh& mesh) {
  const detail::HexSkeleton skeleton = detail::hex_skeleton(mesh);
  out << "OVM ASCII\nVertices\n" << mesh.V.size() << '\n';
  for (const Point3& p : mesh.V) out << p[0] << ' ' << p[1] << ' ' << p[2] << '\n';
  detail::write_ovm_list(out, "Edges", skeleton.edges, false);
  detail::write_ovm_list(out, "Faces", skeleton.faces, true);
  detail::write_ovm_list(out, "Polyhedra", skeleton.cells, true);
}

// Raises InputError for a file name with another extension than these three.
inline void check_hex_format(const std::string& path) {
  if (path.ends_with(".mesh") || path.ends_with(".vtk") || path.ends_with(".ovm")) return;
  throw InputError(
      path + ": unknown format; allowed are .mesh (MEDIT), .vtk (legacy VTK) and .ovm (OpenVolumeMesh)");
}

// Raises InputError for an unknown extension, StageError when the disk does not take the file.
inline void write_hex_mesh(const std::string& path, const HexMesh& mesh) {
  check_hex_format(path);
  TextWriter out(path);
  if (path.ends_with(".mesh")) write_hex_medit(out, mesh);
  if (path.ends_with(".vtk")) write_hex_vtk(out, mesh);
  if (path.ends_with(".ovm")) write_hex_ovm(out, mesh);
  out.commit();
}

}  // namespace neurframe
