// A TOML text as a plain tree; the parser stays behind it. Who calls it: readers of scenes and of grain files.
// Invariant: the text has passed the guards of scene_text.hpp; every value knows where it stands.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace talus {

struct TomlEntry;

struct TomlNode {
  enum class Type { number, integer, boolean, text, list, table, other } type = Type::other;
  double number = 0;  ///< of integers too: beyond 2^53 they round as any other number would
  std::int64_t integer = 0;
  bool boolean = false;
  std::string text;
  std::vector<TomlNode> list;
  std::vector<TomlEntry> table;  ///< by name, ascending
  std::string where;             ///< "name:line:column", or the name alone
  std::string key_where;         ///< the same of the key that has this value
  std::string shown;             ///< the value as its author would write it, shortened

  bool is_text() const noexcept { return type == Type::text; }
  bool is_list() const noexcept { return type == Type::list; }
  bool is_table() const noexcept { return type == Type::table; }
  bool is_integer() const noexcept { return type == Type::integer; }
  bool is_number() const noexcept { return type == Type::number || type == Type::integer; }
  /// A list that holds tables, and nothing else.
  bool is_list_of_tables() const noexcept;

  /// Of a table: the value of a key, or null.
  const TomlNode* find(std::string_view key) const noexcept;
  TomlNode* find(std::string_view key) noexcept;
  TomlNode& set(std::string_view key, TomlNode value);  ///< replaces or adds
  void erase(std::string_view key);
};

/// A key and its value.
struct TomlEntry {
  std::string first;
  TomlNode second;
};

/// Error{scene} in one line with name:line:column.
TomlNode parse_toml_tree(std::string_view text, const std::string& name);
/// A single value; what is none is a bare text. `where` stands in for line and column.
TomlNode parse_toml_value(std::string_view value, const std::string& where);

}  // namespace talus
