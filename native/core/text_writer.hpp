// Writing text files so that a reader sees the whole new file or the old one, never a part.
#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>
#include <string_view>

#include "core/errors.hpp"

namespace neurframe {

// A file under a temporary name beside `path`.  commit() flushes it to the disk and renames it to `path`;
// destruction without commit() removes it.  Raises StageError when the disk does not take it.
class TextWriter {
 public:
  explicit TextWriter(std::string path) : path_(std::move(path)) {
    temporary_ = path_ + ".tmp" + std::to_string(::getpid());
    // what has that name is left of a dead process, or a link that someone has put there to be written
    // through
    ::unlink(temporary_.c_str());
    file_ = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (file_ < 0) throw InputError(path_ + ": cannot be written: " + std::strerror(errno));
    buffer_.reserve(flush_size + 4096);
  }
  TextWriter(const TextWriter&) = delete;
  TextWriter& operator=(const TextWriter&) = delete;
  ~TextWriter() {
    if (file_ >= 0) ::close(file_);
    if (!committed_) ::unlink(temporary_.c_str());
  }

  TextWriter& operator<<(std::string_view text) {
    buffer_ += text;
    if (buffer_.size() >= flush_size) flush();
    return *this;
  }
  TextWriter& operator<<(const char* text) { return *this << std::string_view(text); }
  TextWriter& operator<<(char c) { return *this << std::string_view(&c, 1); }
  TextWriter& operator<<(std::int64_t value) { return write_number(value); }
  TextWriter& operator<<(int value) { return write_number(value); }
  TextWriter& operator<<(std::size_t value) { return write_number(value); }
  // the shortest decimal that reads back as the same double
  TextWriter& operator<<(double value) { return write_number(value); }

  void commit() {
    flush();
    require(::fsync(file_) == 0);
    const int closed = ::close(file_);
    file_ = -1;
    require(closed == 0);
    require(std::rename(temporary_.c_str(), path_.c_str()) == 0);
    committed_ = true;
  }

 private:
  static constexpr std::size_t flush_size = 1 << 20;

  template <class Number>
  TextWriter& write_number(Number value) {
    char digits[40];
    const char* end = std::to_chars(digits, digits + sizeof digits, value).ptr;
    return *this << std::string_view(digits, static_cast<std::size_t>(end - digits));
  }

  void flush() {
    const char* at = buffer_.data();
    std::size_t left = buffer_.size();
    while (left > 0) {
      const ssize_t wrote = ::write(file_, at, left);
      if (wrote < 0 && errno == EINTR) continue;
      require(wrote > 0);
      at += wrote;
      left -= static_cast<std::size_t>(wrote);
    }
    buffer_.clear();
  }

  void require(bool succeeded) const {
    if (!succeeded) throw StageError(path_ + ": cannot be written: " + std::strerror(errno));
  }

  std::string path_;
  std::string temporary_;
  std::string buffer_;
  int file_ = -1;
  bool committed_ = false;
};

}  // namespace neurframe
