// The command line of an executable: what it takes (CommandLine), and what was given (Arguments).
#pragma once

#include <charconv>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/errors.hpp"

namespace neurframe {

struct Option {
  std::string name;         // "--threads"
  std::string short_name;   // "-j", or empty
  std::string placeholder;  // "N"; empty for a flag that takes no value
  std::string help;
  bool required = false;
};

struct CommandLine {
  std::string program;
  std::string summary;
  std::vector<std::string> positionals;  // placeholders, all of them required: {"MAP.obj"}
  std::vector<Option> options;           // --threads, --help and --version are added by run_program
};

class Arguments {
 public:
  bool given(const std::string& name) const { return values_.count(name) != 0; }
  const std::string& positional(std::size_t index) const { return positionals_.at(index); }
  std::string text(const std::string& name, const std::string& fallback = "") const {
    const auto found = values_.find(name);
    return found == values_.end() ? fallback : found->second;
  }

  // Raises InputError unless the value is an integer (a number) in [lowest, highest].
  int integer(const std::string& name, int fallback, int lowest, int highest) const {
    return parsed<int>(name, fallback, lowest, highest, "an integer");
  }
  double number(const std::string& name, double fallback, double lowest, double highest) const {
    return parsed<double>(name, fallback, lowest, highest, "a number");
  }

  friend Arguments parse_arguments(const CommandLine& command, const std::vector<std::string>& words);

 private:
  template <class T>
  T parsed(const std::string& name, T fallback, T lowest, T highest, const char* kind) const {
    const auto found = values_.find(name);
    if (found == values_.end()) return fallback;
    const std::string& word = found->second;
    T value{};
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    const bool whole = error == std::errc{} && end == word.data() + word.size();
    if (!whole || !(value >= lowest && value <= highest)) {
      throw InputError(name + ": expected " + kind + " from " + std::to_string(lowest) + " to " +
                       std::to_string(highest) + ", found '" + word + "'");
    }
    return value;
  }

  std::map<std::string, std::string> values_;
  std::vector<std::string> positionals_;
};

inline const Option& find_option(const CommandLine& command, const std::string& word) {
  for (const Option& option : command.options) {
    if (word == option.name || (!option.short_name.empty() && word == option.short_name)) return option;
  }
  throw InputError("unknown option '" + word + "'; --help lists what there is");
}

inline void require_complete(const CommandLine& command, const Arguments& arguments,
                             std::size_t positionals) {
  if (positionals < command.positionals.size()) {
    throw InputError("the argument " + command.positionals[positionals] + " is missing; --help explains it");
  }
  for (const Option& option : command.options) {
    if (option.required && !arguments.given(option.name)) {
      throw InputError("the option " + option.name + " " + option.placeholder + " is missing");
    }
  }
}

// Raises InputError for unknown or repeated options, missing values, and missing or surplus arguments.
inline Arguments parse_arguments(const CommandLine& command, const std::vector<std::string>& words) {
  Arguments arguments;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const bool is_option = words[i].size() > 1 && words[i][0] == '-';
    if (!is_option) {
      if (arguments.positionals_.size() == command.positionals.size()) {
        throw InputError("surplus argument '" + words[i] + "'");
      }
      arguments.positionals_.push_back(words[i]);
      continue;
    }
    const Option& option = find_option(command, words[i]);
    const bool is_flag = option.placeholder.empty();
    if (!is_flag && i + 1 == words.size()) {
      throw InputError("the option " + option.name + " needs a value (" + option.placeholder + ")");
    }
    if (!arguments.values_.emplace(option.name, is_flag ? "" : words[++i]).second) {
      throw InputError("the option " + option.name + " is given twice");
    }
  }
  require_complete(command, arguments, arguments.positionals_.size());
  return arguments;
}

inline std::string help_text(const CommandLine& command) {
  std::string text = "usage: " + command.program;
  for (const std::string& positional : command.positionals) text += " " + positional;
  text += " [options]\n\n" + command.summary + "\n\noptions:\n";
  for (const Option& option : command.options) {
    std::string names = option.short_name.empty() ? option.name : option.short_name + ", " + option.name;
    if (!option.placeholder.empty()) names += " " + option.placeholder;
    names.resize(names.size() < 26 ? 26 : names.size() + 1, ' ');
    text += "  " + names + option.help + (option.required ? " (required)\n" : "\n");
  }
  return text + "\nexit status: 0 done, 2 unusable input, 3 failed, 4 written but not complete\n";
}

}  // namespace neurframe
