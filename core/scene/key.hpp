// A key of a scene in one line: it binds a member of the scene, checks what a user may write there and documents it.
// Type and default follow from the member. Who uses it: core/scene/sections. To add a key, write its line in the table
// of its section:
//   key("lever", &ContactLaw::lever, "lever of the tangential force: ...", "\"radius\"").fixed("why").also({"arm"}),
#pragma once

#include <fmt/format.h>

#include <array>
#include <concepts>
#include <functional>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/base/words.hpp"
#include "core/scene/scene_keys.hpp"
#include "core/scene/scene_table.hpp"

namespace talus {

/// What each number of a value may be; ends included unless low_open.
struct KeyRange {
  double low, high;
  bool low_open = false;
};
inline constexpr double k_big = 1e30;     // beyond every physical quantity, still far from overflow of products
inline constexpr double k_length = 1e12;  // coordinates: cell indices of such a box still fit 64 bits
inline constexpr double k_count = 1e12;
inline constexpr KeyRange k_finite{-k_big, k_big}, k_positive{0, k_big, true}, k_not_negative{0, k_big};
inline constexpr KeyRange k_coordinate{-k_length, k_length}, k_size{0, k_length, true}, k_counted{0, k_count};

namespace key_detail {

template <class T>
constexpr KeyType type_of() {
  if constexpr (std::is_enum_v<T>) return KeyType::choice;
  if constexpr (std::is_same_v<T, bool>) return KeyType::boolean;
  if constexpr (std::is_same_v<T, double>) return KeyType::number;
  if constexpr (std::is_integral_v<T> && !std::is_same_v<T, bool>) return KeyType::integer;
  if constexpr (std::is_same_v<T, std::string>) return KeyType::text;
  if constexpr (std::is_same_v<T, Vec3>) return KeyType::vector;
  if constexpr (std::is_same_v<T, std::vector<double>>) return KeyType::numbers;
  if constexpr (std::is_same_v<T, std::array<int, 3>>) return KeyType::cells;
  if constexpr (std::is_same_v<T, Curve>) return KeyType::property;
  if constexpr (std::is_same_v<T, TimeTable>) return KeyType::series;
}

/// A member's initial value as TOML.
template <class T>
std::string text_of(const T& value) {
  if constexpr (std::is_enum_v<T>)
    return fmt::format("\"{}\"", enum_word(value));
  else if constexpr (std::is_same_v<T, std::string>)
    return fmt::format("\"{}\"", value);
  else if constexpr (std::is_same_v<T, Vec3>)
    return fmt::format("[{}, {}, {}]", value.x, value.y, value.z);
  else if constexpr (std::is_same_v<T, std::array<int, 3>>)
    return fmt::format("[{}, {}, {}]", value[0], value[1], value[2]);
  else if constexpr (std::is_same_v<T, std::vector<double>> || std::is_same_v<T, Curve> || std::is_same_v<T, TimeTable>)
    return "required";
  else
    return fmt::format("{}", value);
}

template <class T>
void read(const SceneTable& r, std::string_view name, T& value) {
  if constexpr (std::is_enum_v<T>)
    value = r.choice<T>(name);
  else if constexpr (std::is_same_v<T, bool>)
    value = r.boolean(name);
  else if constexpr (std::is_same_v<T, double>)
    value = r.number(name);
  else if constexpr (std::is_integral_v<T>)
    value = static_cast<T>(r.integer(name));
  else if constexpr (std::is_same_v<T, std::string>)
    value = r.text(name);
  else if constexpr (std::is_same_v<T, Vec3>)
    value = r.vector(name);
  else if constexpr (std::is_same_v<T, std::vector<double>>)
    value = r.numbers(name);
  else if constexpr (std::is_same_v<T, Curve>)
    value = r.curve(name);
  else if constexpr (std::is_same_v<T, TimeTable>)
    value = r.time_table(name);
  else {
    const std::vector<std::int64_t> cells = r.integers(name);
    for (std::size_t k = 0; k < 3; ++k) value[k] = static_cast<int>(cells[k]);
  }
}

}  // namespace key_detail

/// A key that fills a member of S, or of a class that derives from S. The methods say what the line says beyond that.
template <class S>
struct Key {
  SceneKey row;
  std::function<void(const SceneTable&, S&)> bind{};  ///< empty: the function of the section reads it
  std::optional<ResumeRule> rule{};                   ///< empty: that of the section

  Key(SceneKey words, std::function<void(const SceneTable&, S&)> reading = {})
      : row(std::move(words)), bind(std::move(reading)) {}
  template <class B>
  requires std::derived_from<S, B> Key(const Key<B>& other) : row(other.row), bind(other.bind), rule(other.rule) {}

