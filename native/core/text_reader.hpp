// Reading whitespace-separated text files fast, with the file and line in every complaint.
#pragma once

#include <sys/stat.h>

#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <string_view>

#include "core/errors.hpp"

namespace neurframe {

// No text of this size has more vertices, at six bytes each, than an int can number.
inline constexpr std::uint64_t most_file_bytes = std::uint64_t{1} << 33;

// The whole file.  Raises InputError when it cannot be opened or read, or is too large.
inline std::string read_file(const std::string& path) {
  const auto refuse_if_larger = [&](std::uint64_t bytes) {
    if (bytes <= most_file_bytes) return;
    throw InputError(path + ": more than " + std::to_string(most_file_bytes >> 30) +
                     " GiB, which is no mesh");
  };
  struct stat status{};
  if (::stat(path.c_str(), &status) == 0) refuse_if_larger(static_cast<std::uint64_t>(status.st_size));
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), &std::fclose);
  if (!file) throw InputError(path + ": cannot be opened");
  std::string text;
  char block[1 << 16];
  while (const std::size_t got = std::fread(block, 1, sizeof block, file.get())) {
    text.append(block, got);
    refuse_if_larger(text.size());  // a device has no size
  }
  if (std::ferror(file.get()) != 0) throw InputError(path + ": cannot be read");
  return text;
}

class TextReader {
 public:
  // comment: the character that starts a comment up to the end of the line, 0 for none
  explicit TextReader(const std::string& path, char comment = 0)
      : TextReader(path, read_file(path), comment) {}
  TextReader(std::string name, std::string text, char comment)
      : name_(std::move(name)), text_(std::move(text)), comment_(comment) {
    at_ = text_.data();
    end_ = at_ + text_.size();
  }
  // at_ and end_ point into text_
  TextReader(const TextReader&) = delete;
  TextReader& operator=(const TextReader&) = delete;

  bool at_end() {
    skip_space();
    return at_ == end_;
  }

  // The next word, which must exist; `what` names it in the complaint.
  std::string_view word(const char* what) {
    skip_space();
    const char* start = at_;
    while (at_ != end_ && !is_space(*at_)) ++at_;
    if (start == at_) fail(std::string("expected ") + what + ", found the end of the file");
    return {start, static_cast<std::size_t>(at_ - start)};
  }

  void expect(std::string_view wanted) {
    const std::string_view found = word(std::string(wanted).c_str());
    if (found != wanted) fail("expected '" + std::string(wanted) + "', found " + quoted(found));
  }

  // An integer in [lowest, highest].
  std::int64_t integer(const char* what, std::int64_t lowest, std::int64_t highest) {
    const std::string_view found = word(what);
    std::int64_t value = 0;
    const auto [stop, error] = std::from_chars(found.data(), found.data() + found.size(), value);
    if (error != std::errc{} || stop != found.data() + found.size() || value < lowest || value > highest) {
      fail(std::string("expected ") + what + " (an integer from " + std::to_string(lowest) + " to " +
           std::to_string(highest) + "), found " + quoted(found));
    }
    return value;
  }

  // A count of items of which each takes at least `least_bytes` of text: a count that the rest of the file
  // cannot hold is refused before memory is asked for.
  std::size_t count(const char* what, std::size_t least_bytes) {
    const auto value = static_cast<std::uint64_t>(integer(what, 0, std::int64_t{1} << 40));
    const auto left = static_cast<std::uint64_t>(end_ - at_);
    if (value > left / least_bytes) {
      fail("expected " + std::to_string(value) + " items (" + what + "), but only " + std::to_string(left) +
           " bytes are left in the file");
    }
    return static_cast<std::size_t>(value);
  }

  // A finite number: a decimal, or a rational a/b.
  double number(const char* what) {
    const std::string_view found = word(what);
    const char* const stop = found.data() + found.size();
    auto [value, rest] = decimal(found.data() + (found[0] == '+' ? 1 : 0), stop);
    if (rest != stop && *rest == '/') {
      const Decimal denominator = decimal(rest + 1, stop);
      value = std::isfinite(denominator.value) ? value / denominator.value : NAN;  // 1/inf is no zero
      rest = denominator.rest;
    }
    if (rest != stop || !std::isfinite(value)) {
      fail(std::string("expected ") + what + " (a finite number), found " + quoted(found));
    }
    return value;
  }

  // True when no word is left on the current line.
  bool at_line_end() {
    while (at_ != end_ && *at_ != '\n' && is_space(*at_)) ++at_;
    return at_ == end_ || *at_ == '\n';
  }

  void skip_line() {
    while (at_ != end_ && *at_ != '\n') ++at_;
  }

  std::string place() const {
    std::int64_t line = 1;
    for (const char* c = text_.data(); c != at_; ++c) line += *c == '\n';
    return name_ + ":" + std::to_string(line);
  }

  [[noreturn]] void fail(const std::string& message) const { throw InputError(place() + ": " + message); }

  // A word of the file for a complaint, cut off when it is long.
  static std::string quoted(std::string_view word) {
    const bool cut = word.size() > 40;
    // appended: GCC 12 warns wrongly of overlapping memory where a literal is put before a temporary
    return std::string(1, '\'').append(cut ? word.substr(0, 37) : word).append(cut ? "...'" : "'");
  }

 private:
  static bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

  void skip_space() {
    while (at_ != end_ && (is_space(*at_) || (comment_ != 0 && *at_ == comment_))) {
      if (comment_ != 0 && *at_ == comment_) {
        while (at_ != end_ && *at_ != '\n') ++at_;
      } else {
        ++at_;
      }
    }
  }

  struct Decimal {
    double value;      // nan where there is no number, infinite beyond the largest double
    const char* rest;  // what follows it
  };
  static Decimal decimal(const char* begin, const char* stop) {
    double value = NAN;
    const auto [rest, error] = std::from_chars(begin, stop, value);
    if (error == std::errc::result_out_of_range) {
      // from_chars does not tell 1e-999, which is zero, from 1e999; strtod does (in the locale "C" of a
      // program)
      value = std::strtod(std::string(begin, rest).c_str(), nullptr);
    }
    return {value, rest};
  }

  std::string name_;
  std::string text_;
  char comment_;
  const char* at_ = nullptr;
  const char* end_ = nullptr;
};

}  // namespace neurframe
