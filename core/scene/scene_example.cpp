// A small valid scene around each key; see scene_keys.hpp. Everything in it follows from the table: what is required,
// what the key's own condition asks for, and the examples of the keys that stand there.
#include <fmt/format.h>

#include <algorithm>

#include "core/scene/key.hpp"

namespace talus {
namespace {

/// The value that the key `decider` of a section has in the example of `key`.
std::string_view value_in(const SceneKey& key, std::string_view section, std::string_view decider) {
  if (key.section == section) {
    if (key.name == decider) return key.example.substr(1, key.example.size() - 2);
    if (const KeyCondition only = condition_of(key.only); only.key == decider) return only.values.front();
  }
  for (const std::string_view line : split_words(section == "contact" ? key.with : "", "\n"))
    if (line.starts_with(std::string(decider) + " = \"")) {
      const std::string_view value = line.substr(decider.size() + 4);
      return value.substr(0, value.size() - 1);
    }
  const SceneKey* k = find_scene_key(section, decider);
  const std::string_view value = k->has_default() ? std::string_view(k->fallback) : k->example;
  return value.substr(1, value.size() - 2);
}

/// Does the example of `key` need the sibling `k`, because of the values of the keys that decide?
bool stands_in(const SceneKey& key, const SceneKey& k) {
  if (k.required()) return true;
  const KeyCondition only = condition_of(key.section == k.section ? key.only : "");
  if (only.key == k.name) return true;
  if (!k.needed.empty()) {
    const std::vector<std::string_view> values = split_words(k.needed, "|");
    return std::find(values.begin(), values.end(), value_in(key, k.section, condition_of(k.only).key)) != values.end();
  }
  if (k.usual_for.empty() || (key.section == k.section && key.name == k.instead)) return false;
  // the key that decides is that of a sibling's condition, or the one of the section
  return k.usual_for == "*" || k.usual_for == value_in(key, k.section, condition_of(k.only).key);
}

/// Lines of a section: the key itself, what stands with it.
std::string section_text(std::string_view section, const SceneKey& key) {
  std::string s = section.empty() ? "" : header_text(*find_scene_section(section)) + "\n";
  for (const SceneKey& k : scene_keys()) {
    if (k.section != section) continue;
    const bool asked = key.section == section && key.name == k.name;
    if (asked) {
      s += fmt::format("{} = {}\n", k.name, k.example);
      if (!k.beside.empty()) s += fmt::format("{}\n", k.beside);
    } else if (stands_in(key, k)) {
      const KeyCondition only = condition_of(key.section == section ? key.only : "");
      s += only.key == k.name ? fmt::format("{} = \"{}\"\n", k.name, only.values.front())
                              : fmt::format("{} = {}\n", k.name, k.example);
    }
  }
  return s;
}

/// The laws of Hertz take their stiffness from the materials, and need a restitution.
bool hertzian(const SceneKey& key) { return value_in(key, "contact", "model") != "linear"; }

/// Lines of [contact]; those that the key brings with it go before those that stand there anyway.
std::string contact_text(const SceneKey& key) {
  std::string s = section_text("contact", key);
  if (key.with.starts_with('[')) return s;  // a section of its own
  for (const std::string_view line : split_words(key.with, "\n")) {
    const std::string_view name = line.substr(0, line.find(' '));
    if (s.find("\n" + std::string(name) + " = ") == std::string::npos) s += std::string(line) + "\n";
  }
  if (hertzian(key) && s.find("\nrestitution") == std::string::npos) s += "restitution = 0.8\n";
  return s;
}

}  // namespace

std::string scene_key_example(const SceneKey& key) {
  std::string s;
  if (key.section.empty()) s = section_text("", key);
  s += section_text("domain", key) + section_text("time", key);
  // two materials, whose names the sections below give as examples
  const std::string elastic = hertzian(key) ? "young = 5e7\npoisson = 0.25\n" : "";
  s += section_text("material", key) + elastic + "[[material]]\nname = \"steel\"\ndensity = 7800\n" + elastic;
  s += contact_text(key);
  s += section_text("source", key);
  if (key.section != "source" || value_in(key, "source", "kind") != "file")
    s += section_text("source.region", key) + section_text("source.size", key);
  s += section_text("group", key);
  const std::string_view parent = key.section.substr(0, key.section.find('.'));
  constexpr std::string_view always[] = {"", "domain", "time", "material", "contact", "source", "group"};
  if (std::find(std::begin(always), std::end(always), parent) == std::end(always)) s += section_text(parent, key);
  if (parent != key.section && parent != "source") s += section_text(key.section, key);
  if (key.with.starts_with('[')) s += key.with;
  return s;
}

}  // namespace talus
