// Tables of particles: CSV and its relatives. See particle_formats.hpp.
#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/suggest.hpp"
#include "core/tables/particle_formats.hpp"
#include "core/tables/particle_header.hpp"

namespace talus {
namespace {

using namespace particle_text;
using Column = ParticleColumn;

class TableReader {
 public:
  TableReader(std::string_view text, const std::string& name, std::span<const Material> materials,
              std::span<const ShapeSpec> shapes, int shape)
      : lines_(text), name_(name), materials_(materials), shapes_(shapes), shape_(shape) {}

  ParticleFile read() {
    h_ = read_header(lines_, name_, p_.notes, shape_ >= 0);
    bodies_ = shape_ >= 0 || h_.has(Column::shape);
    for (Column& c : h_.meaning)
      if (c == Column::body || (c >= Column::scale && c < Column::none && !bodies_)) c = Column::none;
    for (std::size_t k = 0; k < h_.meaning.size(); ++k)
      if (h_.meaning[k] != Column::none) used_.push_back(k);
    with_density_ = checks_density();
    if (h_.has(Column::density) && !with_density_)
      std::erase_if(used_, [&](std::size_t k) { return h_.meaning[k] == Column::density; });
    say_ignored();
    Splitter splitter(h_.separator);
    if (h_.first_row_read) row(splitter);
    std::string_view line;
    while (lines_.next(line))
      if (!line.empty() && !is_comment(line)) row(splitter);
    if (p_.size() == 0) fail(name_, lines_.number(), "no particles", "a header row, then one row per particle");
    unique_ids();
    if (comma_row_ > 0) p_.notes.push_back(fmt::format("{}: decimal commas are read as decimal points", name_));
    return std::move(p_);
  }

 private:
  [[noreturn]] void refuse(const std::string& what, const std::string& cure = {}) const {
    fail(name_, lines_.number(), what, cure);
  }
  const std::string& name_of(std::size_t field) const { return h_.names[field]; }

  void say_ignored() {
    std::string list;
    std::size_t count = 0;
    constexpr std::size_t most = 8;
    for (std::size_t k = 0; k < h_.names.size(); ++k) {
      const Column c = h_.meaning[k];
      const bool looked_at =
          c != Column::none && c != Column::type && c != Column::id && (c != Column::density || checks_density());
      if (looked_at || h_.names[k].empty()) continue;
      if (++count <= most) list += (list.empty() ? "'" : ", '") + shown(h_.names[k], 40) + "'";
    }
    if (count > most) list += fmt::format(" and {} more", count - most);
    if (count > 0)
      p_.notes.push_back(fmt::format("{}: ignored: {} {}", name_, count == 1 ? "column" : "columns", list));
  }

  /// Only where the file says of which material a particle is, or where there is one only.
  bool checks_density() const {
    return h_.has(Column::density) && (h_.has(Column::material) || materials_.size() == 1);
  }

  void row(Splitter& splitter) {
    // separators at the ends of a line may be tabs, which a trimmed line has lost
    if (!splitter.split(h_.separator == '\t' ? lines_.raw() : trim(lines_.raw())))
      refuse("a quote is not closed, or text follows it", "quotes around whole values");
    const auto fields = splitter.fields();
    if (fields.size() != h_.names.size() && !mended(fields)) return;
    if (std::all_of(fields.begin(), fields.end(), [](std::string_view f) { return f.empty(); })) return;
    std::array<double, k_particle_columns> value{};
    std::uint8_t material = 0;
    std::int32_t shape = shape_;
    for (const std::size_t k : used_) {
      const Column c = h_.meaning[k];
      if (c == Column::material)
        material = material_of(fields[k]);
      else if (c == Column::type)
        same_type(fields[k]);
      else if (c == Column::id)
        keep_id(fields[k]);
      else if (c == Column::shape)
        shape = shape_of(fields[k]);
      else if (!(c >= Column::scale && c <= Column::qz && fields[k].empty()))  // of a sphere
        value[static_cast<std::size_t>(c)] = c == Column::fixed ? flag(k, fields[k]) : number(k, fields[k]);
    }
    if (shape >= 0)
      add_body(value, material, shape);
    else
      add(value, material);
  }

  /// Empty fields at the end, for which the header has or lacks a name, do no harm. False: an empty row.
  bool mended(std::span<const std::string_view> fields) const {
    const std::size_t named = h_.names.size(), given = fields.size();
    bool empty = true, harmless = true;
    for (const std::string_view f : fields) empty = empty && f.empty();
    for (std::size_t k = named; k < given; ++k) harmless = harmless && fields[k].empty();
    for (std::size_t k = given; k < named; ++k) harmless = harmless && h_.names[k].empty();
    if (!harmless && !empty)
      refuse(fmt::format("{} {}, but the header names {} columns", given, given == 1 ? "value" : "values", named),
             "one value per column");
    return !empty;
  }

