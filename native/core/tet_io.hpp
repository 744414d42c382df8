// Tet meshes as MEDIT .mesh text, and frames per tet as FRA 1 text.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "core/tet_mesh.hpp"
#include "core/text_reader.hpp"
#include "core/text_writer.hpp"

namespace neurframe {

using Frame = std::array<Point3, 3>;  // the three axes of a frame

namespace detail {

// The number of vertex indices per item of the MEDIT sections that are skipped; 0 for a section without
// count.
inline int medit_section_width(const TextReader& reader, std::string_view key) {
  struct Section {
    std::string_view name;
    int width;
  };
  constexpr Section sections[] = {{"Edges", 2},        {"Triangles", 3}, {"Quadrilaterals", 4},
                                  {"Hexahedra", 8},    {"Prisms", 6},    {"Pyramids", 5},
                                  {"Corners", 0},      {"Ridges", 0},    {"RequiredVertices", 0},
                                  {"RequiredEdges", 0}};
  for (const Section& section : sections) {
    // an item of Corners, Ridges, Required... is one index; of the others, `width` indices and a reference
    if (key == section.name) return section.width == 0 ? 1 : section.width + 1;
  }
  reader.fail("unknown section " + TextReader::quoted(key) + " of a MEDIT mesh");
}

inline void read_medit_vertices(TextReader& reader, std::vector<Point3>& V) {
  V.resize(reader.count("the number of vertices", 6));
  for (Point3& p : V) {
    p = {reader.number("x"), reader.number("y"), reader.number("z")};
    reader.number("a reference");
  }
}

inline void read_medit_tets(TextReader& reader, std::vector<Tet>& T) {
  T.resize(reader.count("the number of tets", 8));
  for (Tet& tet : T) {
    for (int& v : tet) v = static_cast<int>(reader.integer("a vertex", 1, std::int64_t{1} << 30)) - 1;
    reader.number("a reference");
  }
}

}  // namespace detail

// Reads the vertices and tets of an ASCII .mesh file; other sections are skipped.  Raises InputError.
inline TetMesh parse_tet_mesh(TextReader& reader) {
  TetMesh mesh;
  reader.expect("MeshVersionFormatted");
  reader.integer("the format version", 1, 4);
  reader.expect("Dimension");
  reader.integer("the dimension", 3, 3);
  while (!reader.at_end()) {
    const std::string_view key = reader.word("a section");
    if (key == "End") break;
    if (key == "Vertices") {
      detail::read_medit_vertices(reader, mesh.V);
    } else if (key == "Tetrahedra") {
      detail::read_medit_tets(reader, mesh.T);
    } else {
      const int width = detail::medit_section_width(reader, key);
      const std::size_t numbers = static_cast<std::size_t>(width) * reader.count("the number of items", 2);
      for (std::size_t i = 0; i < numbers; ++i) reader.number("an index");
    }
  }
  if (mesh.T.empty()) reader.fail("no tet in the file");
  check_tets(mesh.T, mesh.V.size());
  return mesh;
}

inline TetMesh read_tet_mesh(const std::string& path) {
  TextReader reader(path, '#');
  return parse_tet_mesh(reader);
}

inline void write_tet_mesh(const std::string& path, const TetMesh& mesh) {
  TextWriter out(path);
  out << "MeshVersionFormatted 2\nDimension 3\nVertices\n" << mesh.V.size() << '\n';
  for (const Point3& p : mesh.V) out << p[0] << ' ' << p[1] << ' ' << p[2] << " 0\n";
  out << "Tetrahedra\n" << mesh.T.size() << '\n';
  for (const Tet& t : mesh.T) {
    out << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << ' ' << t[3] + 1 << " 0\n";
  }
  out << "End\n";
  out.commit();
}

// FRA 1: `FRA 1`, then `TETS VECTORS FLAG`, then one line `x y z` for each vector, the vectors of tet 0
// first. VECTORS must be 3.  Raises InputError.
inline std::vector<Frame> parse_frames(TextReader& reader) {
  reader.expect("FRA");
  reader.integer("the format version", 1, 1);
  std::vector<Frame> frames(reader.count("the number of tets", 18));
  reader.integer("the number of vectors per tet", 3, 3);
  reader.integer("the type of the field", 0, 1);
  for (Frame& frame : frames) {
    for (Point3& axis : frame) axis = {reader.number("x"), reader.number("y"), reader.number("z")};
  }
  return frames;
}

inline std::vector<Frame> read_frames(const std::string& path) {
  TextReader reader(path);
  return parse_frames(reader);
}

inline void write_frames(const std::string& path, const std::vector<Frame>& frames) {
  TextWriter out(path);
  out << "FRA 1\n" << frames.size() << " 3 1\n";
  for (const Frame& frame : frames) {
    for (const Point3& axis : frame) out << axis[0] << ' ' << axis[1] << ' ' << axis[2] << '\n';
  }
  out.commit();
}

}  // namespace neurframe
