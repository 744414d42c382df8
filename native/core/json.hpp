// A JSON value that is built once and printed: the statistics that every executable writes on stdout.
#pragma once

#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace neurframe {

class Json {
 public:
  using Array = std::vector<Json>;
  using Object = std::vector<std::pair<std::string, Json>>;

  Json() : value_(Object{}) {}
  Json(bool value) : value_(value) {}
  Json(int value) : value_(std::int64_t{value}) {}
  Json(std::int64_t value) : value_(value) {}
  Json(std::size_t value) : value_(static_cast<std::int64_t>(value)) {}
  Json(double value) : value_(value) {}
  Json(const char* value) : value_(std::string(value)) {}
  Json(std::string value) : value_(std::move(value)) {}
  template <class T>
  Json(const std::vector<T>& values) : value_(Array(values.begin(), values.end())) {}

  // The member `key` of an object, added when it is missing.
  Json& operator[](std::string_view key) {
    Object& members = std::get<Object>(value_);
    for (auto& [name, value] : members) {
      if (name == key) return value;
    }
    return members.emplace_back(std::string(key), Json()).second;
  }

  // The value of an integer, `fallback` for anything else.
  std::int64_t integer_or(std::int64_t fallback) const {
    const std::int64_t* integer = std::get_if<std::int64_t>(&value_);
    return integer != nullptr ? *integer : fallback;
  }

  // One line of JSON; numbers that JSON cannot hold (nan, inf) become null.
  std::string dump() const {
    std::string text;
    append_to(text);
    return text;
  }

 private:
  void append_to(std::string& text) const {
    if (const bool* flag = std::get_if<bool>(&value_)) {
      text += *flag ? "true" : "false";
    } else if (const std::int64_t* integer = std::get_if<std::int64_t>(&value_)) {
      text += std::to_string(*integer);
    } else if (const double* number = std::get_if<double>(&value_)) {
      append_number(*number, text);
    } else if (const std::string* string = std::get_if<std::string>(&value_)) {
      append_string(*string, text);
    } else if (const Array* array = std::get_if<Array>(&value_)) {
      append_array(*array, text);
    } else {
      append_object(std::get<Object>(value_), text);
    }
  }

  static void append_number(double number, std::string& text) {
    char buffer[32];
    const auto end = std::to_chars(buffer, buffer + sizeof buffer, number).ptr;
    text += std::isfinite(number) ? std::string_view(buffer, static_cast<std::size_t>(end - buffer)) : "null";
  }

  static void append_string(const std::string& string, std::string& text) {
    text += '"';
    for (const char c : string) {
      if (c == '"' || c == '\\') {
        text += {'\\', c};
      } else if (static_cast<unsigned char>(c) < 0x20) {
        char escaped[8];
        std::snprintf(escaped, sizeof escaped, "\\u%04x", static_cast<unsigned>(c));
        text += escaped;
      } else {
        text += c;
      }
    }
    text += '"';
  }

  static void append_array(const Array& array, std::string& text) {
    text += '[';
    for (std::size_t i = 0; i < array.size(); ++i) {
      if (i != 0) text += ", ";
      array[i].append_to(text);
    }
    text += ']';
  }

  static void append_object(const Object& object, std::string& text) {
    text += '{';
    for (std::size_t i = 0; i < object.size(); ++i) {
      if (i != 0) text += ", ";
      append_string(object[i].first, text);
      text += ": ";
      object[i].second.append_to(text);
    }
    text += '}';
  }

  std::variant<bool, std::int64_t, double, std::string, Array, Object> value_;
};

}  // namespace neurframe
