// See toml_tree.hpp. The only unit that sees toml++.
#include "core/scene/toml_tree.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "core/base/error.hpp"
#include "core/base/text.hpp"
#include "core/scene/scene_text.hpp"

namespace talus {
[[noreturn]] static void toml_assertion(const char* text) { throw std::logic_error(text); }
}  // namespace talus
// toml++ drops its own assertion under NDEBUG and aborts otherwise; both are wrong for text that a user wrote.
#undef NDEBUG
#define TOML_ASSERT(expr) ((expr) ? static_cast<void>(0) : ::talus::toml_assertion(#expr))
#include <toml++/toml.h>

namespace talus {
namespace {

toml::table parse_text(std::string_view text, const std::string& name) {
  try {
    return toml::parse(text, name);
  } catch (const toml::parse_error& e) {
    throw Error(ErrorCode::scene, std::string(e.description()),
                fmt::format("{}:{}:{}", name, e.source().begin.line, e.source().begin.column), "TOML 1.0 syntax");
  } catch (const std::logic_error& e) {
    throw Error(ErrorCode::scene, fmt::format("the text cannot be parsed as TOML ({})", e.what()), name);
  }
}

/// As its author would write it.
std::string shown_text(const toml::node& node, const TomlNode& value) {
  std::string s;
  if (value.is_list()) {
    for (const TomlNode& entry : value.list) {
      s += (s.empty() ? "" : ", ") + entry.shown;
      if (s.size() > 60) break;
    }
    s = "[" + s + "]";
  } else if (value.is_table()) {
    s = "{...}";
  } else if (value.type == TomlNode::Type::number) {
    s = fmt::format("{}", value.number);
  } else {
    std::ostringstream out;
    node.visit([&](const auto& n) { out << n; });
    s = out.str();
  }
  return shown(s, 60);
}

std::string place(const toml::source_region& at, const std::string& name) {
  return at.begin.line == 0 ? name : fmt::format("{}:{}:{}", name, at.begin.line, at.begin.column);
}

// toml++'s own value<T>() is empty for integers that T cannot hold exactly, which is easily taken for a wrong type:
// only the exact types are asked for.
TomlNode tree_of(const toml::node& node, const std::string& name) {
  TomlNode out;
  out.where = place(node.source(), name);
  if (const auto* real = node.as_floating_point()) {
    out.type = TomlNode::Type::number;
    out.number = real->get();
  } else if (const auto* integer = node.as_integer()) {
    out.type = TomlNode::Type::integer;
    out.integer = integer->get();
    out.number = static_cast<double>(integer->get());
  } else if (const auto* boolean = node.as_boolean()) {
    out.type = TomlNode::Type::boolean;
    out.boolean = boolean->get();
  } else if (const auto* text = node.as_string()) {
    out.type = TomlNode::Type::text;
    out.text = text->get();
  } else if (const toml::array* list = node.as_array()) {
    out.type = TomlNode::Type::list;
    for (const toml::node& n : *list) out.list.push_back(tree_of(n, name));
  } else if (const toml::table* table = node.as_table()) {
    out.type = TomlNode::Type::table;
    for (auto&& [key, value] : *table) {
      TomlNode& entry = out.set(key.str(), tree_of(value, name));
      entry.key_where = place(key.source(), name);
    }
  }
  out.shown = shown_text(node, out);
  return out;
}

/// Entry of the sorted table at or behind a key.
template <class Table>
auto at_or_behind(Table& table, std::string_view key) {
  return std::lower_bound(table.begin(), table.end(), key,
                          [](const auto& e, std::string_view k) { return e.first < k; });
}

}  // namespace

bool TomlNode::is_list_of_tables() const noexcept {
  return is_list() && !list.empty() &&
         std::all_of(list.begin(), list.end(), [](const TomlNode& n) { return n.is_table(); });
}

const TomlNode* TomlNode::find(std::string_view key) const noexcept {
  const auto at = at_or_behind(table, key);
  return at != table.end() && at->first == key ? &at->second : nullptr;
}
TomlNode* TomlNode::find(std::string_view key) noexcept {
  return const_cast<TomlNode*>(static_cast<const TomlNode*>(this)->find(key));
}

TomlNode& TomlNode::set(std::string_view key, TomlNode value) {
  auto at = at_or_behind(table, key);
  if (at == table.end() || at->first != key) at = table.insert(at, {std::string(key), TomlNode{}});
  at->second = std::move(value);
  return at->second;
}

void TomlNode::erase(std::string_view key) {
  std::erase_if(table, [&](const auto& entry) { return entry.first == key; });
}

TomlNode parse_toml_tree(std::string_view text, const std::string& name) {
  return tree_of(parse_text(guarded_scene_text(text, name), name), name);
}

TomlNode parse_toml_value(std::string_view value, const std::string& where) {
  toml::table parsed;
  try {
    parsed = toml::parse(guarded_scene_text("v = " + std::string(value), where), where);
  } catch (const std::exception&) {
    parsed.clear();
  }
  if (parsed.size() != 1 || parsed.get("v") == nullptr) parsed = toml::table{{"v", value}};
  TomlNode node = tree_of(*parsed.get("v"), where);
  node.where = node.key_where = where;
  return node;
}

}  // namespace talus
