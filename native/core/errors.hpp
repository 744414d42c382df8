// The exit codes of the executables and the errors that lead to them.
//
//   std::runtime_error
//   └── ProgramError         a failure with an exit code
//       ├── InputError   2   usage, or a file that cannot be used (what, where, what is allowed)
//       └── StageError   3   the computation itself failed (what failed, what to try)
//
// ExitCode::incomplete (4) is not an error: the result was written, but is not complete or not valid.
#pragma once

#include <stdexcept>
#include <string>

namespace neurframe {

enum class ExitCode : int { done = 0, unusable_input = 2, failed = 3, incomplete = 4 };

class ProgramError : public std::runtime_error {
 public:
  ProgramError(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

class InputError : public ProgramError {
 public:
  explicit InputError(const std::string& message) : ProgramError(ExitCode::unusable_input, message) {}
};

class StageError : public ProgramError {
 public:
  explicit StageError(const std::string& message) : ProgramError(ExitCode::failed, message) {}
};

}  // namespace neurframe
