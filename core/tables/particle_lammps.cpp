// LAMMPS and LIGGGHTS data files; see particle_formats.hpp. What has no meaning for spheres is read over and said;
// what would be read wrongly (other shapes, skewed boxes, other atom styles) is refused.
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "core/base/suggest.hpp"
#include "core/tables/particle_formats.hpp"
#include "core/tables/particle_text.hpp"

namespace talus {
namespace {

using namespace particle_text;

constexpr std::string_view k_shapes[] = {"ellipsoids", "lines", "triangles", "bodies"};
constexpr std::string_view k_links[] = {"bonds", "angles", "dihedrals", "impropers"};
constexpr std::string_view k_ignored[] = {"Masses", "Bonds", "Angles", "Dihedrals", "Impropers"};
constexpr std::string_view k_shape_sections[] = {"Ellipsoids", "Lines", "Triangles", "Bodies"};
constexpr const char* k_row = "atom_style sphere: id type diameter density x y z [3 image flags]";

template <std::size_t N>
bool among(std::string_view word, const std::string_view (&list)[N]) {
  return std::find(std::begin(list), std::end(list), word) != std::end(list);
}

std::string_view without_comment(std::string_view line) noexcept { return trim(line.substr(0, line.find('#'))); }

bool is_section(std::string_view line) { return !line.empty() && line.front() >= 'A' && line.front() <= 'Z'; }

class LammpsReader {
 public:
  LammpsReader(std::string_view text, const std::string& name, std::span<const Material> materials)
      : lines_(text), name_(name), materials_(materials) {}

  ParticleFile read() {
    std::string_view line;
    lines_.next(line);  // the first line is a title
    bool more = header();
    while (more) more = section();
    if (p_.size() == 0) error("no particles", "an Atoms section with as many rows as the header says");
    if (static_cast<std::int64_t>(p_.size()) != atoms_)
      error(fmt::format("{} particles, but the header says {}", p_.size(), atoms_), "");
    say();
    sort_by_id();
    return std::move(p_);
  }

 private:
  [[noreturn]] void error(const std::string& what, const std::string& cure) const {
    fail(name_, lines_.number(), what, cure);
  }

  template <class T>
  T number(std::string_view field, std::string_view what) const {
    T value{};
    const NumberState state = read_number(field, value);
    if (state == NumberState::syntax) error(fmt::format("{}: '{}' is not a number", what, shown(field)), "");
    if (state == NumberState::range)
      error(fmt::format("{}: '{}' is beyond the range of numbers", what, shown(field)), "");
    if constexpr (std::is_floating_point_v<T>) {
      if (!std::isfinite(value)) error(fmt::format("{}: '{}' is not finite", what, shown(field)), "");
    }
    return value;
  }

  // ------------------------------------------------------------------------------------------------------- header

  /// Header lines up to the first section's name; false at the end of the file.
  bool header() {
    std::string_view line;
    while (lines_.next(line)) {
      if (start_section(line)) {
        if (sides_[0] && sides_[1] && sides_[2]) p_.box = box_;
        return true;
      }
      line = without_comment(line);
      if (!line.empty()) header_line(line);
    }
    return false;
  }

  void header_line(std::string_view line) {
    split_blanks(line, fields_);
    std::size_t values = 0;
    double any = 0;
    while (values < fields_.size() && is_number(fields_[values], any)) ++values;
    std::string words;
    for (std::size_t k = values; k < fields_.size(); ++k) (words += words.empty() ? "" : " ") += fields_[k];
    if (values == 1 && words == "atoms") {
      atoms_ = number<std::int64_t>(fields_[0], "atoms");
    } else if (values == 2 && box_side(words)) {
      const int axis = words[0] - 'x';
      box_[0][axis] = number<double>(fields_[0], "box bound");
      box_[1][axis] = number<double>(fields_[1], "box bound");
      if (!(box_[0][axis] < box_[1][axis])) error(fmt::format("box bounds '{}' do not ascend", shown(line)), "");
      sides_[static_cast<std::size_t>(axis)] = true;
    } else if (values == 3 && words == "xy xz yz") {
      for (std::size_t k = 0; k < 3; ++k)
        if (number<double>(fields_[k], "tilt factor") != 0)
          error(fmt::format("the box is skewed ('{}')", shown(line)), "a box with tilt factors 0");
    } else if (values == 1 && among(words, k_shapes)) {
      if (any_of_first() != 0) error(fmt::format("{}: the particles are no spheres", shown(line)), "allowed: spheres");
    } else if (values == 1 && among(words, k_links)) {
      if (any_of_first() != 0) say_ignored(words);
    } else if (!(values == 1 && (words.ends_with(" types") || words.starts_with("extra ") || any_of_first() == 0))) {
      error(fmt::format("header line '{}' is not supported", shown(line)),
            "allowed: N atoms, N atom types, xlo xhi, ylo yhi, zlo zhi, and counts of what is ignored");
    }
  }

