// STL, text and binary, as exporters write it: keywords in any case, in one or two words ("end loop"), comments,
// several solids, missing endsolid, any line ends. Normals are not read: they follow from the corners. Who calls it:
// core/meshes/mesh_file.cpp. Invariants: see mesh_text.hpp. What is incomplete is an error.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "core/meshes/mesh_text.hpp"

namespace talus::mesh_io {
namespace {

constexpr std::size_t k_header = 84, k_facet = 50;  // bytes

bool is_control(char c) noexcept {
  const auto u = static_cast<unsigned char>(c);
  return u < 9 || (u > 13 && u < 32 && u != 0x1a);  // 0x1a ends a text of DOS
}

std::uint32_t little_endian(const char* p) noexcept {
  std::uint32_t n = 0;
  for (int k = 3; k >= 0; --k) n = n << 8 | static_cast<unsigned char>(p[k]);
  return n;
}

/// The size decides where it fits. Otherwise a file is text if it reads like one, whatever its first word: headers of
/// binary files may begin with "solid", too.
bool is_binary(std::string_view bytes) {
  if (bytes.size() >= k_header) {
    const std::uint64_t n = little_endian(bytes.data() + 80);
    if (n > 0 && bytes.size() == k_header + k_facet * n) return true;
  }
  const std::string_view head = bytes.substr(0, 2000);
  if (std::none_of(head.begin(), head.begin() + static_cast<long>(std::min<std::size_t>(head.size(), 1000)),
                   is_control))
    return false;
  for (std::size_t i = 0; i + 6 <= head.size(); ++i)
    if (same_word(head.substr(i, 6), "vertex")) return false;
  return true;
}

RawMesh parse_binary(std::string_view bytes, const std::string& name) {
  if (bytes.size() < k_header)
    fail(name, 0, fmt::format("a binary STL has at least 84 bytes, this file has {}", bytes.size()));
  const std::uint64_t n = little_endian(bytes.data() + 80), held = (bytes.size() - k_header) / k_facet;
  const std::uint64_t needed = k_header + k_facet * n;
  RawMesh mesh;
  if (bytes.size() < needed)
    fail(name, 0,
         fmt::format("the header of the binary STL states {} facets = {} bytes, the file has {} and ends {} facet {}",
                     n, needed, bytes.size(), (bytes.size() - k_header) % k_facet == 0 ? "after" : "within",
                     held + ((bytes.size() - k_header) % k_facet == 0 ? 0 : 1)),
         "it was cut off, or its writer did not fill in the number; write it again");
  if (const std::string_view rest = bytes.substr(needed); !rest.empty()) {
    const bool padding = std::all_of(rest.begin(), rest.end(), [](char c) { return c == 0; });
    if (n == 0 || (rest.size() >= k_facet && !padding))
      fail(name, 0,
           fmt::format("the header of the binary STL states {} facets, but {} bytes follow them: {} facets more", n,
                       rest.size(), rest.size() / k_facet),
           "its writer did not fill in the number; write it again");
    mesh.notes.push_back(fmt::format("{} bytes after the last facet were ignored", rest.size()));
  }
  mesh.unit = 0x1p-23;
  mesh.points.reserve(3 * n);
  mesh.facets.reserve(n);
  for (std::uint64_t f = 0; f < n; ++f) {
    const std::uint64_t at = k_header + k_facet * f;
    for (std::size_t c = 0; c < 3; ++c) {
      Vec3 p;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint64_t place = at + 12 + 12 * c + 4 * k;
        const auto x = std::bit_cast<float>(little_endian(bytes.data() + place));
        if (!std::isfinite(x))
          fail(name, 0, fmt::format("facet {} (byte {}) has a coordinate that is not finite", f + 1, place),
               "coordinates are finite numbers");
        p[static_cast<int>(k)] = x;
      }
      mesh.points.push_back(p);
    }
    const auto v = static_cast<std::int32_t>(3 * f);
    mesh.facets.push_back({v, v + 1, v + 2});
  }
  return mesh;
}

/// Words of the whole text, whatever the lines; comments are skipped.
class Tokens {
 public:
  explicit Tokens(std::string_view text) noexcept : text_(text) {}

  /// The next word without taking it; empty at the end of the file.
  std::string_view peek() noexcept {
    for (;;) {
      skip_space();
      const bool comment = begin_ < text_.size() && (text_[begin_] == '#' || text_.substr(begin_).starts_with("//") ||
                                                     (first_of_line_ && std::strchr(";!%", text_[begin_]) != nullptr));
      if (!comment) break;
      rest_of_line();
    }
    end_ = begin_;
    while (end_ < text_.size() && !is_space(text_[end_])) ++end_;
    return text_.substr(begin_, end_ - begin_);
  }
  std::string_view take() noexcept {
    const std::string_view word = peek();
    begin_ = end_;
    first_of_line_ = first_of_line_ && word.empty();
    return word;
  }
  void rest_of_line() noexcept {
    while (begin_ < text_.size() && text_[begin_] != '\n' && text_[begin_] != '\r') ++begin_;
  }
  /// The name of a solid: up to the end of the line, or up to its first facet where the file has no lines.
  void skip_name() noexcept {
    for (; begin_ < text_.size() && text_[begin_] != '\n' && text_[begin_] != '\r'; ++begin_)
      if (is_blank(text_[begin_]) && same_word(text_.substr(begin_ + 1, 12), "facet normal")) return;
  }
  std::int64_t line() const noexcept { return line_; }

