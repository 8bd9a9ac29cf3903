// What a key of a scene is, in words: the parser takes names, types, ranges and defaults from it, the help and the
// reference print it, suggestions and the rules of a resume follow from it. The keys themselves stand in
// core/scene/sections, one line each. Who calls it: core/scene, cases/ (talus help scene), tests (every example
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
  property,   ///< of temperature: a number, a polynomial or a table
  series,     ///< over time: a number, or pairs [time, value]
  boundary    ///< one of the choices; or 3 entries, each a choice or a pair of choices
};

/// What a resumed run may do with a key.
enum class AtResume {
  free,     ///< outside the trajectory: outputs, list, length of the run
  physics,  ///< acts from the resumed step on
  fixed     ///< the state depends on it: refused
};
struct ResumeRule {
  AtResume rule = AtResume::physics;
  std::string_view why{};  ///< of a refusal
};

/// Word of other codes or of everyday language for a key.
struct KeyAlias {
  std::string_view word;
  std::string_view within{};  ///< counts only below this section; "" anywhere
  std::string_view remark{};
  constexpr KeyAlias(const char* w, std::string_view below = {}, std::string_view said = {})
      : word(w), within(below), remark(said) {}
};

struct SceneKey {
  std::string_view section{};  ///< "" = top of the file; "source.size" = table inside [[source]]
  std::string_view name;
  KeyType type = KeyType::text;
  std::string_view unit{};   ///< "" = not a quantity, "-" = dimensionless
  double low = 0, high = 0;  ///< range of each number, ends included unless low_open
  bool low_open = false;
  std::string_view choices{};  ///< "a, b, c"
  std::string fallback{};      ///< default as TOML; "required"; or "(text)": derived or absent
  std::string_view only{};     ///< "kind=lattice|random": has a meaning only where that sibling key has such a value
  std::string_view needed{};   ///< "box|mesh": required where the key that decides has such a value
  std::string_view doc;        ///< one line
  std::string_view example;    ///< value in TOML syntax
  ResumeRule resume{};
  std::vector<KeyAlias> also{};
  std::vector<Meaning> meanings{};  ///< of words that are no choice
  std::string_view usual_for{};  ///< examples of other keys give this one where the key that decides has this value ...
  std::string_view instead{};    ///< ... unless they are about this key, which takes its place
  std::string_view with{};       ///< lines of [contact] that make an example of the key complete
  std::string_view beside{};     ///< a line of its own section that does

  bool required() const noexcept { return fallback == "required"; }
  bool has_default() const noexcept { return !required() && !fallback.starts_with('('); }
};

struct SceneSection {
  std::string_view name;
  bool repeated;  ///< [[name]], any number of times
  std::string_view doc;
};

std::span<const SceneKey> scene_keys();
std::span<const SceneSection> scene_sections();
/// The row of section.name, or nullptr.
const SceneKey* find_scene_key(std::string_view section, std::string_view name);
const SceneSection* find_scene_section(std::string_view name);

/// The parts of "a, b, c" or "a|b|c".
std::vector<std::string_view> split_words(std::string_view words, std::string_view separator);
/// "kind=lattice|random" in its parts; no key: it always holds.
struct KeyCondition {
  std::string_view key{};
  std::vector<std::string_view> values{};
  std::string text() const;  ///< "lattice, random"
  bool holds(std::string_view value) const;
};
KeyCondition condition_of(std::string_view only);
std::string header_text(const SceneSection& section);  ///< "[[wall]]"

/// "section.name" (or "name" at the top of the file).
std::string full_name(const SceneKey& key);
/// What a value may be, e.g. "a number in (0, 1e+30] [m]" or "one of linear, hertz_mindlin".
std::string allowed_text(const SceneKey& key);

/// Help text. "": list of all keys with type, unit, range and default. A key ("contact.friction", or "friction": all
/// keys of that name) or section ("contact"): full text with example. Any other word: the keys whose text has it.
/// Error{usage} with the nearest name for anything else.
std::string scene_help(std::string_view key);

/// A complete small scene that contains the key's example; parse_scene accepts it (tested for every key).
std::string scene_key_example(const SceneKey& key);

}  // namespace talus
