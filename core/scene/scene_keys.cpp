// The list of all sections; see scene_keys.hpp.
#include "core/scene/scene_keys.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/scene/sections/parts.hpp"

namespace talus {
namespace {

/// In the order of the help and of the reference.
std::vector<const SectionKeys*> all_sections() {
  return {&top_keys(),     &domain_keys(),      &time_keys(),         &damping_keys(),       &material_keys(),
          &contact_keys(), &pair_keys(),        &source_keys(),       &source_region_keys(), &source_size_keys(),
          &wall_keys(),    &wall_motion_keys(), &group_keys(),        &group_region_keys(),  &event_keys(),
          &list_keys(),    &output_keys(),      &output_plane_keys(), &output_region_keys(), &checks_keys(),
          &monitor_keys(), &relax_keys()};
}

struct Tables {
  std::vector<SceneKey> keys;
  std::vector<SceneSection> sections;
  /// Keys of a section lie together, also those that another class or an optional part adds.
  void add(const SectionKeys& s) {
    const std::string_view name = s.section().name;
    const auto of = [name](const auto& k) { return k.section == name; };
    if (std::none_of(sections.begin(), sections.end(), [name](const SceneSection& k) { return k.name == name; }))
      sections.push_back(s.section());
    const auto last = std::find_if(keys.rbegin(), keys.rend(), of);
    keys.insert(last == keys.rend() ? keys.end() : last.base(), s.rows().begin(), s.rows().end());
  }
};

const Tables& tables() {
  static const Tables all = [] {
    Tables t;
    for (const SectionKeys* s : all_sections()) t.add(*s);
    for (const PartSections* part : part_sections())
      for (const SectionKeys* s : part->keys) t.add(*s);
    return t;
  }();
  return all;
}

}  // namespace

std::span<const SceneKey> scene_keys() { return tables().keys; }
std::span<const SceneSection> scene_sections() { return tables().sections; }

const SceneKey* find_scene_key(std::string_view section, std::string_view name) {
  for (const SceneKey& k : scene_keys()) {
    if (k.section == section && k.name == name) return &k;
  }
  return nullptr;
}

const SceneSection* find_scene_section(std::string_view name) {
  for (const SceneSection& s : scene_sections()) {
    if (s.name == name) return &s;
  }
  return nullptr;
}

std::string full_name(const SceneKey& key) {
  return key.section.empty() ? std::string(key.name) : fmt::format("{}.{}", key.section, key.name);
}

std::vector<std::string_view> split_words(std::string_view words, std::string_view separator) {
  std::vector<std::string_view> parts;
  while (!words.empty()) {
    const std::size_t at = words.find(separator);
    parts.push_back(words.substr(0, at));
    words = at == std::string_view::npos ? std::string_view{} : words.substr(at + separator.size());
  }
  return parts;
}

KeyCondition condition_of(std::string_view only) {
  if (only.empty()) return {};
  const std::size_t equals = only.find('=');
  return {only.substr(0, equals), split_words(only.substr(equals + 1), "|")};
}

std::string KeyCondition::text() const {
  std::string list;
  for (const std::string_view v : values) list += (list.empty() ? "" : ", ") + std::string(v);
  return list;
}

bool KeyCondition::holds(std::string_view value) const {
  return std::find(values.begin(), values.end(), value) != values.end();
}

void SectionKeys::check_needed(const SceneTable& r) const {
  for (const SceneKey& k : rows_) {
    if (k.needed.empty() || r.has(k.name)) continue;
    const std::string_view decider = condition_of(k.only).key;
    const std::string value = r.text(decider);
    const std::vector<std::string_view> values = split_words(k.needed, "|");
    if (std::find(values.begin(), values.end(), value) != values.end())
      r.missing(k.name, fmt::format("by {} = {}", decider, value));
  }
}

}  // namespace talus
