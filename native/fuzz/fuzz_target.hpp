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

// One input holds all files of a program: they are taken off it one after the other.
class Parts {
 public:
  Parts(const std::uint8_t* data, std::size_t size) : rest_(reinterpret_cast<const char*>(data), size) {}

  // The text up to the next separator.
  std::string next() {
    const std::size_t end = rest_.find(part_separator);
    const std::string part(rest_.substr(0, end));
    rest_ = end == rest_.npos ? std::string_view{} : rest_.substr(end + part_separator.size());
    return part;
  }

  TextReader reader(const char* name, char comment) { return {name, next(), comment}; }

 private:
  std::string_view rest_;
};

}  // namespace neurframe

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
