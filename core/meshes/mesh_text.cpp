// Numbers, words and lines of mesh files. Who calls it: core/io/mesh_*.cpp. Invariants: see the header.
#include "core/meshes/mesh_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/base/error.hpp"
#include "core/base/text.hpp"

namespace talus::mesh_io {
namespace {

constexpr std::size_t k_longest_number = 400;  // characters; 1e-308 written out needs 310

bool is_digit(char c) noexcept { return c >= '0' && c <= '9'; }
char lower_case(char c) noexcept { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

/// Length of "[+-]digits" at the start of s, or 0.
std::size_t exponent_length(std::string_view s) noexcept {
  std::size_t i = !s.empty() && (s[0] == '+' || s[0] == '-') ? 1 : 0;
  const std::size_t begin = i;
  while (i < s.size() && is_digit(s[i])) ++i;
  return i > begin ? i : 0;
}

/// Length of the digits and the point at the start of s, or 0 without a digit.
std::size_t mantissa_length(std::string_view s, int& significant) noexcept {
  std::size_t i = 0;
  int all = 0, leading = 0;
  bool point = false;
  for (; i < s.size() && (is_digit(s[i]) || (s[i] == '.' && !point)); ++i) {
    if (s[i] == '.') {
      point = true;
      continue;
    }
    if (all == leading && s[i] == '0') ++leading;
    ++all;
  }
  significant = all - leading;
  return all > 0 ? i : 0;
}

}  // namespace

void fail(const std::string& name, std::int64_t line, const std::string& what, const std::string& cure) {
  throw Error(ErrorCode::scene, what, line > 0 ? fmt::format("mesh {}:{}", name, line) : "mesh " + name, cure);
}

std::string quoted(std::string_view text) { return "\"" + shown(text, 40) + "\""; }

bool same_word(std::string_view text, std::string_view lower) noexcept {
  return text.size() == lower.size() &&
         std::equal(text.begin(), text.end(), lower.begin(), [](char a, char b) { return lower_case(a) == b; });
}

bool is_blank(char c) noexcept { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }

bool parse_number(std::string_view text, double& value, int* digits) noexcept {
  if (text.empty() || text.size() > k_longest_number) return false;
  const bool minus = text[0] == '-';
  std::string_view s = text;
  if (minus || s[0] == '+') s.remove_prefix(1);
  int significant = 0;
  const std::size_t mantissa = mantissa_length(s, significant);
  if (mantissa == 0) return false;
  std::string_view exponent = s.substr(mantissa);
  if (!exponent.empty()) {
    const char letter = lower_case(exponent[0]);
    const bool lettered = letter == 'e' || letter == 'd' || letter == 'q';
    if (lettered) exponent.remove_prefix(1);
    if (exponent.empty() || exponent_length(exponent) != exponent.size()) return false;
    if (!lettered && (is_digit(exponent[0]) || exponent.size() != 4)) return false;
  }
  char buffer[k_longest_number + 2];
  char* end = std::copy_n(s.data(), mantissa, buffer);
  if (!exponent.empty()) {
    *end++ = 'e';
    end = std::copy(exponent.begin(), exponent.end(), end);
  }
  const auto [stop, error] = std::from_chars(buffer, end, value);
  if (error == std::errc::result_out_of_range) {
    // no double is that large; what is too small to be one is nothing
    if (exponent.empty() ? significant > 300 : exponent[0] != '-') return false;
    value = 0;
  } else if (error != std::errc() || stop != end || !std::isfinite(value)) {
    return false;
  }
  if (minus) value = -value;
  const bool rounded = !exponent.empty() || s.substr(0, mantissa).find('.') != std::string_view::npos;
  if (digits != nullptr) *digits = rounded ? significant : 0;
  return true;
}

std::string why_no_number(std::string_view text) {
  if (text.empty()) return "a number is missing";
  std::string low;
  for (const char c : text.substr(0, 16)) low += lower_case(c);
  for (const char* word : {"nan", "inf", "1.#"})
    if (low.find(word) != std::string::npos) return quoted(text) + " is not finite";
  if (text.find(',') != std::string_view::npos) return quoted(text) + " has a comma; the decimal sign is a point";
  if (double v = 0; text.size() <= k_longest_number && text.find_first_of("eEdD") != std::string_view::npos &&
                    parse_number(text.substr(0, text.find_first_of("eEdD")), v))
    return quoted(text) + " is no number or beyond 1.8e308";
  return quoted(text) + " is no number";
}

void WrittenDigits::see(double value, int digits) noexcept {
  const double size = std::fabs(value);
  largest_ = fmax2(largest_, size);
  most_ = std::max(most_, digits);
  if (single_ && !(std::fabs(value - static_cast<double>(static_cast<float>(value))) <=
                   0.5 * size * std::pow(10.0, 1 - std::max(1, digits))))
    single_ = false;
}

double WrittenDigits::unit() const noexcept {
  if (most_ < 6 || !(largest_ > 0)) return 0x1p-52;
  const double last = std::pow(10.0, std::floor(std::log10(largest_)) + 1 - most_);
  const double unit = fmax2(0x1p-52, last / largest_);
  return most_ >= 7 && single_ ? fmax2(unit, 0x1p-23) : unit;
}

std::string_view plain_text(std::string_view bytes, const std::string& name) {
  const auto starts = [&](std::string_view mark) { return bytes.starts_with(mark); };
  if (starts("\xef\xbb\xbf")) return bytes.substr(3);
  using namespace std::string_view_literals;
  const bool wide = starts("\xff\xfe") || starts("\xfe\xff") ||
                    (bytes.size() > 3 && (bytes[0] == 0) != (bytes[1] == 0) && (bytes[0] == 0) == (bytes[2] == 0) &&
                     (bytes[1] == 0) == (bytes[3] == 0));
  if (wide) fail(name, 0, "the file is UTF-16 text", "save it as ASCII or UTF-8");
  if (starts("\x1f\x8b") || starts("PK\x03\x04"sv)) fail(name, 0, "the file is compressed", "unpack it first");
  return bytes;
}

bool Lines::next(std::string_view& line) noexcept {
  if (position_ >= text_.size()) return false;
  const std::size_t end = std::min(text_.find_first_of("\r\n", position_), text_.size());
  line = text_.substr(position_, end - position_);
  position_ = std::min(end + 1, text_.size());
  if (end + 1 < text_.size() && text_[end] == '\r' && text_[end + 1] == '\n') ++position_;
  ++number_;
  return true;
}

std::string_view Words::next() noexcept {
  std::size_t begin = 0;
  while (begin < rest_.size() && is_blank(rest_[begin])) ++begin;
  std::size_t end = begin;
  while (end < rest_.size() && !is_blank(rest_[end])) ++end;
  const std::string_view word = rest_.substr(begin, end - begin);
  rest_.remove_prefix(end);
  return word;
}

}  // namespace talus::mesh_io
