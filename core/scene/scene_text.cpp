// See scene_text.hpp.
#include "core/scene/scene_text.hpp"

#include <fmt/format.h>

#include "core/base/error.hpp"
#include "core/base/text.hpp"

namespace talus {
namespace {

/// Walks through the text as the parser will: strings, comments, and what is neither.
class Guard {
 public:
  Guard(std::string_view text, const std::string& name) : clean_(text), name_(name) {}

  std::string run() {
    while (at_ < clean_.size()) step();
    return std::move(clean_);
  }

 private:
  [[noreturn]] void refuse(const std::string& what, const char* cure) const {
    throw Error(ErrorCode::scene, what, fmt::format("{}:{}:{}", name_, line_, column_), cure);
  }

  void new_line() {
    ++line_;
    column_ = 0;
  }

  void step() {
    const char c = clean_[at_];
    ++column_;
    if (c == '\n') {
      new_line();
      comment_ = false;
      if (!triple_) quote_ = 0;  // the parser reports the unterminated string
      ++at_;
      return;
    }
    if (comment_) {
      if (!printable()) clean_[at_] = '?';
      ++at_;
      return;
    }
    const std::size_t length = printable() ? 1 : allowed_character();
    if (quote_ != 0)
      inside(c);
    else
      outside(c);
    at_ += length;
  }

  bool printable() const {
    const char c = clean_[at_];
    return (c >= 0x20 && c < 0x7f) || c == '\t' || (c == '\r' && at_ + 1 < clean_.size() && clean_[at_ + 1] == '\n');
  }

  /// Length of a character beyond ASCII.
  std::size_t allowed_character() const {
    const auto byte = static_cast<unsigned char>(clean_[at_]);
    const std::size_t length = utf8_length(clean_, at_);
    if (length == 0) refuse(fmt::format("byte 0x{:02x} is no UTF-8", byte), "save the file as UTF-8");
    if (control_length(clean_, at_) != 0)
      refuse(fmt::format("control character {}", shown(std::string_view(clean_).substr(at_, length))), "remove it");
    if (quote_ == 0)
      refuse(fmt::format("'{}' outside quotes and comments", std::string_view(clean_).substr(at_, length)),
             "only texts in quotes and comments may go beyond ASCII");
    return length;
  }

  bool three(char c) const { return clean_.compare(at_, 3, std::string(3, c)) == 0; }

  void inside(char c) {
    if (c == '\\' && quote_ == '"') {
      if (at_ + 1 >= clean_.size()) return;
      ++at_, ++column_;
      if (clean_[at_] == '\n') new_line();
      // an escaped character is still one that must be allowed
      else if (!printable())
        at_ += allowed_character() - 1;
    } else if (c == quote_ && (!triple_ || three(c))) {
      if (triple_) at_ += 2, column_ += 2;
      quote_ = 0;
    }
  }

  /// The parser goes on from a bare value into quotes that follow it, and does not expect what may stand there.
  void text_begins() const {
    const std::size_t before = clean_.find_last_not_of(" \t", at_ == 0 ? std::string::npos : at_ - 1);
    if (at_ == 0 || before == std::string::npos) return;
    if (std::string_view("=,[{.\n").find(clean_[before]) == std::string_view::npos)
      refuse(fmt::format("quotes behind '{}'", clean_[before]), "a text in quotes stands for itself");
  }

  void outside(char c) {
    if (c == '#') comment_ = true;
    if (c != '"' && c != '\'') return;
    text_begins();
    quote_ = c;
    triple_ = three(c);
    if (triple_) at_ += 2, column_ += 2;
  }

  std::string clean_;
  const std::string& name_;
  std::size_t at_ = 0;
  int line_ = 1, column_ = 0;  // characters, as the parser counts them
  char quote_ = 0;             // that opened the present string
  bool triple_ = false;        // of a multi-line string
  bool comment_ = false;
};

}  // namespace

std::string guarded_scene_text(std::string_view text, const std::string& name) {
  if (text.size() > k_scene_bytes)
    throw Error(ErrorCode::scene, fmt::format("the scene has {} bytes", text.size()), name, "at most 1 MiB is allowed");
  if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff"))
    throw Error(ErrorCode::scene, "the scene is UTF-16", name, "save the file as UTF-8");
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  return Guard(text, name).run();
}

bool is_scene_text(std::string_view text) noexcept {
  constexpr std::size_t most = 4096;
  if (text.size() > most) return false;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = utf8_length(text, i);
    if (length == 0 || control_length(text, i) != 0) return false;
    i += length;
  }
  return true;
}

}  // namespace talus