  /// What holds where nothing is given: a default as TOML; "(in words)", and the member keeps its initial value;
  /// "required".
  Key absent(std::string text) && { return set(row.fallback, std::move(text)); }
  Key choices(std::string_view words) && { return set(row.choices, words); }
  Key required() && { return set(row.fallback, "required"); }
  /// Has a meaning only where a sibling key has one of the values: "kind=lattice|random".
  Key only(std::string_view cases) && { return set(row.only, cases); }
  /// Required where that sibling has one of these values.
  Key needed(std::string_view values, std::string text) && {
    row.needed = values;
    return set(row.fallback, std::move(text));
  }
  Key free() && { return set(rule, ResumeRule{AtResume::free, ""}); }
  Key acts() && { return set(rule, ResumeRule{AtResume::physics, ""}); }
  Key fixed(std::string_view why) && { return set(rule, ResumeRule{AtResume::fixed, why}); }
  Key also(std::initializer_list<KeyAlias> words) && { return set(row.also, words); }
  /// Words that users write for one of the choices.
  Key meaning(std::initializer_list<Meaning> words) && { return set(row.meanings, words); }
  /// Examples need this key, or `instead`, where the sibling has the value ("": always).
  Key usual(std::string_view value, std::string_view instead) && {
    row.usual_for = value.empty() ? "*" : value;
    return set(row.instead, instead);
  }
  /// Lines of [contact] without which an example of this key is no valid scene.
  Key with(std::string_view lines) && { return set(row.with, lines); }
  /// A line of its own section without which it is none.
  Key beside(std::string_view line) && { return set(row.beside, line); }

 private:
  template <class T>
  Key set(T& member, std::type_identity_t<T> value) {
    member = std::move(value);
    return std::move(*this);
  }
};

/// A number, a vector, a list of numbers or a triple of integers.
template <class S, class T>
Key<S> key(std::string_view name, T S::*member, std::string_view unit, KeyRange range, std::string_view doc,
           std::string_view example) {
  SceneKey row{.name = name, .doc = doc, .example = example};
  row.type = key_detail::type_of<T>();
  row.unit = unit;
  row.low = range.low;
  row.high = range.high;
  row.low_open = range.low_open;
  row.fallback = key_detail::text_of(S{}.*member);
  if constexpr (std::is_enum_v<T>) row.choices = enum_words(T{});
  return {std::move(row), [=](const SceneTable& r, S& s) { key_detail::read(r, name, s.*member); }};
}

/// A choice, a boolean or a text.
template <class S, class T>
Key<S> key(std::string_view name, T S::*member, std::string_view doc, std::string_view example) {
  return key(name, member, "", KeyRange{0, 0}, doc, example);
}

/// A direction, which is normalised; the zero vector is refused.
template <class S>
Key<S> direction_key(std::string_view name, Vec3 S::*member, std::string_view doc, std::string_view example) {
  Key<S> k = key(name, member, "-", k_finite, doc, example);
  k.bind = [=](const SceneTable& r, S& s) { s.*member = r.direction(name); };
  return k;
}

/// A key that the function of its section reads, since its value means something only together with others.
template <class S>
Key<S> other_key(std::string_view name, KeyType type, std::string_view unit, KeyRange range, std::string_view doc,
                 std::string_view example) {
  SceneKey row{.name = name, .type = type, .unit = unit, .doc = doc, .example = example};
  row.low = range.low;
  row.high = range.high;
  row.low_open = range.low_open;
  return {std::move(row)};
}
template <class S>
Key<S> text_key(std::string_view name, std::string_view doc, std::string_view example) {
  return other_key<S>(name, KeyType::text, "", {0, 0}, doc, example);
}

/// The rows of a section as the key table sees them.
class SectionKeys {
 public:
  SectionKeys(SceneSection section, std::vector<SceneKey> rows) : section_(section), rows_(std::move(rows)) {}
  const SceneSection& section() const noexcept { return section_; }
  const std::vector<SceneKey>& rows() const noexcept { return rows_; }

 protected:
  /// Error{scene} where a key is missing that the value of a sibling asks for.
  void check_needed(const SceneTable& r) const;

 private:
  SceneSection section_;
  std::vector<SceneKey> rows_;
};

/// The keys of a section, which fill an S.
template <class S>
class Keys : public SectionKeys {
 public:
  /// `rule`: at a resume, of the keys that name none.
  Keys(SceneSection section, ResumeRule rule, std::vector<Key<S>> keys)
      : SectionKeys(section, rows_of(section, rule, keys)), keys_(std::move(keys)) {}
  /// Fills the bound members; one that is absent and has no default keeps its value. Error{scene}.
  void read(const SceneTable& r, S& s) const {
    check_needed(r);
    for (const Key<S>& k : keys_)
      if (k.bind && (k.row.has_default() || r.has(k.row.name))) k.bind(r, s);
  }

 private:
  static std::vector<SceneKey> rows_of(const SceneSection& section, ResumeRule rule, const std::vector<Key<S>>& keys) {
    std::vector<SceneKey> rows;
    for (const Key<S>& k : keys) {
      rows.push_back(k.row);
      rows.back().section = section.name;
      rows.back().resume = k.rule.value_or(rule);
    }
    return rows;
  }
  std::vector<Key<S>> keys_;
};

inline constexpr ResumeRule k_free{AtResume::free, ""}, k_acts{AtResume::physics, ""};
constexpr ResumeRule fixed_by(std::string_view why) { return {AtResume::fixed, why}; }

}  // namespace talus