  double number(std::size_t field, std::string_view text) {
    double v = 0;
    NumberState state = read_number(text, v);
    if (h_.separator != ',') {
      if (state == NumberState::syntax && std::count(text.begin(), text.end(), ',') == 1) {
        std::string point(text);
        point[point.find(',')] = '.';
        if (text.find('.') == std::string_view::npos) state = read_number(std::string_view(point), v);
        if (state == NumberState::good && comma_row_ == 0) comma_row_ = lines_.number();
      } else if (point_row_ == 0 && text.find('.') != std::string_view::npos) {
        point_row_ = lines_.number();
      }
      if (comma_row_ > 0 && point_row_ > 0)
        refuse(fmt::format("decimal commas (line {}) and decimal points (line {}) in one file", comma_row_, point_row_),
               "one of the two throughout");
    }
    const auto what = [&](const char* why) {
      return fmt::format("{}: '{}' {}", shown(name_of(field)), shown(text), why);
    };
    if (state == NumberState::syntax) refuse(what("is not a number"));
    if (state == NumberState::range) refuse(what("is beyond the range of numbers"));
    if (!std::isfinite(v)) refuse(what("is not finite"));
    return v;
  }

  double flag(std::size_t field, std::string_view text) {
    if (text == "true" || text == "TRUE" || text == "True") return 1;
    if (text == "false" || text == "FALSE" || text == "False") return 0;
    const double v = number(field, text);
    if (v != 0 && v != 1) refuse(fmt::format("fixed: {} is not allowed", v), "must be 0 or 1");
    return v;
  }

  std::uint8_t material_of(std::string_view text) {
    if (!last_material_.empty() && text == last_material_) return last_index_;  // most rows name the same
    std::vector<std::string> names;
    std::size_t found = materials_.size();
    for (std::size_t i = 0; i < materials_.size(); ++i) {
      if (materials_[i].name == text) found = i;
      names.push_back(materials_[i].name);
    }
    double index = 0;
    if (found == materials_.size() && is_number(text, index) && index >= 0 && index == std::floor(index) &&
        index < static_cast<double>(materials_.size()))
      found = static_cast<std::size_t>(index);
    if (found == materials_.size()) {
      std::string list;
      for (const std::string& s : names) list += (list.empty() ? "" : ", ") + s;
      refuse(fmt::format("material '{}' does not exist{}", shown(text), did_you_mean(text.substr(0, 200), names)),
             fmt::format("allowed: {}, or an index from 0 to {}", shown(list, 120),
                         static_cast<std::int64_t>(materials_.size()) - 1));
    }
    last_material_ = text;
    last_index_ = static_cast<std::uint8_t>(found);
    return last_index_;
  }

  /// Name or index of a shape; -1: a sphere.
  std::int32_t shape_of(std::string_view text) {
    if (text.empty() || text == "-") return -1;
    std::vector<std::string> names;
    std::string list;
    for (std::size_t i = 0; i < shapes_.size(); ++i) {
      if (shapes_[i].name == text) return static_cast<std::int32_t>(i);
      names.push_back(shapes_[i].name);
      list += (list.empty() ? "" : ", ") + names.back();
    }
    std::int32_t index = 0;
    if (is_number(text, index) && index >= 0 && index < std::ssize(shapes_)) return index;
    refuse(fmt::format("shape '{}' does not exist{}", shown(text), did_you_mean(text.substr(0, 200), names)),
           list.empty() ? "[[shape]] in a scene says what it is"
                        : fmt::format("allowed: {}, an index from 0 to {}, or - for a sphere", shown(list, 120),
                                      std::ssize(shapes_) - 1));
  }

  /// A type says nothing about materials here; that is harmless only while there is nothing to say.
  void same_type(std::string_view text) {
    if (p_.size() == 0) type_ = text;
    if (text != type_ && materials_.size() > 1 && !h_.has(Column::material))
      refuse("column 'type' has several values, but does not say which material each is",
             "name the column 'material' (names, or indices from 0)");
  }

  /// Ids are of use where they are unique numbers; a scene numbers its grains itself.
  void keep_id(std::string_view text) {
    std::int64_t id = 0;
    const bool good = is_number(text, id) && id >= 0;
    if (good && p_.id.size() == p_.size()) p_.id.push_back(id);
  }
  void unique_ids() {
    std::vector<std::int64_t> sorted = p_.id;
    std::sort(sorted.begin(), sorted.end());
    if (p_.id.size() != p_.size() || std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end()) p_.id.clear();
  }

