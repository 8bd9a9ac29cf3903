// The keys of a grain file: the one table from which the reader takes ranges and defaults and the help its text. Who
// calls it: core/conversion/grain_file.cpp, cases/ (talus help grain), tests. Invariant: rows of a section are
// together.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace talus::conversion {

enum class GrainKeyType {
  number,
  integer,
  boolean,
  text,
  choice,
  property,      ///< of temperature: a number, { polynomial, origin, range } or { table }
  series,        ///< over time: a number or a list of [time, value]
  one_or_three,  ///< a number or 3 numbers
  shares         ///< table of names with numbers
};

struct GrainKey {
  std::string_view section, name;
  GrainKeyType type;
  std::string_view unit;
  double low, high;  ///< of every number in it; low is left out where low_open
  bool low_open;
  std::string_view choices;   ///< "a|b"
  std::string_view fallback;  ///< TOML, "required", or "(text)": absent or derived
  std::string_view doc, example;
};

struct GrainSection {
  std::string_view name;
  bool repeated;
  std::string_view doc;
};

std::span<const GrainKey> grain_keys() noexcept;
std::span<const GrainSection> grain_sections() noexcept;
/// "a number in (0, 1000] [m]".
std::string allowed_text(const GrainKey& key);
/// All keys, or those of a section or name. Error{usage} with the nearest name.
std::string grain_help(std::string_view key);

}  // namespace talus::conversion
