// The help made from the key table; see scene_keys.hpp.
#include <fmt/format.h>

#include "core/base/error.hpp"
#include "core/scene/key.hpp"
#include "core/scene/scene_search.hpp"
#include "core/scene/scene_suggest.hpp"

namespace talus {

std::string header_text(const SceneSection& s) {
  if (s.name.empty()) return "top of the file";
  return s.repeated ? fmt::format("[[{}]]", s.name) : fmt::format("[{}]", s.name);
}

namespace {

std::string range_text(const SceneKey& k) {
  const bool bounded_low = k.low > -k_length, bounded_high = k.high < k_length;
  if (bounded_low && bounded_high) return fmt::format("in {}{:g}, {:g}]", k.low_open ? '(' : '[', k.low, k.high);
  if (bounded_low) return fmt::format("{} {:g}", k.low_open ? ">" : ">=", k.low);
  return "finite";
}

std::string unit_text(const SceneKey& k) { return k.unit.empty() ? "" : fmt::format(" [{}]", k.unit); }

std::string default_text(const SceneKey& k) {
  if (k.required()) return "required";
  if (k.fallback.starts_with("(required")) return std::string(k.fallback.substr(1, k.fallback.size() - 2));
  return "default " + std::string(k.fallback);
}

std::string one_line(const SceneKey& k) {
  return fmt::format("  {:<32} {}; {}\n", full_name(k), allowed_text(k), default_text(k));
}

std::string full_text(const SceneKey& k) {
  std::string s = fmt::format("{}\n  {}\n  value:   {}\n  default: {}\n", full_name(k), k.doc, allowed_text(k),
                              k.fallback.starts_with('(') ? k.fallback.substr(1, k.fallback.size() - 2) : k.fallback);
  if (const KeyCondition only = condition_of(k.only); !only.key.empty())
    s += fmt::format("  only for: {} = {}\n", only.key, only.text());
  const SceneSection* section = find_scene_section(k.section);
  s += "  example:\n";
  if (!k.section.empty()) s += fmt::format("    {}\n", header_text(*section));
  return s + fmt::format("    {} = {}\n", k.name, k.example);
}

}  // namespace

std::string allowed_text(const SceneKey& k) {
  const std::string unit = unit_text(k);
  switch (k.type) {
    case KeyType::number:
      return "a number " + range_text(k) + unit;
    case KeyType::number_or_none:
      return "a number " + range_text(k) + unit + " or \"none\"";
    case KeyType::number_or_auto:
      return "a number " + range_text(k) + unit + " or \"auto\"";
    case KeyType::integer:
      return "an integer " + range_text(k) + unit;
    case KeyType::boolean:
      return "true or false";
    case KeyType::text:
      return "a text of one line in quotes, without control characters";
    case KeyType::choice:
      return "one of " + std::string(k.choices);
    case KeyType::vector:
      return "[x, y, z], 3 numbers, each " + range_text(k) + unit;
    case KeyType::numbers:
      return "a list of numbers, each " + range_text(k) + unit;
    case KeyType::cells:
      return "[nx, ny, nz], 3 integers, each " + range_text(k);
    case KeyType::text_pair:
      return "[\"a\", \"b\"], 2 texts of one line";
    case KeyType::id_range:
      return "[first, last], 2 ascending integers, each " + range_text(k);
    case KeyType::property:
      return "a number " + range_text(k) + unit +
             ", { table = [[T, value], ...] } or { polynomial = [c0, c1, ...], origin = T0, range = [T1, T2] }";
    case KeyType::series:
      return "a number " + range_text(k) + unit + " or [[time, value], ...] with ascending times [s]";
    case KeyType::boundary:
      return "one of " + std::string(k.choices) + "; or 3 entries, each such a word or a pair [lower, upper] of words";
  }
  return {};
}

std::string scene_help(std::string_view key) {
  std::string text;
  if (key.empty()) {
    for (const SceneSection& s : scene_sections()) {
      text += fmt::format("{}: {}\n", header_text(s), s.doc);
      for (const SceneKey& k : scene_keys()) {
        if (k.section == s.name) text += one_line(k);
      }
      text += '\n';
    }
    return text;
  }
  for (const SceneKey& k : scene_keys())
    if (full_name(k) == key) return full_text(k);
  for (const SceneSection& s : scene_sections()) {
    if (s.name.empty() || s.name != key) continue;
    text = fmt::format("{}: {}\n\n", header_text(s), s.doc);
    for (const SceneKey& k : scene_keys()) {
      if (k.section == s.name) text += full_text(k) + "\n";
    }
    for (const SceneSection& inner : scene_sections()) {
      if (inner.name.starts_with(std::string(s.name) + "."))
        text += fmt::format("{}: {} (see '{}')\n", header_text(inner), inner.doc, inner.name);
    }
    return text;
  }
  for (const SceneKey& k : scene_keys())
    if (k.name == key) text += (text.empty() ? "" : "\n") + full_text(k);
  if (text.empty()) text = search_help(key);
  if (!text.empty()) return text;
  throw Error(ErrorCode::usage, fmt::format("no scene key or section '{}'{}", key, key_hint(key, false)), "",
              "'talus help scene' lists all keys");
}

}  // namespace talus
