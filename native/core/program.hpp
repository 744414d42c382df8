// The one boundary of every executable: command line in, exit code out, every failure one line on stderr.
#pragma once

#include <cstdio>
#include <exception>
#include <functional>
#include <new>
#include <string>
#include <vector>

#include "core/arguments.hpp"
#include "core/errors.hpp"
#include "core/json.hpp"

#ifndef NEURFRAME_VERSION
#define NEURFRAME_VERSION "0.1.0"
#endif

namespace neurframe {

// One line `progress FRACTION TEXT` on stderr, which the wrapper turns into a progress bar.
inline void report_progress(double fraction, const std::string& text) {
  std::fprintf(stderr, "progress %.3f %s\n", fraction, text.c_str());
}

// What a program does with its arguments; it fills the statistics and returns done or incomplete.
using ProgramBody = std::function<ExitCode(const Arguments& arguments, Json& statistics)>;

inline CommandLine with_common_options(CommandLine command) {
  command.options.push_back({"--threads", "", "N", "worker threads, 1 to 1024 (default 1)"});
  command.options.push_back({"--help", "", "", "print this text"});
  command.options.push_back({"--version", "", "", "print the version"});
  return command;
}

inline bool answered_question(const CommandLine& command, const std::vector<std::string>& words) {
  for (const std::string& word : words) {
    if (word == "--help") std::fputs(help_text(command).c_str(), stdout);
    if (word == "--version") std::printf("%s %s\n", command.program.c_str(), NEURFRAME_VERSION);
    if (word == "--help" || word == "--version") return true;
  }
  return false;
}

// The message without control characters, which words of a file and file names may bring along.
inline std::string in_one_line(std::string message) {
  for (char& c : message) c = static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? '?' : c;
  return message;
}

inline int worker_threads(const Arguments& arguments) {
  return arguments.integer("--threads", 1, 1, 1024);
}

// Runs `body` and returns the exit status for main().  The statistics go to stdout as one JSON object, also
// when the result is incomplete; a failure prints `PROGRAM: error: ...` on stderr and nothing on stdout.
inline int run_program(const CommandLine& bare, int argc, char** argv, const ProgramBody& body) {
  const CommandLine command = with_common_options(bare);
  const auto fail = [&](ExitCode code, const std::string& message) {
    std::fprintf(stderr, "%s: error: %s\n", command.program.c_str(), in_one_line(message).c_str());
    return static_cast<int>(code);
  };
  try {
    const std::vector<std::string> words(argv + 1, argv + argc);
    if (answered_question(command, words)) return 0;
    Json statistics;
    const ExitCode code = body(parse_arguments(command, words), statistics);
    std::printf("%s\n", statistics.dump().c_str());
    if (std::fflush(stdout) != 0) return fail(ExitCode::failed, "cannot write the statistics to stdout");
    return static_cast<int>(code);
  } catch (const ProgramError& error) {
    return fail(error.code(), error.what());
  } catch (const std::bad_alloc&) {
    return fail(ExitCode::failed, "out of memory; a smaller mesh or a coarser grid needs less");
  } catch (const std::exception& error) {
    return fail(ExitCode::failed, std::string("internal error: ") + error.what());
  }
}

}  // namespace neurframe
