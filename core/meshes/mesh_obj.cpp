// Wavefront OBJ: vertices and faces. Materials, groups, smoothing, normals and texture coordinates do not matter here
// and may be absent. Free-form surfaces and included files would be geometry left out: they are refused. Who calls it:
// core/meshes/mesh_file.cpp. Invariants: see mesh_text.hpp; no other file is opened.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>

#include "core/meshes/mesh_text.hpp"

namespace talus::mesh_io {
namespace {

// Statements without facets. l and p are lines and points: they bound nothing.
constexpr std::array<std::string_view, 32> k_ignored{
    "vt",     "vn",  "vp",   "vc",    "g",        "o",        "s",    "mg",         "mtllib",    "usemtl", "usemap",
    "maplib", "l",   "p",    "bevel", "c_interp", "d_interp", "lod",  "shadow_obj", "trace_obj", "ctech",  "stech",
    "cstype", "deg", "bmat", "step",  "con",      "end",      "parm", "illum",      "mtl",       "res"};
constexpr std::array<std::string_view, 8> k_refused{"curv", "curv2", "surf", "trim", "hole", "scrv", "call", "csh"};

class Reader {
 public:
  Reader(std::string_view text, const std::string& name) noexcept : lines_(text), name_(name) {}

  RawMesh read() {
    std::string_view line;
    while (next(line)) statement(line);
    mesh_.unit = digits_.unit();
    add_polygons(mesh_, polygons_, 1, name_);
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void wrong(const std::string& what, const std::string& cure) { fail(name_, at_, what, cure); }

  /// A line together with those that a backslash continues it by.
  bool next(std::string_view& line) {
    if (!lines_.next(line)) return false;
    at_ = lines_.number();
    if (!line.ends_with('\\') || line.starts_with('#')) return true;
    joined_.clear();
    do {
      line.remove_suffix(1);
      joined_.append(line).push_back(' ');
    } while (lines_.next(line) && line.ends_with('\\'));
    joined_.append(line.ends_with('\\') ? std::string_view{} : line);
    line = joined_;
    return true;
  }

  void statement(std::string_view line) {
    Words words(line);
    const std::string_view key = words.next();
    if (key.empty() || key[0] == '#') return;
    if (same_word(key, "v")) return vertex(words);
    if (same_word(key, "f") || same_word(key, "fo")) return face(words);
    const auto is_key = [&](std::string_view k) { return same_word(key, k); };
    if (std::any_of(k_refused.begin(), k_refused.end(), is_key))
      wrong("the statement " + quoted(key) + " is not read: it adds surfaces that are no polygons, or another file",
            "export polygons");
    if (std::none_of(k_ignored.begin(), k_ignored.end(), is_key))
      wrong("unknown statement " + quoted(key), "v, f, and those that describe materials, groups and normals");
  }

  /// x y z, then nothing, a weight, a colour, or both.
  void vertex(Words& words) {
    Vec3 p;
    double number = 0, weight = 1;
    int count = 0, digits = 0;
    for (std::string_view w = words.next(); !w.empty() && w[0] != '#'; w = words.next(), ++count) {
      if (!parse_number(w, number, &digits)) wrong("vertex: " + why_no_number(w), "v x y z with finite numbers");
      if (count < 3) p[count] = number, digits_.see(number, digits);
      if (count == 3) weight = number;
    }
    if (count < 3 || count == 5 || count > 8)
      wrong(fmt::format("a vertex of {} numbers", count), "3, or with a weight or a colour 4, 6, 7 or 8");
    if (count == 4 && weight != 1)
      wrong(fmt::format("a vertex with the weight {:.6g}", weight), "vertices of polygons have the weight 1 or none");
    mesh_.points.push_back(p);
  }

  void face(Words& words) {
    const auto known = static_cast<std::int64_t>(mesh_.points.size());
    for (std::string_view w = words.next(); !w.empty() && w[0] != '#'; w = words.next()) {
      std::int64_t v = 0;
      const auto [end, error] = std::from_chars(w.data(), w.data() + w.size(), v);
      const std::string_view rest = w.substr(static_cast<std::size_t>(end - w.data()));
      const bool clean = rest.empty() || (rest[0] == '/' && rest.find_first_not_of("/-0123456789") == rest.npos);
      if (error != std::errc() || !clean)
        wrong("face: " + quoted(w) + " is no corner", "v, v/vt, v//vn or v/vt/vn with whole numbers");
      if (v == 0) wrong("face: the corner " + quoted(w) + " names vertex 0", "vertices count from 1, or back from -1");
      if (v < -known)
        wrong(fmt::format("face: vertex {} of {} that were defined so far", v, known),
              "at least -" + std::to_string(known));
      polygons_.corners.push_back(v > 0 ? v - 1 : known + v);
    }
    const std::size_t begin = polygons_.end.empty() ? 0 : polygons_.end.back();
    if (polygons_.corners.size() < begin + 3)
      wrong(fmt::format("a face with {} corners", polygons_.corners.size() - begin), "at least 3");
    polygons_.end.push_back(polygons_.corners.size());
    polygons_.line.push_back(at_);
  }

  Lines lines_;
  const std::string& name_;
  std::string joined_;
  std::int64_t at_ = 0;  ///< line of the present statement
  RawMesh mesh_;
  Polygons polygons_;
  WrittenDigits digits_;
};

}  // namespace

RawMesh parse_obj(std::string_view bytes, const std::string& name) {
  std::string_view text = plain_text(bytes, name);
  while (!text.empty() && (text.back() == 0 || text.back() == 0x1a)) text.remove_suffix(1);
  return Reader(text, name).read();
}

}  // namespace talus::mesh_io
