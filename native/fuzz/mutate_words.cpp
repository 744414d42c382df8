// Mutation that knows words: half of all inputs get a word replaced, by another word of the same input or by
// a small number, so that they stay readable and reach what lies behind the reader; the others are
// libFuzzer's own.
#include <algorithm>
#include <cstdint>
#include <random>
#include <string>
#include <string_view>
#include <vector>

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned int seed);

namespace {

using Random = std::minstd_rand;

std::size_t below(Random& random, std::size_t count) {
  return std::uniform_int_distribution<std::size_t>(0, count - 1)(random);
}

std::vector<std::string_view> words_of(std::string_view text) {
  constexpr std::string_view separators = " \t\r\n/,[]";
  std::vector<std::string_view> words;
  for (std::size_t begin = text.find_first_not_of(separators); begin != text.npos;) {
    const std::size_t end = std::min(text.find_first_of(separators, begin), text.size());
    words.push_back(text.substr(begin, end - begin));
    begin = text.find_first_not_of(separators, end);
  }
  return words;
}

std::string new_word(Random& random, const std::vector<std::string_view>& words) {
  constexpr std::string_view fractions[] = {".5", ".25", ".999", "e3", "e6", "e-9"};
  if (below(random, 2) == 0) return std::string(words[below(random, words.size())]);
  std::string number = std::to_string(static_cast<int>(below(random, 14)) - 3);
  if (below(random, 3) == 0) number += fractions[below(random, std::size(fractions))];
  return number;
}

}  // namespace

std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                    unsigned int seed) {
  Random random(seed);
  std::string text(reinterpret_cast<const char*>(data), size);
  const std::vector<std::string_view> words = words_of(text);
  if (words.empty() || below(random, 2) == 0) return LLVMFuzzerMutate(data, size, max_size);
  const std::string_view old = words[below(random, words.size())];
  const auto place = static_cast<std::size_t>(old.data() - text.data());
  const std::string replacement = new_word(random, words);
  text.replace(place, old.size(), replacement);  // the views into it are no longer used
  if (text.size() > max_size) return LLVMFuzzerMutate(data, size, max_size);
  std::copy(text.begin(), text.end(), data);
  return text.size();
}