  static bool box_side(std::string_view words) {
    return words == "xlo xhi" || words == "ylo yhi" || words == "zlo zhi";
  }
  double any_of_first() const { return number<double>(fields_[0], "count"); }

  // ----------------------------------------------------------------------------------------------------- sections

  /// Keeps name and style of a section that begins here.
  bool start_section(std::string_view line) {
    const std::string_view bare = without_comment(line);
    if (!is_section(bare)) return false;
    section_ = bare;
    const std::size_t hash = line.find('#');
    style_ = hash == std::string_view::npos ? std::string_view{} : trim(line.substr(hash + 1));
    return true;
  }

  bool section() {
    if (section_ == "Atoms") return atoms();
    if (section_ == "Velocities") return velocities();
    if (among(section_, k_shape_sections)) {
      const std::string name = section_;
      if (row()) error(fmt::format("section '{}' describes other shapes than spheres", name), "allowed: spheres");
      return !ended_;
    }
    if (!among(section_, k_ignored) && !section_.ends_with(" Coeffs") && !section_.ends_with(" Labels")) {
      const std::vector<std::string> known{"Atoms", "Velocities", "Masses", "Pair Coeffs", "Bonds"};
      error(fmt::format("section '{}' is not supported{}", shown(section_),
                        section_.size() < 100 ? did_you_mean(section_, known) : ""),
            "allowed: Atoms (sphere), Velocities; ignored: Masses, coefficients, bonds and the like");
    }
    const std::string name = section_;
    bool any = false;
    while (row()) any = true;
    if (any) say_ignored(name);
    return !ended_;
  }

  /// The next data row of a section, split; false at the next section or the end.
  bool row() {
    std::string_view line;
    while (lines_.next(line)) {
      if (start_section(line)) return false;
      line = without_comment(line);
      if (line.empty()) continue;
      split_blanks(line, fields_);
      return true;
    }
    ended_ = true;
    return false;
  }

  void check_style() const {
    const std::string_view style = std::string_view(style_).substr(0, style_.find(' '));
    if (style.empty() || style == "sphere" || style == "granular") return;
    error(fmt::format("atom_style '{}' is not supported", shown(style)), k_row);
  }

  bool atoms() {
    check_style();
    if (p_.size() > 0) error("a second section Atoms", "one section Atoms");
    while (row()) atom();
    p_.v.assign(p_.size(), {});
    p_.w.assign(p_.size(), {});
    sorted_ = order_by(id_);
    for (std::size_t k = 1; k < sorted_.size(); ++k) {
      if (id_[sorted_[k]] == id_[sorted_[k - 1]])
        fail(name_, p_.row[sorted_[k]], fmt::format("id {} is given twice", id_[sorted_[k]]), "ids are unique");
    }
    return !ended_;
  }

  void atom() {
    if (fields_.size() != 7 && fields_.size() != 10)
      error(fmt::format("{} values in a row of Atoms", fields_.size()), k_row);
    const auto type = number<std::int64_t>(fields_[1], "type");
    if (type < 1 || type > static_cast<std::int64_t>(materials_.size()))
      error(fmt::format("type {} has no material", type), fmt::format("the scene has {} materials", materials_.size()));
    const Material& material = materials_[static_cast<std::size_t>(type - 1)];
    const double diameter = number<double>(fields_[2], "diameter"), density = number<double>(fields_[3], "density");
    if (!(diameter > 0)) error(fmt::format("diameter: {} is not allowed", diameter), "must be > 0");
    if (!(std::fabs(density - material.density) <= 1e-4 * material.density))
      error(fmt::format("density {} of type {} differs from {} of material '{}'", density, type, material.density,
                        material.name),
            fmt::format("give the material the file's density; {}", k_row));
    id_.push_back(number<std::int64_t>(fields_[0], "id"));
    p_.x.push_back({number<double>(fields_[4], "x"), number<double>(fields_[5], "y"), number<double>(fields_[6], "z")});
    p_.r.push_back(0.5 * diameter);
    p_.material.push_back(static_cast<std::uint8_t>(type - 1));
    p_.row.push_back(lines_.number());
  }

