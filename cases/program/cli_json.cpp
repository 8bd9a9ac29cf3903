// JSON text; see cli_json.hpp.
#include "cases/program/cli_json.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/io/summary.hpp"

namespace talus::cli {

void Json::start(std::string_view key) {
  if (depth_ > 0) {
    const char last = text_.back();
    if (last != '{' && last != '[') text_ += ',';
    text_ += '\n';
    text_.append(static_cast<std::size_t>(2 * depth_), ' ');
  }
  if (!key.empty()) {
    text_ += json_string(std::string(key)) + ": ";
  }
}

Json& Json::open(std::string_view key, char bracket) {
  start(key);
  text_ += bracket;
  ++depth_;
  return *this;
}

Json& Json::close(char bracket) {
  --depth_;
  const char last = text_.back();
  if (last != '{' && last != '[') {
    text_ += '\n';
    text_.append(static_cast<std::size_t>(2 * depth_), ' ');
  }
  text_ += bracket;
  return *this;
}

Json& Json::add(std::string_view key, double value) {
  start(key);
  text_ += std::isfinite(value) ? fmt::format("{}", value) : "null";
  return *this;
}

Json& Json::add(std::string_view key, std::int64_t value) {
  start(key);
  text_ += fmt::format("{}", value);
  return *this;
}

Json& Json::add(std::string_view key, bool value) {
  start(key);
  text_ += value ? "true" : "false";
  return *this;
}

Json& Json::add(std::string_view key, std::string_view value) {
  start(key);
  text_ += json_string(std::string(value));
  return *this;
}

}  // namespace talus::cli
