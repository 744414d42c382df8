// map.obj: a triangle mesh with one texture coordinate per corner, the integer-grid map of the quad half.
//
//   v x y z            vertices
//   vt u v             parameters, in cells
//   f a/p b/q c/r      triangles: vertex and parameter of each corner (a/p/n is read too)
//
// Optional comment lines, which other readers of OBJ ignore, give the exact transition functions:
//
//   # neurframe transition f g r tu tv
//
// for the edge that triangles f and g share (numbered from 0): u_g = R^r u_f + (tu, tv), R = 90 degrees
// counter- clockwise, r in 0..3, tu and tv integers.  Edges without such a line get theirs from the
// parameters.
#pragma once

#include <array>
#include <charconv>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/quarter_turn.hpp"
#include "core/text_reader.hpp"
#include "core/text_writer.hpp"
#include "core/triangle_mesh.hpp"

namespace neurframe {

struct GivenTransition2 {
  int f = 0;
  int g = 0;
  GridTransition2 transition;  // from the chart of f to that of g
};

struct QuadMap {
  TriangleMesh mesh;
  std::vector<std::array<Vector2<double>, 3>> parameters;  // per triangle and corner, in cells
  std::vector<GivenTransition2> transitions;
};

namespace detail {

inline constexpr std::int64_t most_obj_items = std::int64_t{1} << 29;

// An OBJ index (from 1, or negative from the end) as an index from 0.
inline int obj_index(const TextReader& reader, std::int64_t index, std::size_t count, const char* what) {
  const std::int64_t resolved = index > 0 ? index - 1 : static_cast<std::int64_t>(count) + index;
  if (index == 0 || resolved < 0 || resolved >= static_cast<std::int64_t>(count)) {
    reader.fail(std::string(what) + " " + std::to_string(index) + ", but " + std::to_string(count) +
                " are defined so far");
  }
  return static_cast<int>(resolved);
}

// One corner `a/p` or `a/p/n`: its vertex and its parameter.
inline std::array<int, 2> parse_corner(TextReader& reader, std::size_t vertices, std::size_t parameters) {
  if (reader.at_line_end()) reader.fail("a face with fewer than three corners; the map needs triangles");
  const std::string_view word = reader.word("a corner v/vt");
  const char* stop = word.data() + word.size();
  std::int64_t v = 0;
  std::int64_t vt = 0;
  auto result = std::from_chars(word.data(), stop, v);
  const bool slash = result.ec == std::errc{} && result.ptr != stop && *result.ptr == '/';
  if (slash) result = std::from_chars(result.ptr + 1, stop, vt);
  if (!slash || result.ec != std::errc{} || (result.ptr != stop && *result.ptr != '/')) {
    reader.fail("expected a corner v/vt (an integer-grid map has a vt at every corner), found " +
                TextReader::quoted(word));
  }
  return {obj_index(reader, v, vertices, "vertex"), obj_index(reader, vt, parameters, "texture coordinate")};
}

inline void parse_face(TextReader& reader, const std::vector<Vector2<double>>& parameters, QuadMap& map) {
  Triangle triangle{};
  std::array<Vector2<double>, 3> corners{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto [vertex, parameter] = parse_corner(reader, map.mesh.V.size(), parameters.size());
    triangle[i] = vertex;
    corners[i] = parameters[static_cast<std::size_t>(parameter)];
  }
  if (!reader.at_line_end()) reader.fail("a face with more than three corners; the map needs triangles");
  map.mesh.F.push_back(triangle);
  map.parameters.push_back(corners);
}

// A comment line: a transition, or anything else, which is skipped.
inline void parse_comment(TextReader& reader, QuadMap& map) {
  if (reader.at_line_end() || reader.word("a word") != "neurframe") return;
  if (reader.at_line_end() || reader.word("a word") != "transition") return;
  GivenTransition2 given;
  given.f = static_cast<int>(reader.integer("a triangle", 0, most_obj_items));
  given.g = static_cast<int>(reader.integer("a triangle", 0, most_obj_items));
  given.transition.rotation = QuarterTurn(static_cast<int>(reader.integer("quarter turns", 0, 3)));
  for (std::int64_t& t : given.transition.translation) {
    t = reader.integer("a translation", -(std::int64_t{1} << 40), std::int64_t{1} << 40);
  }
  map.transitions.push_back(given);
}

}  // namespace detail

// Raises InputError with the line of whatever is not understood, and for faces that are not triangles.
inline QuadMap parse_quad_map(TextReader& reader) {
  QuadMap map;
  std::vector<Vector2<double>> parameters;
  while (!reader.at_end()) {
    const std::string_view key = reader.word("a keyword");
    if (key == "v") {
      map.mesh.V.push_back({reader.number("x"), reader.number("y"), reader.number("z")});
    } else if (key == "vt") {
      parameters.push_back({reader.number("u"), reader.number("v")});
    } else if (key == "f") {
      detail::parse_face(reader, parameters, map);
    } else if (key == "#") {
      detail::parse_comment(reader, map);
    }
    reader.skip_line();
  }
  if (map.mesh.F.empty()) reader.fail("no triangle in the file");
  return map;
}

inline QuadMap read_quad_map(const std::string& path) {
  TextReader reader(path);
  return parse_quad_map(reader);
}

// Writes map.obj with one vt per corner.
inline void write_quad_map(const std::string& path, const QuadMap& map) {
  TextWriter out(path);
  out << "# neurframe integer-grid map\n";
  for (const Point3& p : map.mesh.V) out << "v " << p[0] << ' ' << p[1] << ' ' << p[2] << '\n';
  for (const auto& corners : map.parameters) {
    for (const Vector2<double>& uv : corners) out << "vt " << uv[0] << ' ' << uv[1] << '\n';
  }
  for (std::size_t f = 0; f < map.mesh.F.size(); ++f) {
    out << 'f';
    for (std::size_t i = 0; i < 3; ++i) out << ' ' << map.mesh.F[f][i] + 1 << '/' << 3 * f + i + 1;
    out << '\n';
  }
  for (const GivenTransition2& given : map.transitions) {
    const auto& [rotation, translation] = given.transition;
    out << "# neurframe transition " << given.f << ' ' << given.g << ' ' << rotation.turns() << ' '
        << translation[0] << ' ' << translation[1] << '\n';
  }
  out.commit();
}

// Writes polygons (quads) as OBJ.
inline void write_quads_obj(const std::string& path, const std::vector<Point3>& V,
                            const std::vector<std::array<int, 4>>& Q) {
  TextWriter out(path);
  for (const Point3& p : V) out << "v " << p[0] << ' ' << p[1] << ' ' << p[2] << '\n';
  for (const std::array<int, 4>& quad : Q) {
    out << 'f';
    for (const int v : quad) out << ' ' << v + 1;
    out << '\n';
  }
  out.commit();
}

}  // namespace neurframe