 private:
  static bool is_space(char c) noexcept { return is_blank(c) || c == '\n' || c == '\r'; }
  void skip_space() noexcept {
    for (; begin_ < text_.size() && is_space(text_[begin_]); ++begin_)
      if (text_[begin_] == '\n' || (text_[begin_] == '\r' && text_.substr(begin_ + 1, 1) != "\n"))
        ++line_, first_of_line_ = true;
  }

  std::string_view text_;
  std::size_t begin_ = 0, end_ = 0;
  std::int64_t line_ = 1;
  bool first_of_line_ = true;
};

class TextReader {
 public:
  TextReader(std::string_view text, const std::string& name) noexcept : in_(text), name_(name) {}

  RawMesh read() {
    bool in_solid = false;
    for (;;) {
      const std::string_view word = in_.peek();
      if (word.empty()) break;
      if (same_word(word, "solid")) {
        in_.take();
        in_.skip_name();
        in_solid = true;
      } else if (same_word(word, "facet")) {
        in_.take();
        facet();
      } else if (end_of("solid")) {
        in_.rest_of_line();
        in_solid = false;
      } else if (same_word(word, "color") || same_word(word, "colour")) {
        in_.rest_of_line();
      } else {
        wrong("solid, facet or endsolid");
      }
    }
    if (in_solid) mesh_.notes.push_back("the file has no endsolid: it may be incomplete");
    mesh_.unit = digits_.unit();
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void wrong(const std::string& allowed) {
    const std::string_view word = in_.peek();
    fail(name_, in_.line(),
         fmt::format("{}{}", in_facet_ ? fmt::format("facet {}: ", mesh_.facets.size() + 1) : "",
                     word.empty() ? "the file ends" : "found " + quoted(word)),
         "expected " + allowed);
  }

  /// Takes "endWORD" or "end WORD"; of the last solid also with its name joined to it.
  bool end_of(std::string_view what) {
    const std::string_view word = in_.peek();
    if (word.size() < 3 || !same_word(word.substr(0, 3), "end")) return false;
    if (word.size() == 3) {
      in_.take();
      if (!same_word(in_.peek(), what)) wrong("\"end " + std::string(what) + "\"");
    } else {
      const std::string_view tail = word.substr(3);
      const bool joined = what == "solid" && tail.size() > 5 && same_word(tail.substr(0, 5), what);
      if (!same_word(tail, what) && !joined) return false;
    }
    in_.take();
    return true;
  }

  void facet() {
    in_facet_ = true;
    if (same_word(in_.peek(), "normal")) in_.take();
    while (!same_word(in_.peek(), "outer") && !same_word(in_.peek(), "outerloop")) {
      if (!may_be_normal(in_.peek())) wrong("\"outer loop\"");
      in_.take();
    }
    if (!same_word(in_.take(), "outerloop")) {
      if (!same_word(in_.peek(), "loop")) wrong("\"outer loop\"");
      in_.take();
    }
    const auto first = static_cast<std::int32_t>(mesh_.points.size());
    for (int corner = 0; corner < 3; ++corner) vertex();
    if (!end_of("loop")) wrong("endloop after 3 vertices");
    if (!end_of("facet")) wrong("endfacet");
    mesh_.facets.push_back({first, first + 1, first + 2});
    in_facet_ = false;
  }

  /// Whatever exporters make of an indeterminate normal: nan, -nan(ind), -1.#IND.
  static bool may_be_normal(std::string_view word) {
    double ignored = 0;
    return parse_number(word, ignored) || word.find_first_of("#()") != std::string_view::npos ||
           why_no_number(word).ends_with("finite");
  }

  void vertex() {
    if (!same_word(in_.peek(), "vertex")) wrong("one of 3 vertices");
    in_.take();
    Vec3 p;
    for (int k = 0; k < 3; ++k) {
      int digits = 0;
      const std::string_view word = in_.peek();
      if (!parse_number(word, p[k], &digits))
        fail(name_, in_.line(), fmt::format("facet {}: {}", mesh_.facets.size() + 1, why_no_number(word)),
             "a vertex has three finite numbers");
      digits_.see(p[k], digits);
      in_.take();
    }
    mesh_.points.push_back(p);
  }

  Tokens in_;
  const std::string& name_;
  RawMesh mesh_;
  WrittenDigits digits_;
  bool in_facet_ = false;
};

}  // namespace

RawMesh parse_stl(std::string_view bytes, const std::string& name) {
  if (is_binary(bytes)) {
    if (bytes.size() < k_header || bytes.size() != k_header + k_facet * little_endian(bytes.data() + 80))
      plain_text(bytes, name);  // compressed or UTF-16: say so
    return parse_binary(bytes, name);
  }
  std::string_view text = plain_text(bytes, name);
  while (!text.empty() && (text.back() == 0 || text.back() == 0x1a)) text.remove_suffix(1);
  return TextReader(text, name).read();
}

}  // namespace talus::mesh_io
