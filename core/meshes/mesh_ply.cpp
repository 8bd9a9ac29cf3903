// PLY: ascii, binary little and big endian, properties of any type in any order, lists, further elements, triangle
// strips. Who calls it: core/meshes/mesh_file.cpp. Invariants: see mesh_text.hpp; the header's numbers are set against
// the bytes that are there before anything is allocated.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>

#include "core/meshes/mesh_text.hpp"

namespace talus::mesh_io {
namespace {

struct Type {
  std::string_view name, other;
  std::size_t bytes;
  enum class Kind : std::uint8_t { whole, natural, real } kind;
};
using enum Type::Kind;
constexpr Type k_types[] = {{"char", "int8", 1, whole},    {"uchar", "uint8", 1, natural},
                            {"short", "int16", 2, whole},  {"ushort", "uint16", 2, natural},
                            {"int", "int32", 4, whole},    {"uint", "uint32", 4, natural},
                            {"long", "int64", 8, whole},   {"ulong", "uint64", 8, natural},
                            {"float", "float32", 4, real}, {"double", "float64", 8, real}};

enum class Role : std::uint8_t { none, x, y, z, indices };

struct Property {
  const Type* type = nullptr;
  const Type* count = nullptr;  ///< of a list
  Role role = Role::none;
};

struct Element {
  enum class Kind : std::uint8_t { other, vertex, face, strips } kind = Kind::other;
  std::string name;
  std::int64_t count = 0, line = 0;
  std::vector<Property> properties;
};

enum class Format : std::uint8_t { ascii, little, big };

class Reader {
 public:
  Reader(std::string_view bytes, const std::string& name) noexcept : bytes_(bytes), lines_(bytes), name_(name) {}

