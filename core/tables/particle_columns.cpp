// See particle_columns.hpp.
#include "core/tables/particle_columns.hpp"

#include <algorithm>
#include <iterator>
#include <vector>

namespace talus {
namespace {

using Column = ParticleColumn;

constexpr std::string_view k_names[] = {"x",     "y",     "z",        "radius", "vx",       "vy",      "vz",   "wx",
                                        "wy",    "wz",    "material", "fixed",  "diameter", "density", "type", "id",
                                        "shape", "scale", "qw",       "qx",     "qy",       "qz",      "body"};

// Words that may stand beside what decides; a name with any other word ("initial position x") means nothing here.
constexpr std::string_view k_filler[] = {"particle", "particles", "grain", "sphere", "centre", "center", "component"};
constexpr std::string_view k_position[] = {"position",   "positions",   "pos",   "point", "points",
                                           "coordinate", "coordinates", "coord", "coords"};
constexpr std::string_view k_velocity[] = {"velocity", "velocities", "vel", "v"};
constexpr std::string_view k_linear[] = {"linear", "translational"};  // only beside a velocity
constexpr std::string_view k_angular[] = {"angular", "ang", "rotational"};
constexpr std::string_view k_spin[] = {"omega", "spin", "angvel", "angularvelocity", "w"};

template <std::size_t N>
bool among(std::string_view word, const std::string_view (&list)[N]) {
  return std::find(std::begin(list), std::end(list), word) != std::end(list);
}

std::string lower(std::string_view s) {
  std::string out(s);
  for (char& c : out)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return out;
}

/// Takes "(m/s)" or the like off the end of a name.
std::string take_unit(std::string& name) {
  while (!name.empty() && name.back() == ' ') name.pop_back();
  if (name.empty()) return {};
  const std::size_t kind = std::string_view(")]}>").find(name.back());
  if (kind == std::string_view::npos) return {};
  const std::size_t open = name.rfind("([{<"[kind]);
  if (open == std::string::npos || open == 0) return {};
  const std::string unit = name.substr(open + 1, name.size() - open - 2);
  name.resize(open);
  while (!name.empty() && name.back() == ' ') name.pop_back();
  return unit;
}

/// Letters and digits between everything else; "Q01 :" of EDEM is no word.
std::vector<std::string> words_of(const std::string& name) {
  std::vector<std::string> words(1);
  for (const char c : name) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || static_cast<unsigned char>(c) >= 0x80;
    if (letter)
      words.back() += c;
    else if (!words.back().empty())
      words.emplace_back();
  }
  if (words.back().empty()) words.pop_back();
  const auto is_query = [](const std::string& w) {
    return w.size() > 1 && w[0] == 'q' && w.find_first_not_of("0123456789", 1) == std::string::npos;
  };
  if (words.size() > 1 && is_query(words[0])) words.erase(words.begin());
  return words;
}

/// Axis of a word that ends with x, y or z behind a word of one of the lists ("posx", "vy"), split in two.
void split_axis(std::vector<std::string>& words) {
  if (words.size() != 1 || words[0].size() < 2) return;
  const char last = words[0].back();
  const std::string stem = words[0].substr(0, words[0].size() - 1);
  if (last < 'x' || last > 'z' || !(among(stem, k_position) || among(stem, k_velocity) || among(stem, k_spin))) return;
  words = {stem, std::string(1, last)};
}

int axis_of(const std::string& word) {
  if (word.size() != 1) return -1;
  if (word[0] >= 'x' && word[0] <= 'z') return word[0] - 'x';
  return word[0] >= '0' && word[0] <= '2' ? word[0] - '0' : -1;
}

/// A component of a quaternion.
Column turn_of(const std::string& word) {
  constexpr std::string_view letters = "wxyz", digits = "0123";
  if (word.size() != 1) return Column::none;
  const std::size_t k = std::min(letters.find(word[0]), digits.find(word[0]));
  return k == std::string_view::npos ? Column::none : static_cast<Column>(static_cast<std::size_t>(Column::qw) + k);
}

Column meaning_of(std::vector<std::string> words) {
  if (words.size() == 2 && (words[0] == "orientation" || words[0] == "quaternion")) return turn_of(words[1]);
  split_axis(words);
  int axis = -1;
  bool position = false, velocity = false, linear = false, angular = false, spin = false, digit = false;
  std::string other;
  for (const std::string& word : words) {
    if (const int a = axis_of(word); a >= 0) {
      if (axis >= 0) return Column::none;
      axis = a;
      digit = word[0] <= '2';
    } else if (among(word, k_filler)) {
      continue;
    } else if (among(word, k_linear)) {
      linear = true;
    } else if (among(word, k_angular)) {
      angular = true;
    } else if (among(word, k_position)) {
      position = true;
    } else if (among(word, k_velocity)) {
      velocity = true;
    } else if (among(word, k_spin)) {
      spin = true;
    } else if (other.empty()) {
      other = word;
    } else {
      return Column::none;
    }
  }
  if ((linear || angular) && !velocity) return Column::none;
  if (axis < 0) {
    if (position || velocity || spin) return Column::none;
    if (other == "r" || other == "radius" || other == "rad" || other == "radii") return Column::radius;
    if (other == "d" || other == "diameter" || other == "dia" || other == "diam") return Column::diameter;
    const auto* at = std::find(std::begin(k_names), std::end(k_names), other);
    return at == std::end(k_names) ? Column::none : static_cast<Column>(at - std::begin(k_names));
  }
  if (!other.empty() || (position && (velocity || spin)) || (linear && (angular || spin))) return Column::none;
  const auto along = [axis](Column first) { return static_cast<Column>(static_cast<int>(first) + axis); };
  if (spin || angular) return along(Column::wx);
  if (velocity) return along(Column::vx);
  // "0" alone names nothing
  return position || !digit ? along(Column::x) : Column::none;
}

}  // namespace

ColumnMeaning column_meaning(std::string_view name) {
  ColumnMeaning m;
  std::string text = lower(name);
  m.unit = take_unit(text);
  m.column = meaning_of(words_of(text));
  m.own = m.column != Column::none && (text == column_name(m.column) || text == "r");
  return m;
}

std::string_view column_name(ParticleColumn column) noexcept {
  return column == Column::none ? std::string_view{} : k_names[static_cast<std::size_t>(column)];
}

}  // namespace talus
