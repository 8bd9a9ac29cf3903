// Extended XYZ; see text_frames.hpp.
#include <algorithm>
#include <map>

#include "core/io/text_rows.hpp"

namespace talus {
namespace {

using text_frames::Field;
using text_frames::Rows;
constexpr const char* k_cure = "Properties=species:S:1:id:I:1:pos:R:3:radius:R:1:velo:R:3";

struct Property {
  std::string_view name;
  Field first;
  int width;
};
constexpr Property k_properties[] = {{"species", Field::species, 1},
                                     {"id", Field::id, 1},
                                     {"pos", Field::x, 3},
                                     {"radius", Field::radius, 1},
                                     {"diameter", Field::diameter, 1},
                                     {"velo", Field::vx, 3},
                                     {"vel", Field::vx, 3},
                                     {"velocity", Field::vx, 3},
                                     {"velocities", Field::vx, 3},
                                     {"angular_velocity", Field::wx, 3},
                                     {"omega", Field::wx, 3}};

class XyzReader {
 public:
  XyzReader(std::string_view text, const std::string& name) : lines_(text), name_(name), rows_(lines_, name, out_) {}

  TextFrames read() {
    std::string_view line;
    while (lines_.next(line)) {
      if (line.empty()) continue;
      const auto n = rows_.number<std::int64_t>(line, "number of particles");
      if (n < 0) rows_.fail(fmt::format("{} particles", n), "");
      if (!lines_.next(line)) rows_.fail("the last frame is cut off", "the whole file");
      frame(n, keys_of(line));
    }
    if (out_.frames.empty()) rows_.fail("there is no frame", k_cure);
    rows_.finish();
    return std::move(out_);
  }

 private:
  using Keys = std::map<std::string, std::string, std::less<>>;

  /// key=value, key="a value" of the second line of a frame; names in lower case.
  Keys keys_of(std::string_view line) const {
    Keys keys;
    while (!(line = particle_text::trim(line)).empty()) {
      const std::size_t end = line.find_first_of("= \t");
      std::string key(line.substr(0, end));
      std::transform(key.begin(), key.end(), key.begin(),
                     [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
      line = end == std::string_view::npos ? std::string_view{} : line.substr(end);
      std::string value;
      if (line.starts_with('=')) {
        line.remove_prefix(1);
        const bool quoted = line.starts_with('"');
        if (quoted) line.remove_prefix(1);
        const std::size_t stop = line.find_first_of(quoted ? "\"" : " \t");
        if (quoted && stop == std::string_view::npos) rows_.fail("a quote is not closed", k_cure);
        value = line.substr(0, stop);
        line = stop == std::string_view::npos ? std::string_view{} : line.substr(stop + (quoted ? 1 : 0));
      }
      keys[key] = value;
    }
    return keys;
  }

  std::vector<Field> fields_of(const std::string& properties) {
    std::vector<std::string_view> words;
    for (std::string_view rest = properties; !rest.empty();) {
      const std::size_t end = rest.find(':');
      words.push_back(rest.substr(0, end));
      rest = end == std::string_view::npos ? std::string_view{} : rest.substr(end + 1);
    }
    if (words.empty() || words.size() % 3 != 0)
      rows_.fail(fmt::format("Properties '{}' are no name:type:columns", shown(properties, 80)), k_cure);
    std::vector<Field> fields;
    std::string ignored;
    for (std::size_t k = 0; k < words.size(); k += 3) {
      const auto width = rows_.number<int>(words[k + 2], "columns of a property");
      if (width < 1 || width > 1000) rows_.fail(fmt::format("{} columns", width), k_cure);
      const auto* known = std::find_if(std::begin(k_properties), std::end(k_properties),
                                       [&](const Property& p) { return p.name == words[k] && p.width == width; });
      const bool found = known != std::end(k_properties);
      if (!found) ignored += (ignored.empty() ? "" : ", ") + shown(words[k], 40);
      for (int c = 0; c < width; ++c)
        fields.push_back(found ? static_cast<Field>(static_cast<int>(known->first) + c) : Field::none);
    }
    if (!ignored.empty() && out_.frames.empty())
      out_.notes.push_back(fmt::format("{}: ignored: {}", name_, shown(ignored, 200)));
    return fields;
  }

  std::vector<double> numbers(const std::string& text, std::size_t n, const char* what) const {
    std::vector<std::string_view> words;
    particle_text::split_blanks(text, words);
    if (words.size() != n) rows_.fail(fmt::format("{} has {} values", what, words.size()), fmt::format("{} values", n));
    std::vector<double> values;
    for (const std::string_view w : words) values.push_back(rows_.number<double>(w, what));
    return values;
  }

  std::optional<Domain> domain_of(const Keys& keys) const {
    const auto lattice = keys.find("lattice");
    if (lattice == keys.end()) return {};
    const std::vector<double> a = numbers(lattice->second, 9, "Lattice");
    for (std::size_t k = 0; k < 9; ++k)
      if (k % 4 != 0 && a[k] != 0) rows_.fail("the box is skewed", "a Lattice with right angles along the axes");
    Domain d;
    for (auto& axis : d.boundary) axis = {Boundary::open, Boundary::open};
    const auto origin = keys.find("origin");
    const std::vector<double> o = origin == keys.end() ? std::vector<double>(3) : numbers(origin->second, 3, "Origin");
    for (int k = 0; k < 3; ++k) {
      d.lower[k] = o[static_cast<std::size_t>(k)];
      d.upper[k] = d.lower[k] + a[static_cast<std::size_t>(4 * k)];
    }
    if (const auto pbc = keys.find("pbc"); pbc != keys.end()) {
      std::vector<std::string_view> words;
      particle_text::split_blanks(pbc->second, words);
      for (std::size_t k = 0; k < std::min<std::size_t>(3, words.size()); ++k)
        if (words[k] == "T" || words[k] == "1" || words[k] == "True" || words[k] == "true")
          d.boundary[k] = {Boundary::periodic, Boundary::periodic};
    }
    return d;
  }

  void frame(std::int64_t n, const Keys& keys) {
    const auto properties = keys.find("properties");
    if (properties == keys.end())
      rows_.fail("the second line states no Properties: a plain XYZ file has points, no spheres", k_cure);
    rows_.columns(fields_of(properties->second), k_cure);
    Frame f;
    const auto index = static_cast<std::int64_t>(out_.frames.size());
    f.step = keys.contains("step") ? rows_.number<std::int64_t>(keys.find("step")->second, "Step") : index;
    f.time =
        keys.contains("time") ? rows_.number<double>(keys.find("time")->second, "Time") : static_cast<double>(f.step);
    if (!keys.contains("time") && index == 1)
      out_.notes.push_back(name_ + ": no times: the numbers of the frames stand for them");
    if (index > 0 && f.step <= out_.frames.back().step)
      rows_.fail(fmt::format("step {} comes after step {}", f.step, out_.frames.back().step),
                 "frames in ascending order");
    const std::optional<Domain> domain = domain_of(keys);
    rows_.read(f, n, domain);
    out_.frames.push_back(std::move(f));
    out_.domains.push_back(domain);
  }

  particle_text::Lines lines_;
  const std::string& name_;
  TextFrames out_;
  Rows rows_;
};

}  // namespace

TextFrames parse_extended_xyz(std::string_view text, const std::string& name) { return XyzReader(text, name).read(); }

}  // namespace talus
