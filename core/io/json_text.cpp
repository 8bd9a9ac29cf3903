// See json_text.hpp.
#include "core/io/json_text.hpp"

#include "core/base/text.hpp"

namespace talus {
namespace {

constexpr int k_depth = 64;

/// Recursive descent without values; every function returns false at the first fault and leaves `at` there.
class Scanner {
 public:
  explicit Scanner(std::string_view text) : text_(text) {}

  bool whole() {
    if (!value(0)) return false;
    blank();
    return at == text_.size();
  }
  std::size_t at = 0;

 private:
  char here() const { return at < text_.size() ? text_[at] : '\0'; }
  bool is_digit() const { return here() >= '0' && here() <= '9'; }
  bool take(char c) { return here() == c && at < text_.size() ? (++at, true) : false; }
  bool word(std::string_view w) {
    for (const char c : w)
      if (!take(c)) return false;
    return true;
  }
  void blank() {
    while (at < text_.size() && std::string_view(" \t\r\n").find(text_[at]) != std::string_view::npos) ++at;
  }

  bool value(int depth) {
    blank();
    if (depth > k_depth) return false;
    switch (here()) {
      case '{':
        return list('}', depth, true);
      case '[':
        return list(']', depth, false);
      case '"':
        return string();
      case 't':
        return word("true");
      case 'f':
        return word("false");
      case 'n':
        return word("null");
      default:
        return number();
    }
  }
  bool list(char close, int depth, bool keys) {
    ++at;
    blank();
    if (take(close)) return true;
    for (;;) {
      blank();
      if (keys && !(string() && (blank(), take(':')))) return false;
      if (!value(depth + 1)) return false;
      blank();
      if (take(close)) return true;
      if (!take(',')) return false;
    }
  }
  bool string() {
    if (!take('"')) return false;
    for (;;) {
      const auto c = static_cast<unsigned char>(here());
      if (at >= text_.size() || c < 0x20) return false;
      if (take('"')) return true;
      if (c != '\\') {
        const std::size_t n = utf8_length(text_, at);
        if (n == 0) return false;
        at += n;
        continue;
      }
      ++at;
      if (take('u')) {
        for (int k = 0; k < 4; ++k, ++at)
          if (std::string_view("0123456789abcdefABCDEF").find(here()) == std::string_view::npos) return false;
      } else if (at < text_.size() && std::string_view("\"\\/bfnrt").find(here()) != std::string_view::npos) {
        ++at;
      } else {
        return false;
      }
    }
  }
  bool digits() {
    if (!is_digit()) return false;
    while (is_digit()) ++at;
    return true;
  }
  bool number() {
    take('-');
    if (!take('0') && !digits()) return false;
    if (take('.') && !digits()) return false;
    if (here() != 'e' && here() != 'E') return true;
    ++at;
    if (!take('+')) take('-');
    return digits();
  }

  std::string_view text_;
};

}  // namespace

std::optional<std::size_t> json_error(std::string_view text) {
  Scanner scanner(text);
  if (scanner.whole()) return {};
  return scanner.at;
}

}  // namespace talus
