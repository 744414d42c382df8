#include "cubecover/map_io.hpp"

#include <utility>

#include "core/text_reader.hpp"

namespace neurframe {

namespace {

// The text of the JSON array after the key, brackets and commas turned to blanks: the pairs as plain numbers.
std::string json_pairs(const std::string& path, const std::string& text) {
  const std::size_t key = text.find("\"edges\"");
  const std::size_t begin = key == std::string::npos ? key : text.find('[', key);
  if (begin == std::string::npos)
    throw InputError(path + ": no \"edges\" array in it; give features.json or text");
  std::string numbers;
  int depth = 0;
  for (std::size_t i = begin; i < text.size(); ++i) {
    depth += text[i] == '[' ? 1 : text[i] == ']' ? -1 : 0;
    if (depth == 0) return numbers;
    const bool separator = text[i] == '[' || text[i] == ']' || text[i] == ',';
    numbers += separator ? ' ' : text[i];
  }
  throw InputError(path + ": the \"edges\" array does not end");
}

}  // namespace

FieldMesh to_field_mesh(const TetMesh& tets, const std::vector<Frame>& frames,
                        std::vector<EdgeKey> features) {
  std::vector<Eigen::Vector3d> points;
  for (const Point3& p : tets.V) points.emplace_back(p[0], p[1], p[2]);
  std::vector<Eigen::Matrix3d> matrices(frames.size());
  for (std::size_t t = 0; t < frames.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const Point3& axis = at(frames[t], k);
      matrices[t].col(k) = Eigen::Vector3d(axis[0], axis[1], axis[2]);
    }
  }
  return make_field_mesh(std::move(points), tets.T, std::move(matrices), std::move(features));
}

std::vector<EdgeKey> read_features(const std::string& path, int vertices) {
  return parse_features(path, read_file(path), vertices);
}

std::vector<EdgeKey> parse_features(const std::string& name, std::string text, int vertices) {
  const bool json = text.find_first_not_of(" \t\r\n") != std::string::npos &&
                    text[text.find_first_not_of(" \t\r\n")] == '{';
  TextReader reader(name, json ? json_pairs(name, text) : std::move(text), '#');
  std::vector<EdgeKey> edges;
  while (!reader.at_end()) {
    const auto first = static_cast<int>(reader.integer("a vertex of a feature edge", 0, vertices - 1));
    const auto second = static_cast<int>(reader.integer("a vertex of a feature edge", 0, vertices - 1));
    edges.push_back(edge_key(first, second));
  }
  return edges;
}

HexMap to_hex_map(const FieldMesh& mesh, const ExactMap& exact) {
  HexMap map;
  for (const Eigen::Vector3d& point : mesh.points) map.mesh.V.push_back({point.x(), point.y(), point.z()});
  map.mesh.T = mesh.tets;
  for (const auto& corners : exact.parameters) {
    auto& parameters = map.parameters.emplace_back();
    for (int corner = 0; corner < 4; ++corner) {
      for (int axis = 0; axis < 3; ++axis) {
        at(at(parameters, corner), axis) = from_fixed(at(at(corners, corner), axis), exact.fraction_bits);
      }
    }
  }
  return map;
}

}  // namespace neurframe