  RawMesh read() {
    header();
    if (format_ == Format::ascii)
      ascii_body();
    else
      binary_body();
    mesh_.unit = single_ ? 0x1p-23 : (format_ == Format::ascii ? digits_.unit() : 0x1p-52);
    add_polygons(mesh_, polygons_, 0, name_);
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void wrong(const std::string& what, const std::string& cure = {}) const {
    fail(name_, format_ == Format::ascii || in_header_ ? lines_.number() : 0, what, cure);
  }

  // -------------------------------------------------------------------------------------------------------- header

  const Type* type(std::string_view word) const {
    for (const Type& t : k_types)
      if (same_word(word, t.name) || same_word(word, t.other)) return &t;
    wrong("unknown type " + quoted(word), "char, uchar, short, ushort, int, uint, float, double, int8 ... float64");
  }

  void header() {
    std::string_view line;
    if (!lines_.next(line) || !same_word(Words(line).next(), "ply"))
      wrong("found " + quoted(line), "a PLY file begins with \"ply\"");
    bool format = false;
    for (;;) {
      if (!lines_.next(line)) wrong("the file ends within its header", "expected end_header");
      Words words(line);
      const std::string_view key = words.next();
      if (key.empty() || same_word(key, "comment") || same_word(key, "obj_info")) continue;
      if (same_word(key, "end_header")) break;
      if (same_word(key, "format")) {
        const std::string_view kind = words.next();
        read_format(kind, words.next());
        format = true;
      } else if (same_word(key, "element")) {
        read_element(words);
      } else if (same_word(key, "property")) {
        read_property(words);
      } else {
        wrong("found " + quoted(key) + " in the header", "format, element, property, comment, obj_info or end_header");
      }
    }
    if (!format) wrong("the header has no format", "e.g. format ascii 1.0");
    check_elements();
    in_header_ = false;
  }

  void read_format(std::string_view kind, std::string_view version) {
    if (same_word(kind, "ascii"))
      format_ = Format::ascii;
    else if (same_word(kind, "binary_little_endian"))
      format_ = Format::little;
    else if (same_word(kind, "binary_big_endian"))
      format_ = Format::big;
    else
      wrong("unknown format " + quoted(kind), "ascii, binary_little_endian or binary_big_endian");
    if (version != "1.0") wrong("unknown version " + quoted(version), "1.0");
  }

  void read_element(Words& words) {
    Element e;
    e.name = std::string(words.next());
    e.line = lines_.number();
    const std::string_view count = words.next();
    const auto [end, error] = std::from_chars(count.data(), count.data() + count.size(), e.count);
    if (e.name.empty() || error != std::errc() || end != count.data() + count.size() || count.empty() || e.count < 0)
      wrong("element " + quoted(e.name) + " has the number " + quoted(count), "a name and a whole number >= 0");
    if (same_word(e.name, "vertex")) e.kind = Element::Kind::vertex;
    if (same_word(e.name, "face")) e.kind = Element::Kind::face;
    if (same_word(e.name, "tristrips")) e.kind = Element::Kind::strips;
    for (const Element& other : elements_)
      if (e.kind != Element::Kind::other && other.kind == e.kind) wrong("a second element " + quoted(e.name));
    elements_.push_back(std::move(e));
  }

  void read_property(Words& words) {
    if (elements_.empty()) wrong("a property before the first element");
    Element& e = elements_.back();
    Property p;
    std::string_view word = words.next();
    if (same_word(word, "list")) {
      p.count = type(words.next());
      if (p.count->kind == real) wrong("the length of a list is " + quoted(p.count->name), "a whole type");
      word = words.next();
    }
    p.type = type(word);
    const std::string_view name = words.next();
    if (name.empty()) wrong("a property without a name");
    if (p.count != nullptr) {
      const bool indices = same_word(name, "vertex_indices") || same_word(name, "vertex_index");
      if (indices && (e.kind == Element::Kind::face || e.kind == Element::Kind::strips)) p.role = Role::indices;
      if (p.role == Role::indices && p.type->kind == real)
        wrong("the indices of vertices are " + quoted(p.type->name), "a whole type");
    } else if (e.kind == Element::Kind::vertex) {
      p.role = same_word(name, "x")   ? Role::x
               : same_word(name, "y") ? Role::y
               : same_word(name, "z") ? Role::z
                                      : Role::none;
    }
    for (const Property& other : e.properties)
      if (p.role != Role::none && other.role == p.role) wrong("a second property " + quoted(name));
    e.properties.push_back(p);
  }

  void check_elements() {
    bool vertices = false, faces = false;
    for (const Element& e : elements_) {
      const auto has = [&](Role role) {
        return std::any_of(e.properties.begin(), e.properties.end(), [&](const Property& p) { return p.role == role; });
      };
      if (e.kind == Element::Kind::vertex) {
        vertices = true;
        if (!has(Role::x) || !has(Role::y) || !has(Role::z))
          fail(name_, e.line, "the vertices lack x, y or z", "property float x, y and z");
        for (const Property& p : e.properties)  // a text has the digits that it shows
          single_ = single_ || (p.role != Role::none && p.type->name == "float" && format_ != Format::ascii);
      } else if (e.kind != Element::Kind::other && e.count > 0) {
        faces = true;
        if (!has(Role::indices))
          fail(name_, e.line, "the element " + quoted(e.name) + " has no list of vertices",
               "property list uchar int vertex_indices");
      }
      std::int64_t least = 0;  // bytes of one element
      for (const Property& p : e.properties)
        least +=
            format_ == Format::ascii ? 2 : static_cast<std::int64_t>((p.count != nullptr ? p.count : p.type)->bytes);
      const auto left = static_cast<std::int64_t>(bytes_.size() - lines_.position());
      if (least > 0 && e.count > (left + 1) / least)
        fail(name_, e.line,
             fmt::format("{} elements {} need at least {} bytes each, {} follow the header", e.count, quoted(e.name),
                         least, left),
             "the file was cut off or its header is damaged");
    }
    if (!vertices) wrong("the header names no element vertex");
    if (!faces)
      wrong("the header names no element face, or none of them", "a mesh needs faces; this is a cloud of points");
  }

  // ----------------------------------------------------------------------------------------------------- elements

  std::string place(const Element& e, std::int64_t k) const {
    return format_ == Format::ascii ? "" : fmt::format("{} {} (byte {}): ", e.name.substr(0, 20), k + 1, at_);
  }

  void put_vertex(const Element& e, std::int64_t k, const Vec3& p) {
    for (int a = 0; a < 3; ++a)
      if (!std::isfinite(p[a])) wrong(place(e, k) + "the vertex is not finite", "coordinates are finite numbers");
    mesh_.points.push_back(p);
  }

  void put_face(const Element& e, std::int64_t k) {
    if (indices_.size() < 3) wrong(fmt::format("{}a face with {} corners", place(e, k), indices_.size()), "at least 3");
    polygons_.corners.insert(polygons_.corners.end(), indices_.begin(), indices_.end());
    polygons_.end.push_back(polygons_.corners.size());
    polygons_.line.push_back(format_ == Format::ascii ? lines_.number() : 0);
  }

  /// Every vertex makes a triangle with the two before it, wound alternately; -1 begins anew.
  void put_strips(const Element& e, std::int64_t k) {
    const std::vector<std::int64_t> strip = std::move(indices_);
    std::size_t begin = 0;
    for (std::size_t i = 0; i < strip.size(); ++i) {
      if (strip[i] == -1) {
        begin = i + 1;
      } else if (i >= begin + 2) {
        const bool odd = (i - begin) % 2 == 1;
        indices_ = {strip[i - 2], strip[odd ? i : i - 1], strip[odd ? i - 1 : i]};
        put_face(e, k);
      }
    }
    indices_.clear();
  }

  void finish(const Element& e, std::int64_t k, const Vec3& p) {
    if (e.kind == Element::Kind::vertex) put_vertex(e, k, p);
    if (e.kind == Element::Kind::face) put_face(e, k);
    if (e.kind == Element::Kind::strips) put_strips(e, k);
  }

  // -------------------------------------------------------------------------------------------------------- ascii

  void ascii_body() {
    std::string_view line;
    for (const Element& e : elements_) {
      if (e.properties.empty()) continue;
      for (std::int64_t k = 0; k < e.count; ++k) {
        do {
          if (!lines_.next(line))
            wrong(fmt::format("the file ends after {} of {} elements {}", k, e.count, quoted(e.name)),
                  "it was cut off, or the header is damaged");
        } while (Words(line).next().empty());
        ascii_element(e, k, line);
      }
    }
    while (lines_.next(line))
      if (const std::string_view word = Words(line).next(); !word.empty() && word[0] != 0x1a)
        wrong("found " + quoted(word) + " after the last element", "the header states fewer elements than follow");
  }

  std::int64_t ascii_whole(std::string_view word, const char* what) const {
    std::int64_t n = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), n);
    if (error != std::errc() || end != word.data() + word.size() || word.empty())
      wrong(word.empty() ? fmt::format("the line ends where {} is expected", what)
                         : fmt::format("found {} for {}", quoted(word), what),
            "a whole number");
    return n;
  }

