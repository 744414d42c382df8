// map.hexex: an integer-grid map of a tet mesh in the text format of HexEx.
//
//   n, then n lines `x y z`; m, then m lines of 4 vertex indices (from 0) and 12 parameters (u v w of each
//   corner, in cells).  Numbers are decimals or exact rationals a/b, as MC3D writes them; what follows the
//   tets (walls and feature lists of MC3D) is not part of the map and is not read.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/tet_mesh.hpp"
#include "core/text_reader.hpp"
#include "core/text_writer.hpp"

namespace neurframe {

struct HexMap {
  TetMesh mesh;
  std::vector<std::array<Point3, 4>> parameters;  // per tet and corner, in cells
};

// Raises InputError with the line of whatever is not understood.
inline HexMap parse_hex_map(TextReader& reader) {
  HexMap map;
  map.mesh.V.resize(reader.count("the number of vertices", 6));
  for (Point3& p : map.mesh.V) p = {reader.number("x"), reader.number("y"), reader.number("z")};
  const std::int64_t last = static_cast<std::int64_t>(map.mesh.V.size()) - 1;
  const std::size_t tets = reader.count("the number of tets", 32);
  map.mesh.T.resize(tets);
  map.parameters.resize(tets);
  for (std::size_t t = 0; t < tets; ++t) {
    for (int& v : map.mesh.T[t]) v = static_cast<int>(reader.integer("a vertex index", 0, last));
    for (Point3& u : map.parameters[t]) u = {reader.number("u"), reader.number("v"), reader.number("w")};
  }
  if (tets == 0) reader.fail("no tet in the file");
  return map;
}

inline HexMap read_hex_map(const std::string& path) {
  TextReader reader(path);
  return parse_hex_map(reader);
}

inline void write_hex_map(const std::string& path, const HexMap& map) {
  TextWriter out(path);
  out << map.mesh.V.size() << '\n';
  for (const Point3& p : map.mesh.V) out << p[0] << ' ' << p[1] << ' ' << p[2] << '\n';
  out << map.mesh.T.size() << '\n';
  for (std::size_t t = 0; t < map.mesh.T.size(); ++t) {
    const Tet& tet = map.mesh.T[t];
    out << tet[0] << ' ' << tet[1] << ' ' << tet[2] << ' ' << tet[3];
    for (const Point3& u : map.parameters[t]) out << ' ' << u[0] << ' ' << u[1] << ' ' << u[2];
    out << '\n';
  }
  out.commit();
}

}  // namespace neurframe
