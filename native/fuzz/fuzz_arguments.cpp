// The command line of the executables, one word a line.
#include "core/arguments.hpp"
#include "fuzz/fuzz_target.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace neurframe;
  const CommandLine command{"program",
                            "summary",
                            {"INPUT"},
                            {{"--output", "-o", "OUT", "", true},
                             {"--count", "", "N", ""},
                             {"--factor", "", "X", ""},
                             {"--flag", "", "", ""}}};
  return end_as_documented([&] {
    std::vector<std::string> words(1);
    for (const char c : as_text(data, size)) {
      if (c == '\n') words.emplace_back();
      if (c != '\n') words.back() += c;
    }
    const Arguments arguments = parse_arguments(command, words);
    const int count = arguments.integer("--count", 1, 1, 1024);
    const double factor = arguments.number("--factor", 1, 0, 1e6);
    if (count < 1 || count > 1024 || !(factor >= 0 && factor <= 1e6)) std::abort();
  });
}