  void ascii_element(const Element& e, std::int64_t k, std::string_view line) {
    Words words(line);
    Vec3 p;
    indices_.clear();
    for (const Property& property : e.properties) {
      if (property.count != nullptr) {
        const std::int64_t n = ascii_whole(words.next(), "the length of a list");
        if (n < 0 || n > static_cast<std::int64_t>(line.size()))
          wrong(fmt::format("a list of {} in a line of {} characters", n, line.size()));
        for (std::int64_t i = 0; i < n; ++i) {
          const std::string_view word = words.next();
          if (property.role == Role::indices)
            indices_.push_back(ascii_whole(word, "the number of a vertex"));
          else if (word.empty())
            wrong("the line ends within a list");
        }
        continue;
      }
      const std::string_view word = words.next();
      if (word.empty()) wrong(fmt::format("the line ends before the last property of {}", quoted(e.name)));
      if (property.role == Role::none) continue;
      double value = 0;
      int digits = 0;
      if (!parse_number(word, value, &digits)) wrong("vertex: " + why_no_number(word), "x, y and z are finite numbers");
      digits_.see(value, digits);
      p[static_cast<int>(property.role) - static_cast<int>(Role::x)] = value;
    }
    if (const std::string_view word = words.next(); !word.empty())
      wrong(fmt::format("found {} after the last property of {}", quoted(word), quoted(e.name)),
            "the line holds more than the header says");
    finish(e, k, p);
  }

