// Lines, fields and numbers of particle files. Who calls it: core/io/particle_*.cpp only. Invariant: numbers go through
// std::from_chars: independent of the locale, correctly rounded, and fast enough for half a million rows in a fraction
// of a second.
#pragma once

#include <fmt/format.h>

#include <charconv>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.hpp"
#include "core/base/text.hpp"

namespace talus::particle_text {

[[noreturn]] inline void fail(const std::string& name, std::int64_t row, const std::string& what,
                              const std::string& cure) {
  throw Error(ErrorCode::scene, what, fmt::format("{}:{}", name, row), cure);
}

inline bool is_space(char c) noexcept { return c == ' ' || c == '\t' || c == '\r'; }

inline std::string_view trim(std::string_view s) noexcept {
  while (!s.empty() && is_space(s.front())) s.remove_prefix(1);
  while (!s.empty() && is_space(s.back())) s.remove_suffix(1);
  return s;
}

/// Lines of a text with their numbers, without blanks around them; line ends of any system.
class Lines {
 public:
  explicit Lines(std::string_view text)
      : rest_(text),
        end_(text.find('\n') == std::string_view::npos && text.find('\r') != std::string_view::npos ? '\r' : '\n') {}
  bool next(std::string_view& line) noexcept {
    if (rest_.empty()) return false;
    const std::size_t end = rest_.find(end_);
    line = trim(raw_ = rest_.substr(0, end));
    rest_ = end == std::string_view::npos ? std::string_view{} : rest_.substr(end + 1);
    ++number_;
    return true;
  }
  /// The last line as it stands: separators at its ends may be blanks.
  std::string_view raw() const noexcept {
    std::string_view line = raw_;
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    return line;
  }
  std::int64_t number() const noexcept { return number_; }

 private:
  std::string_view rest_, raw_;
  char end_;
  std::int64_t number_ = 0;
};

enum class NumberState { good, syntax, range };

template <class T>
NumberState read_number(std::string_view s, T& value) noexcept {
  if (s.starts_with('+')) s.remove_prefix(1);
  const auto [end, error] = std::from_chars(s.data(), s.data() + s.size(), value);
  if (s.empty() || error == std::errc::invalid_argument || end != s.data() + s.size()) return NumberState::syntax;
  return error == std::errc() ? NumberState::good : NumberState::range;
}

template <class T>
bool is_number(std::string_view s, T& value) noexcept {
  return read_number(s, value) == NumberState::good;
}

/// Fields between blanks.
inline void split_blanks(std::string_view line, std::vector<std::string_view>& fields) {
  fields.clear();
  std::size_t i = 0;
  while (i < line.size()) {
    while (i < line.size() && is_space(line[i])) ++i;
    const std::size_t begin = i;
    while (i < line.size() && !is_space(line[i])) ++i;
    if (i > begin) fields.push_back(line.substr(begin, i - begin));
  }
}

}  // namespace talus::particle_text
