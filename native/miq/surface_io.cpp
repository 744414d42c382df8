#include "miq/surface_io.hpp"

#include <charconv>
#include <cmath>

#include "core/text_reader.hpp"
#include "core/text_writer.hpp"

namespace neurframe {
namespace {

Triangle read_triangle(TextReader& reader, std::size_t vertices) {
  Triangle triangle{};
  for (int& corner : triangle) {
    if (reader.at_line_end()) reader.fail("a face with fewer than three corners");
    const std::string_view word = reader.word("a corner");
    int index = 0;
    const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), index);
    if (error != std::errc{} || (stop != word.data() + word.size() && *stop != '/')) {
      reader.fail("expected a corner, found " + TextReader::quoted(word));
    }
    const long resolved = index > 0 ? index - 1L : static_cast<long>(vertices) + index;
    if (index == 0 || resolved < 0 || resolved >= static_cast<long>(vertices)) {
      reader.fail("vertex " + std::to_string(index) + ", but " + std::to_string(vertices) +
                  " are defined so far");
    }
    corner = static_cast<int>(resolved);
  }
  if (!reader.at_line_end())
    reader.fail("a face with more than three corners; triangulate the surface first");
  return triangle;
}

}  // namespace

TriangleMesh parse_surface_obj(TextReader& reader) {
  TriangleMesh mesh;
  while (!reader.at_end()) {
    const std::string_view key = reader.word("a keyword");
    if (key == "v") mesh.V.push_back({reader.number("x"), reader.number("y"), reader.number("z")});
    if (key == "f") mesh.F.push_back(read_triangle(reader, mesh.V.size()));
    reader.skip_line();
  }
  if (mesh.F.empty()) reader.fail("no triangle in the file");
  check_triangles(mesh.F, mesh.V.size());
  return mesh;
}

TriangleMesh read_surface_obj(const std::string& path) {
  TextReader reader(path);
  return parse_surface_obj(reader);
}

std::vector<std::array<double, 6>> parse_crosses(TextReader& reader, bool rosy, const TriangleMesh& mesh) {
  if (rosy) {
    const auto count = static_cast<int64_t>(mesh.F.size());
    reader.integer("the number of triangles of the surface", count, count);
    reader.integer("the degree 4", 4, 4);
  }
  std::vector<std::array<double, 6>> crosses(mesh.F.size());
  for (auto& cross : crosses) {
    for (std::size_t k = 0; k < (rosy ? 3u : 6u); ++k) cross[k] = reader.number("a component of a cross");
  }
  if (!reader.at_end()) {
    reader.fail("more crosses than the " + std::to_string(mesh.F.size()) + " triangles of the surface");
  }
  return crosses;
}

std::vector<std::array<double, 6>> read_crosses(const std::string& path, const TriangleMesh& mesh) {
  TextReader reader(path, '#');
  return parse_crosses(reader, path.ends_with(".rosy"), mesh);
}

std::vector<std::pair<int, int>> parse_vertex_pairs(TextReader& reader, std::size_t vertices) {
  std::vector<std::pair<int, int>> pairs;
  const auto last = static_cast<int64_t>(vertices) - 1;
  while (!reader.at_end()) {
    const auto a = static_cast<int>(reader.integer("a vertex", 0, last));
    pairs.emplace_back(a, static_cast<int>(reader.integer("a vertex", 0, last)));
  }
  return pairs;
}

std::vector<std::pair<int, int>> read_vertex_pairs(const std::string& path, std::size_t vertices) {
  TextReader reader(path, '#');
  return parse_vertex_pairs(reader, vertices);
}

std::vector<double> parse_sizing(TextReader& reader, std::size_t vertices) {
  std::vector<double> sizing;
  while (!reader.at_end()) {
    sizing.push_back(reader.number("a factor"));
    if (!(sizing.back() > 0)) reader.fail("a factor must be positive");
  }
  if (sizing.size() != vertices) {
    reader.fail("expected " + std::to_string(vertices) + " factors, one per vertex, found " +
                std::to_string(sizing.size()));
  }
  return sizing;
}

std::vector<double> read_sizing(const std::string& path, std::size_t vertices) {
  TextReader reader(path, '#');
  return parse_sizing(reader, vertices);
}

void write_integers(const std::string& path, const std::vector<int>& values) {
  TextWriter out(path);
  for (const int value : values) out << value << '\n';
  out.commit();
}

double diagonal(const std::vector<Point3>& positions) {
  double squared = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    double low = INFINITY;
    double high = -INFINITY;
    for (const Point3& p : positions) {
      low = std::min(low, p[k]);
      high = std::max(high, p[k]);
    }
    squared += (high - low) * (high - low);
  }
  return std::sqrt(squared);
}

}  // namespace neurframe
