// SceneTable: one table of a scene text, checked against the key table on construction; the TOML parser stays behind
// it. Who calls it: core/scene/scene_file.cpp only. Invariants: a getter never sees an unknown key, a wrong type or a
// value out of range; values that are absent come from the key table's default; every error names file:line:col or
// "--set key=value".
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/curve.hpp"
#include "core/base/types.hpp"

namespace talus {

struct TomlNode;

/// One key that a scene gives, with its value in normal form: equal values have equal texts.
struct SceneValue {
  std::string path;           ///< "wall.0.motion.velocity"
  std::string section, name;  ///< "wall.motion", "velocity": its row in the key table
  std::string value;          ///< TOML
};

class SceneTable {
 public:
  /// Parses `text` with the guards of the format (core/scene/scene_text.hpp), applies the
  /// overrides and checks the top level. Error{scene} with file:line:col.
  static SceneTable parse(std::string_view text, const std::string& name, const std::vector<std::string>& overrides);

  /// All keys that are given, here and in the sections below, in the order of the key table.
  std::vector<SceneValue> values() const;

  bool has(std::string_view name) const;
  double number(std::string_view name) const;
  double number_or(std::string_view name, double fallback) const { return has(name) ? number(name) : fallback; }
  /// A number, or nothing for the text "none".
  std::optional<double> number_or_text(std::string_view name) const;
  std::int64_t integer(std::string_view name) const;
  bool boolean(std::string_view name) const;
  std::string text(std::string_view name) const;
  Vec3 vector(std::string_view name) const;
  Vec3 direction(std::string_view name) const;  ///< normalised; Error{scene} for the zero vector
  std::vector<double> numbers(std::string_view name) const;
  /// A property of temperature. Error{scene} where a polynomial leaves the range of the key.
  Curve curve(std::string_view name) const;
  TimeTable time_table(std::string_view name) const;
  std::vector<std::int64_t> integers(std::string_view name) const;
  std::vector<std::string> texts(std::string_view name) const;
  /// Words per axis and side of a boundary key.
  std::array<std::array<std::string, 2>, 3> boundary(std::string_view name) const;
  /// The choice as an enum whose enumerators are declared in the key table's order.
  template <class E>
  E choice(std::string_view name) const {
    return static_cast<E>(choice_index(name));
  }
  /// Index of a text in `names`; entry >= 0: of that element of a list. Error{scene} with the nearest name.
  int index(std::string_view name, const std::vector<std::string>& names, std::string_view what, int entry = -1) const;

  void require(std::string_view name, std::string_view why) const;
  void exclusive(std::string_view a, std::string_view b) const;  ///< both given: Error{scene} at b
  [[noreturn]] void fail(std::string_view name, const std::string& allowed) const;
  [[noreturn]] void missing(std::string_view name, std::string_view why = {}) const;

  SceneTable section(std::string_view name) const;                ///< an absent one reads as empty
  std::vector<SceneTable> sections(std::string_view name) const;  ///< [[name]], in order

 private:
  struct Text;
  SceneTable(std::shared_ptr<const Text> text, const TomlNode* table, std::string section, std::string path);
  int choice_index(std::string_view name) const;
  std::string child(std::string_view name) const;
  std::string full(std::string_view name) const;

  std::shared_ptr<const Text> text_;
  const TomlNode* table_;  ///< owned by *text_; nullptr: absent section
  std::string section_, path_;
};

}  // namespace talus
