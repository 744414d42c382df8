#include "cubecover/features_io.hpp"

#include <string_view>

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

std::vector<EdgeKey> read_features(const std::string& path, int vertices) {
  std::string text = read_file(path);
  const bool json = text.find_first_not_of(" \t\r\n") != std::string::npos &&
                    text[text.find_first_not_of(" \t\r\n")] == '{';
  TextReader reader(path, json ? json_pairs(path, text) : std::move(text), '#');
  std::vector<EdgeKey> edges;
  while (!reader.at_end()) {
    const auto first = static_cast<int>(reader.integer("a vertex of a feature edge", 0, vertices - 1));
    const auto second = static_cast<int>(reader.integer("a vertex of a feature edge", 0, vertices - 1));
    edges.push_back(edge_key(first, second));
  }
  return edges;
}

}  // namespace neurframe
