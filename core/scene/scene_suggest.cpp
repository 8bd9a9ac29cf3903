// See scene_suggest.hpp.
#include "core/scene/scene_suggest.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <vector>

#include "core/base/suggest.hpp"

namespace talus {
namespace {

struct Typed {
  std::string section, name;
};

/// Lower case, '-' as '_', indices of repeated sections left out.
Typed typed_of(std::string_view path) {
  Typed t;
  std::vector<std::string> parts{""};
  for (char c : path) {
    if (c == '.') {
      parts.emplace_back();
      continue;
    }
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    parts.back() += c == '-' || c == ' ' ? '_' : c;
  }
  const auto is_index = [](const std::string& s) {
    return !s.empty() && std::all_of(s.begin(), s.end(), [](char c) { return c >= '0' && c <= '9'; });
  };
  t.name = parts.back();
  parts.pop_back();
  for (const std::string& part : parts)
    if (!is_index(part)) t.section += (t.section.empty() ? "" : ".") + part;
  return t;
}

std::string_view last_part(std::string_view section) {
  const std::size_t dot = section.rfind('.');
  return dot == std::string_view::npos ? section : section.substr(dot + 1);
}

bool near(std::string_view a, std::string_view b) {
  return edit_distance(a, b) * 3 <= std::max<std::size_t>(a.size(), 3);
}

constexpr double k_no = 9;

/// How far the typed section is from a key's.
double section_cost(std::string_view typed, std::string_view section) {
  if (typed == section) return 0;
  if (typed.empty()) return 0.12 + 0.01 * static_cast<double>(std::count(section.begin(), section.end(), '.'));
  if (section.ends_with("." + std::string(typed))) return 0.05;
  if (section.starts_with(std::string(typed) + ".")) return 0.12;
  if (!section.empty() && near(typed, section)) return 0.1;
  if (!section.empty() && near(last_part(typed), last_part(section))) return 0.15;
  if (!section.empty() && typed.starts_with(std::string(section) + ".")) return 0.2;
  return 0.3;
}

/// How far the typed name is from a key's.
double name_cost(std::string_view typed, std::string_view name) {
  if (typed == name) return 0;
  const std::size_t distance = edit_distance(typed, name);
  double cost = k_no;
  if (distance * 2 <= typed.size() && distance < typed.size())
    cost = 0.15 + 0.6 * static_cast<double>(distance) / static_cast<double>(std::max(typed.size(), name.size()));
  constexpr std::size_t k_short = 3;
  if (typed.size() > k_short && (has_word(name, typed) || (name.size() > k_short && has_word(typed, name))))
    cost = std::min(cost, 0.3);
  return cost;
}

bool within(std::string_view section, std::string_view asked) {
  return asked.empty() || section == asked || section.starts_with(std::string(asked) + ".") ||
         last_part(section) == asked;
}

}  // namespace

KeySuggestion suggest_key(std::string_view path) {
  const Typed t = typed_of(path);
  constexpr double limit = 0.56;
  double best = limit;
  KeySuggestion found;
  const auto offer = [&](double cost, const SceneKey& key, std::string_view remark) {
    if (!(cost < best)) return;
    best = cost;
    found = {&key, remark};
  };
  // What a word means elsewhere goes before a key of the same spelling for something else.
  for (const SceneKey& k : scene_keys())
    for (const KeyAlias& a : k.also)
      if (a.word == t.name && within(t.section, a.within))
        offer(section_cost(t.section, k.section) - 0.05, k, a.remark);
  for (const SceneKey& k : scene_keys()) offer(name_cost(t.name, k.name) + section_cost(t.section, k.section), k, "");
  return found;
}

std::string settable_path(const SceneKey& key, std::string_view typed) {
  if (key.section.empty()) return std::string(key.name);
  const std::string_view top = key.section.substr(0, key.section.find('.'));
  std::string path, so_far;
  for (std::size_t at = 0; at <= key.section.size();) {
    const std::size_t dot = std::min(key.section.find('.', at), key.section.size());
    const std::string_view part = key.section.substr(at, dot - at);
    so_far += (so_far.empty() ? "" : ".") + std::string(part);
    path += (path.empty() ? "" : ".") + std::string(part);
    const SceneSection* section = find_scene_section(so_far);
    if (section != nullptr && section->repeated) {
      std::string_view index = "0";
      if (so_far == top && typed.starts_with(std::string(top) + ".")) {
        const std::string_view rest = typed.substr(top.size() + 1);
        const std::string_view word = rest.substr(0, rest.find('.'));
        if (!word.empty() && word.find_first_not_of("0123456789") == std::string_view::npos) index = word;
      }
      path += "." + std::string(index);
    }
    at = dot + 1;
  }
  return path + "." + std::string(key.name);
}

std::string key_hint(std::string_view path, bool settable) {
  const KeySuggestion s = suggest_key(path);
  if (s.key == nullptr) return "";
  const std::string name = settable ? settable_path(*s.key, path) : full_name(*s.key);
  return fmt::format(" (did you mean '{}'?{}{})", name, s.remark.empty() ? "" : " ", s.remark);
}

}  // namespace talus
