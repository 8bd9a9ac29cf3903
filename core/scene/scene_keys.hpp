// The one table of all scene keys. The parser takes names, types, ranges and defaults from it, the help prints it, so
// the two cannot disagree. Who calls it: core/scene/scene_file.cpp, cases/ (talus help scene), tests (every example
// parses). Invariants: rows of one section are contiguous; every key has a one-line text and an example.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/suggest.hpp"

namespace talus {

enum class KeyType {
  number,          ///< integer or float
  number_or_none,  ///< number or the text "none"
  number_or_auto,  ///< number or the text "auto"
  integer,
  boolean,
  text,
  choice,     ///< one of SceneKey::choices
  vector,     ///< 3 numbers
  numbers,    ///< list of numbers
  cells,      ///< 3 integers
  text_pair,  ///< 2 texts
  id_range,   ///< 2 integers, ascending
  boundary    ///< one of the choices; or 3 entries, each a choice or a pair of choices
};

struct SceneKey {
  std::string_view section;  ///< "" = top of the file; "source.size" = table inside [[source]]
  std::string_view name;
  KeyType type;
  std::string_view unit;     ///< "" = not a quantity, "-" = dimensionless
  double low = 0, high = 0;  ///< range of each number, ends included unless low_open
  bool low_open = false;
  std::string_view choices;   ///< "a|b|c"
  std::string_view fallback;  ///< default as TOML; "required"; or "(text)": derived or absent
  std::string_view only;      ///< "kind=lattice|random": has a meaning only where that sibling key has such a value
  std::string_view doc;       ///< one line
  std::string_view example;   ///< value in TOML syntax
};

struct SceneSection {
  std::string_view name;
  bool repeated;  ///< [[name]], any number of times
  std::string_view doc;
};

std::span<const SceneKey> scene_keys() noexcept;
std::span<const SceneSection> scene_sections() noexcept;
/// The row of section.name, or nullptr.
const SceneKey* find_scene_key(std::string_view section, std::string_view name) noexcept;
const SceneSection* find_scene_section(std::string_view name) noexcept;

/// "section.name" (or "name" at the top of the file).
std::string full_name(const SceneKey& key);
/// What a value may be, e.g. "a number in (0, 1e+30] [m]" or "one of linear, hertz_mindlin".
std::string allowed_text(const SceneKey& key);

/// Help text. "": list of all keys with type, unit, range and default. A key ("contact.friction", or "friction": all
/// keys of that name) or section ("contact"): full text with example. Error{usage} with the nearest name for anything
/// else.
std::string scene_help(std::string_view key);

/// A complete small scene that contains the key's example; parse_scene accepts it (tested for every key).
std::string scene_key_example(const SceneKey& key);

}  // namespace talus
