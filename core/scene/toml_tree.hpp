// A TOML text as a plain tree, for formats that have keys of their own. Who calls it: readers of grain files. Invariant:
// the text has passed the same guards as a scene; every value knows where it stands.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace talus {

struct TomlNode {
  enum class Type { number, integer, boolean, text, list, table, other } type = Type::other;
  double number = 0;          ///< of integers too
  std::int64_t integer = 0;
  bool boolean = false;
  std::string text;
  std::vector<TomlNode> list;
  std::vector<std::pair<std::string, TomlNode>> table;  ///< in the order of the text
  std::string where;          ///< "name:line:column"
  std::string shown;          ///< the value as its author would write it, shortened

  const TomlNode* find(std::string_view key) const {
    for (const auto& [name, node] : table)
      if (name == key) return &node;
    return nullptr;
  }
};

/// Error{scene} in one line with name:line:column.
TomlNode parse_toml_tree(std::string_view text, const std::string& name);

}  // namespace talus