  bool velocities() {
    if (p_.size() == 0) error("Velocities before Atoms", "");
    if (!moving_.empty()) error("a second section Velocities", "one section Velocities");
    moving_.assign(p_.size(), 0);
    while (row()) {
      if (fields_.size() != 7)
        error(fmt::format("{} values in a row of Velocities", fields_.size()), "id vx vy vz wx wy wz");
      const auto id = number<std::int64_t>(fields_[0], "id");
      const auto at = std::lower_bound(sorted_.begin(), sorted_.end(), id,
                                       [&](std::size_t k, std::int64_t wanted) { return id_[k] < wanted; });
      if (at == sorted_.end() || id_[*at] != id) error(fmt::format("id {} is not among the atoms", id), "");
      if (moving_[*at] != 0) error(fmt::format("id {} is given twice", id), "ids are unique");
      moving_[*at] = 1;
      for (std::size_t k = 0; k < 3; ++k) {
        p_.v[*at][static_cast<int>(k)] = number<double>(fields_[1 + k], "velocity");
        p_.w[*at][static_cast<int>(k)] = number<double>(fields_[4 + k], "angular velocity");
      }
    }
    return !ended_;
  }

  // ------------------------------------------------------------------------------------------------------- result

  void say_ignored(const std::string& what) {
    if (std::find(ignored_.begin(), ignored_.end(), what) == ignored_.end()) ignored_.push_back(what);
  }

  void say() {
    std::string list;
    for (const std::string& s : ignored_) list += (list.empty() ? "" : ", ") + shown(s, 40);
    if (!list.empty()) p_.notes.push_back(fmt::format("{}: ignored: {}", name_, shown(list, 300)));
    const auto resting = std::count(moving_.begin(), moving_.end(), 0);
    if (resting > 0)
      p_.notes.push_back(fmt::format("{}: {} of {} particles have no row in Velocities and start at rest", name_,
                                     resting, moving_.size()));
  }

  static std::vector<std::size_t> order_by(const std::vector<std::int64_t>& key) {
    std::vector<std::size_t> order(key.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return key[a] < key[b]; });
    return order;
  }

  /// Other programs write atoms in any order; a state must not depend on it.
  void sort_by_id() {
    ParticleFile s;
    s.box = p_.box;
    s.notes = std::move(p_.notes);
    for (std::size_t k : sorted_) {
      s.x.push_back(p_.x[k]);
      s.v.push_back(p_.v[k]);
      s.w.push_back(p_.w[k]);
      s.r.push_back(p_.r[k]);
      s.material.push_back(p_.material[k]);
      s.row.push_back(p_.row[k]);
    }
    p_ = std::move(s);
  }

  Lines lines_;
  const std::string& name_;
  std::span<const Material> materials_;
  ParticleFile p_;
  std::vector<std::string_view> fields_;
  std::vector<std::int64_t> id_;
  std::vector<std::size_t> sorted_;
  std::vector<std::uint8_t> moving_;  ///< has a row in Velocities; empty without that section
  std::array<Vec3, 2> box_{};
  std::array<bool, 3> sides_{};
  std::string section_, style_;
  std::vector<std::string> ignored_;
  std::int64_t atoms_ = 0;
  bool ended_ = false;
};

}  // namespace

bool is_lammps_data(std::string_view text) {
  Lines lines(text);
  std::string_view line;
  std::vector<std::string_view> fields;
  for (int k = 0; k < 40 && lines.next(line); ++k) {
    split_blanks(without_comment(line).substr(0, 200), fields);
    std::int64_t n = 0;
    if (fields.size() == 2 && fields[1] == "atoms" && is_number(fields[0], n)) return true;
  }
  return false;
}

ParticleFile parse_lammps_data(std::string_view text, const std::string& name, std::span<const Material> materials) {
  return LammpsReader(text, name, materials).read();
}

}  // namespace talus
