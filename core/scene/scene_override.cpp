// See scene_override.hpp.
#include "core/scene/scene_override.hpp"

#include <fmt/format.h>

#include "core/base/error.hpp"
#include "core/base/text.hpp"
#include "core/scene/scene_suggest.hpp"
#include "core/scene/scene_text.hpp"

namespace talus {
namespace {

std::vector<std::string> split_path(std::string_view path) {
  std::vector<std::string> parts{""};
  for (char c : path) {
    if (c == '.')
      parts.emplace_back();
    else
      parts.back() += c;
  }
  return parts;
}

std::string_view trim(std::string_view s) {
  while (!s.empty() && (s.front() == ' ' || s.front() == '\t')) s.remove_prefix(1);
  while (!s.empty() && (s.back() == ' ' || s.back() == '\t')) s.remove_suffix(1);
  return s;
}

}  // namespace

void apply_override(TomlNode& root, const std::string& text, SceneContext& context) {
  const std::string where = "--set " + text;
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    throw Error(ErrorCode::scene, "not of the form section.key=value", where);
  if (text.size() > k_scene_bytes) throw Error(ErrorCode::scene, "longer than 1 MiB", "--set");
  for (std::size_t i = 0, n = 0; i < text.size(); i += n) {
    n = utf8_length(text, i);
    if (n == 0 || control_length(text, i) != 0)
      throw Error(ErrorCode::scene, "control characters and bytes that are no UTF-8 are not allowed", where);
  }
  const std::string path(trim(std::string_view(text).substr(0, equals)));
  const std::string value(trim(std::string_view(text).substr(equals + 1)));
  const std::vector<std::string> parts = split_path(path);
  TomlNode* table = &root;
  std::string section, so_far;
  for (std::size_t i = 0; i + 1 < parts.size(); ++i) {
    const std::string& part = parts[i];
    section += (section.empty() ? "" : ".") + part;
    so_far += (so_far.empty() ? "" : ".") + part;
    const SceneSection* known = find_scene_section(section);
    if (known == nullptr) {
      throw Error(ErrorCode::scene, fmt::format("{}: unknown section '{}'{}", path, section, key_hint(path, true)),
                  where);
    }
    TomlNode* next = table->find(part);
    if (known->repeated) {
      const std::size_t size = next != nullptr ? next->list.size() : 0;
      const std::string index = i + 2 < parts.size() ? parts[i + 1] : "";
      std::size_t at = 0;
      bool number = !index.empty() && index.size() < 7;
      for (char c : index) {
        number = number && c >= '0' && c <= '9';
        at = at * 10 + static_cast<std::size_t>(c - '0');
      }
      TomlNode* entry = number && at < size ? &next->list[at] : nullptr;
      if (entry == nullptr || !entry->is_table())
        throw Error(ErrorCode::scene,
                    fmt::format("{}{}: {}; the scene has {} [[{}]]", so_far, index.empty() ? "" : "." + index,
                                index.empty() ? "one key of many entries" : "not an entry", size, section),
                    where, fmt::format("write {}.INDEX.key with INDEX from 0", so_far));
      table = entry;
      so_far += "." + index;
      ++i;
      continue;
    }
    if (next == nullptr) {
      next = &table->set(part, {});
      next->type = TomlNode::Type::table;
      next->where = next->key_where = context.name;
      next->shown = "{...}";
    }
    if (!next->is_table()) throw Error(ErrorCode::scene, fmt::format("{} is not a section", so_far), where);
    table = next;
  }
  if (path == "time.steps") table->erase("duration");
  if (path == "time.duration") table->erase("steps");
  table->set(parts.back(), parse_toml_value(value, where));
  context.overrides[path] = text;
}

}  // namespace talus
