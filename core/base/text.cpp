// See text.hpp.
#include "core/base/text.hpp"

#include <fmt/format.h>

#include <charconv>

namespace talus {
namespace {

std::string escaped(std::string_view bytes) {
  std::string out;
  for (char c : bytes) {
    if (c == '\n')
      out += "\\n";
    else if (c == '\r')
      out += "\\r";
    else if (c == '\t')
      out += "\\t";
    else
      out += fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
  }
  return out;
}

/// The first position of a character at or after `at`, in text without invalid bytes.
std::size_t at_character(std::string_view text, std::size_t at) {
  while (at < text.size() && (static_cast<unsigned char>(text[at]) & 0xC0) == 0x80) ++at;
  return at;
}

}  // namespace

std::size_t utf8_length(std::string_view s, std::size_t i) noexcept {
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(k < s.size() ? s[k] : 0); };
  const auto tail = [&](std::size_t k) { return (byte(k) & 0xC0) == 0x80; };
  const unsigned a = byte(i), b = byte(i + 1);
  if (a < 0x80) return 1;
  if (a >= 0xC2 && a <= 0xDF) return tail(i + 1) ? 2 : 0;
  if (a >= 0xE0 && a <= 0xEF) {
    if (!tail(i + 1) || !tail(i + 2)) return 0;
    return (a == 0xE0 && b < 0xA0) || (a == 0xED && b > 0x9F) ? 0 : 3;  // overlong, surrogates
  }
  if (a >= 0xF0 && a <= 0xF4) {
    if (!tail(i + 1) || !tail(i + 2) || !tail(i + 3)) return 0;
    return (a == 0xF0 && b < 0x90) || (a == 0xF4 && b > 0x8F) ? 0 : 4;  // overlong, above U+10FFFF
  }
  return 0;
}

std::size_t first_invalid_utf8(std::string_view text) noexcept {
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t n = utf8_length(text, i);
    if (n == 0) return i;
    i += n;
  }
  return std::string_view::npos;
}

std::size_t control_length(std::string_view s, std::size_t i) noexcept {
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(k < s.size() ? s[k] : 0); };
  const unsigned a = byte(i), b = byte(i + 1), c = byte(i + 2);
  if (a < 0x20 || a == 0x7f) return 1;
  if (a == 0xC2 && b >= 0x80 && b <= 0x9F) return 2;  // C1
  if (a != 0xE2) return 0;
  if (b == 0x80 && ((c >= 0xA8 && c <= 0xAE) || c == 0x8E || c == 0x8F)) return 3;  // separators, embeddings, marks
  return b == 0x81 && c >= 0xA6 && c <= 0xA9 ? 3 : 0;                               // isolates
}

std::string shown(std::string_view text, std::size_t most) {
  // Escapes lengthen a text, so that the bytes beyond `most` on either side can never be seen.
  std::string out;
  const bool huge = text.size() > 4 * most + 64;
  const auto append = [&out](std::string_view part) {
    for (std::size_t i = 0; i < part.size();) {
      const std::size_t n = utf8_length(part, i), control = control_length(part, i);
      if (n == 0 || control != 0) {
        out += escaped(part.substr(i, n == 0 ? 1 : control));
        i += n == 0 ? 1 : control;
      } else {
        out.append(part, i, n);
        i += n;
      }
    }
  };
  append(huge ? text.substr(0, 2 * most) : text);
  if (huge) append(text.substr(text.size() - 2 * most));
  if (out.size() <= most) return out;
  constexpr std::size_t dots = 3;
  const std::size_t head = most > dots ? (most - dots) / 2 : 0, tail = most > dots ? most - dots - head : 0;
  std::size_t end = head;
  while (end > 0 && (static_cast<unsigned char>(out[end]) & 0xC0) == 0x80) --end;
  return out.substr(0, end) + "..." + out.substr(at_character(out, out.size() - tail));
}

std::string escaped_line(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t n = utf8_length(text, i), control = control_length(text, i);
    const std::size_t length = n == 0 ? 1 : n;
    if (n == 0 || control != 0)
      out += escaped(text.substr(i, length));
    else if (text[i] == '\\')
      out += "\\\\";
    else
      out.append(text, i, length);
    i += length;
  }
  return out;
}

std::string unescaped_line(std::string_view line) {
  std::string out;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] != '\\' || i + 1 == line.size()) {
      out += line[i];
      continue;
    }
    const char c = line[++i];
    unsigned value = 0;
    const char* hex = line.data() + i + 1;
    if (c == 'x' && i + 2 < line.size() && std::from_chars(hex, hex + 2, value, 16).ptr == hex + 2) {
      out += static_cast<char>(value);
      i += 2;
    } else {
      out += c == 'n' ? '\n' : c == 'r' ? '\r' : c == 't' ? '\t' : c;
    }
  }
  return out;
}

}  // namespace talus