  // ------------------------------------------------------------------------------------------------------- binary

  std::uint64_t raw(std::size_t n) noexcept {
    std::uint64_t bits = 0;
    for (std::size_t k = 0; k < n; ++k) {
      const std::size_t from = format_ == Format::big ? k : n - 1 - k;
      bits = bits << 8 | static_cast<unsigned char>(bytes_[at_ + from]);
    }
    at_ += n;
    return bits;
  }

  void need(const Element& e, std::int64_t k, std::uint64_t bytes) const {
    if (bytes > bytes_.size() - at_)
      wrong(fmt::format("{}{} bytes are needed, {} are left", place(e, k), bytes, bytes_.size() - at_),
            "the file was cut off or its header is damaged");
  }

  std::int64_t binary_whole(const Type& t) noexcept {
    const std::uint64_t bits = raw(t.bytes);
    if (t.kind == natural) return static_cast<std::int64_t>(std::min<std::uint64_t>(bits, INT64_MAX));
    const auto unused = static_cast<int>(64 - 8 * t.bytes);
    return static_cast<std::int64_t>(bits << unused) >> unused;
  }

  double binary_number(const Type& t) noexcept {
    if (t.kind != real) return static_cast<double>(binary_whole(t));
    const std::uint64_t bits = raw(t.bytes);
    return t.bytes == 4 ? std::bit_cast<float>(static_cast<std::uint32_t>(bits)) : std::bit_cast<double>(bits);
  }

  void binary_element(const Element& e, std::int64_t k) {
    Vec3 p;
    indices_.clear();
    for (const Property& property : e.properties) {
      need(e, k, (property.count != nullptr ? property.count : property.type)->bytes);
      if (property.count != nullptr) {
        const std::int64_t n = binary_whole(*property.count);
        const auto left = static_cast<std::int64_t>(bytes_.size() - at_);
        const auto size = static_cast<std::int64_t>(property.type->bytes);
        if (n < 0 || n > left / size)
          wrong(fmt::format("{}a list of {}, {} bytes are left", place(e, k), n, left),
                "the file was cut off or its header is damaged");
        if (property.role == Role::indices)
          for (std::int64_t i = 0; i < n; ++i) indices_.push_back(binary_whole(*property.type));
        else
          at_ += static_cast<std::size_t>(n * size);
      } else if (property.role == Role::none) {
        at_ += property.type->bytes;
      } else {
        p[static_cast<int>(property.role) - static_cast<int>(Role::x)] = binary_number(*property.type);
      }
    }
    finish(e, k, p);
  }

  void binary_body() {
    at_ = lines_.position();
    // where lines end with CR alone, a following LF is the first byte of the body
    const std::size_t line_end = bytes_.find_first_of("\r\n");
    if (bytes_.substr(at_ - 2, 2) == "\r\n" && bytes_.substr(line_end, 2) != "\r\n" && bytes_[line_end] == '\r') --at_;
    for (const Element& e : elements_) {
      if (e.properties.empty()) continue;
      for (std::int64_t k = 0; k < e.count; ++k) binary_element(e, k);
    }
    const std::string_view rest = bytes_.substr(at_);
    if (rest.empty()) return;
    if (!std::all_of(rest.begin(), rest.end(), [](char c) { return c == 0 || c == '\n' || c == '\r' || is_blank(c); }))
      wrong(fmt::format("{} bytes follow the last element", rest.size()),
            "the header states fewer elements than follow");
    mesh_.notes.push_back(fmt::format("{} bytes after the last element were ignored", rest.size()));
  }

  std::string_view bytes_;
  Lines lines_;
  const std::string& name_;
  bool in_header_ = true, single_ = false;
  Format format_ = Format::ascii;
  std::vector<Element> elements_;
  std::size_t at_ = 0;  ///< next byte of a binary body
  std::vector<std::int64_t> indices_;
  RawMesh mesh_;
  Polygons polygons_;
  WrittenDigits digits_;
};

}  // namespace

RawMesh parse_ply(std::string_view bytes, const std::string& name) {
  return Reader(plain_text(bytes, name), name).read();
}

}  // namespace talus::mesh_io