  using Values = std::array<double, k_particle_columns>;
  static double at(const Values& value, Column c) { return value[static_cast<std::size_t>(c)]; }

  /// Radius as the row states it, 0 for none.
  double radius_of(const Values& value) const {
    const bool with_radius = h_.has(Column::radius), with_diameter = h_.has(Column::diameter);
    const double r = with_radius ? at(value, Column::radius) : 0.5 * at(value, Column::diameter);
    if (with_radius && with_diameter && r > 0 && !(std::fabs(at(value, Column::diameter) - 2 * r) <= 2e-4 * r))
      refuse(fmt::format("diameter {} is not twice the radius {}", at(value, Column::diameter), r), "");
    return r;
  }

  void add(const Values& value, std::uint8_t material) {
    const Column size = h_.has(Column::radius) || !h_.has(Column::diameter) ? Column::radius : Column::diameter;
    const double r = radius_of(value), scale = at(value, Column::scale);
    if (!(r > 0)) refuse(fmt::format("{}: {} is not allowed", column_name(size), at(value, size)), "must be > 0");
    if (scale != 0 && scale != 1) refuse(fmt::format("scale: {} is not allowed", scale), "of a sphere none, 0 or 1");
    if (with_density_) check_density(at(value, Column::density), material);
    append(value, material, r);
    if (!bodies_) return;
    p_.shape.push_back(-1);
    p_.scale.push_back(1);
    p_.turn.push_back({1, 0, 0, 0});
  }

  void add_body(const Values& value, std::uint8_t material, std::int32_t shape) {
    const double r = radius_of(value), scale = at(value, Column::scale);
    const char* const size = "a body has a scale > 0, or radius or diameter of the sphere of equal volume";
    if (!(scale >= 0)) refuse(fmt::format("scale: {} is not allowed", scale), size);
    if (!(r >= 0)) refuse(fmt::format("radius: {} is not allowed", r), size);
    if (scale == 0 && r == 0) refuse("a body without a size", size);
    std::array<double, 4> q{1, 0, 0, 0};
    if (h_.has(Column::qw)) {
      double sum = 0;
      for (int k = 0; k < 4; ++k) {
        q[static_cast<std::size_t>(k)] = at(value, static_cast<Column>(static_cast<int>(Column::qw) + k));
        sum += q[static_cast<std::size_t>(k)] * q[static_cast<std::size_t>(k)];
      }
      // files have few digits; what is farther off was not meant as a turn
      if (!(std::fabs(sum - 1) <= 2e-3))
        refuse(fmt::format("the quaternion {}, {}, {}, {} is no unit quaternion", q[0], q[1], q[2], q[3]),
               "qw^2 + qx^2 + qy^2 + qz^2 = 1");
      for (double& c : q) c /= std::sqrt(sum);
    }
    append(value, material, r);
    p_.shape.push_back(shape);
    p_.scale.push_back(scale);
    p_.turn.push_back(q);
  }

  void append(const Values& value, std::uint8_t material, double r) {
    const auto at = [&](Column c) { return TableReader::at(value, c); };
    p_.x.push_back({at(Column::x), at(Column::y), at(Column::z)});
    p_.r.push_back(r);
    p_.v.push_back({at(Column::vx), at(Column::vy), at(Column::vz)});
    p_.w.push_back({at(Column::wx), at(Column::wy), at(Column::wz)});
    p_.row.push_back(lines_.number());
    if (h_.has(Column::material)) p_.material.push_back(material);
    if (h_.has(Column::fixed)) p_.fixed.push_back(at(Column::fixed) == 1);
  }

  void check_density(double density, std::uint8_t material) const {
    const Material& m = materials_[material];
    if (!(std::fabs(density - m.density) <= 1e-4 * m.density))
      refuse(fmt::format("density {} differs from {} of material '{}'", density, m.density, m.name),
             "give the material the file's density");
  }

  Lines lines_;
  const std::string& name_;
  std::span<const Material> materials_;
  std::span<const ShapeSpec> shapes_;
  std::int32_t shape_ = -1;  ///< of rows that name none
  bool bodies_ = false;      ///< rows may be bodies
  ParticleFile p_;
  Header h_;
  std::vector<std::size_t> used_;
  std::string last_material_, type_;
  std::uint8_t last_index_ = 0;
  std::int64_t comma_row_ = 0, point_row_ = 0;
  bool with_density_ = false;
};

}  // namespace

ParticleFile parse_particle_table(std::string_view text, const std::string& name, std::span<const Material> materials,
                                  std::span<const ShapeSpec> shapes, int shape) {
  return TableReader(text, name, materials, shapes, shape).read();
}

}  // namespace talus
