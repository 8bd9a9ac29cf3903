// Minimal JSON text for `--json`: objects, arrays, numbers, strings, in the order they are written. Called by
// cli_*.cpp. Invariant: numbers round-trip (shortest form that reads back to the same double); non-finite numbers
// become null.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace talus::cli {

/// Builds one JSON value; begin/end calls must match, `key` is ignored (empty) inside arrays.
class Json {
 public:
  Json& begin_object(std::string_view key = {}) { return open(key, '{'); }
  Json& end_object() { return close('}'); }
  Json& begin_array(std::string_view key = {}) { return open(key, '['); }
  Json& end_array() { return close(']'); }
  Json& add(std::string_view key, double value);
  Json& add(std::string_view key, std::int64_t value);
  Json& add(std::string_view key, int value) { return add(key, static_cast<std::int64_t>(value)); }
  Json& add(std::string_view key, bool value);
  Json& add(std::string_view key, std::string_view value);
  Json& add(std::string_view key, const char* value) { return add(key, std::string_view(value)); }
  Json& add(std::string_view key, const std::string& value) { return add(key, std::string_view(value)); }
  const std::string& text() const noexcept { return text_; }

 private:
  Json& open(std::string_view key, char bracket);
  Json& close(char bracket);
  void start(std::string_view key);
  std::string text_;
  int depth_ = 0;
};

}  // namespace talus::cli
