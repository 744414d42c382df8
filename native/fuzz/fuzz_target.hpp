// What the libFuzzer harnesses share: an input ends well, or in one of our own errors with a message of one
// line. Everything else (another exception, a report of a sanitizer, too much time or memory) is a finding.
#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

#include "core/errors.hpp"
#include "core/text_reader.hpp"

namespace neurframe {

inline std::string as_text(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

// Calls body(); the value is what libFuzzer wants to be returned.
template <class Body>
int end_as_documented(const Body& body) {
  try {
    body();
  } catch (const ProgramError& error) {
    const std::string_view message = error.what();
    if (message.empty() || message.find('\n') != message.npos) {
      std::fprintf(stderr, "not a message of one line: '%s'\n", error.what());
      std::abort();
    }
  }
  return 0;
}

inline constexpr std::string_view part_separator = "\n%%\n";

// The text up to the next separator, which is taken off `rest`: one input holds the files of a program.
inline std::string next_part(std::string_view& rest) {
  const std::size_t end = rest.find(part_separator);
  const std::string part(rest.substr(0, end));
  rest = end == rest.npos ? std::string_view{} : rest.substr(end + part_separator.size());
  return part;
}

}  // namespace neurframe

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
