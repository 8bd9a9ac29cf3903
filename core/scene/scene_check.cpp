// See scene_check.hpp.
#include "core/scene/scene_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/base/error.hpp"
#include "core/base/suggest.hpp"
#include "core/scene/scene_suggest.hpp"
#include "core/scene/scene_text.hpp"

namespace talus {

std::string SceneContext::where(const std::string& path, const std::string& written) const {
  for (std::string p = path;;) {
    if (auto it = overrides.find(p); it != overrides.end()) return "--set " + it->second;
    const std::size_t dot = p.rfind('.');
    if (dot == std::string::npos) break;
    p.resize(dot);
  }
  return written;
}

std::string join_path(std::string_view path, std::string_view name) {
  return path.empty() ? std::string(name) : fmt::format("{}.{}", path, name);
}

std::vector<std::string> choice_words(const SceneKey& key) {
  const std::vector<std::string_view> words = split_words(key.choices, ", ");
  return {words.begin(), words.end()};
}

void fail_value(const SceneContext& context, const std::string& path, const TomlNode& node,
                const std::string& allowed) {
  throw Error(ErrorCode::scene, fmt::format("{}: {}: {}", path, node.shown, allowed),
              context.where(path, node.where.empty() ? context.name : node.where));  // a default stands nowhere
}

namespace {

/// The default of a key, parsed from the key table once. Of a key without one: no value, only the words that tell so.
const TomlNode& default_node(const SceneKey& key) {
  static const auto defaults = [] {
    std::map<const SceneKey*, TomlNode> m;
    for (const SceneKey& k : scene_keys()) {
      TomlNode& n = m[&k];
      if (k.has_default())
        n = parse_toml_value(k.fallback, "");
      else
        n.shown = k.fallback;
    }
    return m;
  }();
  return defaults.at(&key);
}

bool is_choice(const SceneKey& key, const TomlNode& node) {
  const std::vector<std::string> words = choice_words(key);
  return node.is_text() && std::find(words.begin(), words.end(), node.text) != words.end();
}

/// Checks of one table: unknown keys, types, ranges, keys without effect.
class Checker {
 public:
  Checker(const SceneContext& ctx, const TomlNode& table, const std::string& section, const std::string& path)
      : ctx_(ctx), table_(table), section_(section), path_(path) {}
  void types() const {
    for (const auto& [key, node] : table_.table) check(key, node);
  }
  void effects() const {
    for (const auto& [key, node] : table_.table) check_only(key, node);
  }

 private:
  std::string child(std::string_view name) const { return join_path(path_, name); }
  std::string full(std::string_view name) const { return join_path(section_, name); }

  void check(const std::string& name, const TomlNode& n) const {
    const std::string path = child(name);
    if (const SceneSection* s = find_scene_section(full(name)); s != nullptr && !s->name.empty()) {
      check_section(*s, n, path);
      return;
    }
    const SceneKey* k = find_scene_key(section_, name);
    if (k != nullptr) {
      check_value(*k, n, path);
      return;
    }
    std::vector<std::string> names;
    for (const SceneKey& other : scene_keys()) {
      if (other.section == section_) names.emplace_back(other.name);
    }
    for (const SceneSection& s : scene_sections()) {
      const std::string_view parent = s.name.substr(0, s.name.find('.'));
      if (section_.empty() ? (!s.name.empty() && parent == s.name) : (s.name.starts_with(section_ + "."))) {
        names.emplace_back(section_.empty() ? s.name : s.name.substr(section_.size() + 1));
      }
    }
    const std::string where = ctx_.where(path, n.key_where);
    // A table with this name is a section that is written wrongly; anything else is a key.
    std::string hint = n.is_table() || n.is_list_of_tables() ? did_you_mean(name, names) : "";
    if (hint.empty()) hint = key_hint(path, where.starts_with("--set "));
    std::string list;
    for (const std::string& s : names) list += (list.empty() ? "" : ", ") + s;
    throw Error(ErrorCode::scene, fmt::format("{}: unknown key{}; allowed here: {}", path, hint, list), where);
  }

  void check_section(const SceneSection& s, const TomlNode& n, const std::string& path) const {
    if (!s.repeated) {
      if (!n.is_table())
        fail_value(ctx_, path, n,
                   fmt::format("must be a table, written [{0}] or {1} = {{ key = value }} (`talus help scene {0}`)",
                               s.name, s.name.substr(s.name.rfind('.') + 1)));
      return;
    }
    if (!n.is_list() || !(n.list.empty() || n.is_list_of_tables()))
      fail_value(ctx_, path, n, fmt::format("must be a list of tables, each written [[{}]]", s.name));
  }

  static bool in_range(const SceneKey& k, const TomlNode& n, bool integer) {
    if (!n.is_number() || (integer && !n.is_integer())) return false;
    return std::isfinite(n.number) && (k.low_open ? n.number > k.low : n.number >= k.low) && n.number <= k.high;
  }
  static bool is_text(const TomlNode& n) { return n.is_text() && is_scene_text(n.text); }
  static bool list_of(const SceneKey& k, const TomlNode& n, std::size_t size, bool integer) {
    if (!n.is_list() || (size != 0 && n.list.size() != size)) return false;
    return std::all_of(n.list.begin(), n.list.end(), [&](const TomlNode& e) { return in_range(k, e, integer); });
  }
  static bool boundary_ok(const SceneKey& k, const TomlNode& n) {
    if (is_choice(k, n)) return true;
    if (!n.is_list() || n.list.size() != 3) return false;
    return std::all_of(n.list.begin(), n.list.end(), [&](const TomlNode& e) {
      return is_choice(k, e) ||
             (e.is_list() && e.list.size() == 2 && is_choice(k, e.list[0]) && is_choice(k, e.list[1]));
    });
  }
  /// [[x, value], ...] with ascending x.
  static bool points_ok(const SceneKey& k, const TomlNode& n, std::size_t least) {
    if (!n.is_list() || n.list.size() < least) return false;
    double last = -std::numeric_limits<double>::infinity();
    for (const TomlNode& point : n.list) {
      if (!point.is_list() || point.list.size() != 2 || !in_range(k, point.list[1], false)) return false;
      const TomlNode& x = point.list[0];
      if (!x.is_number() || !std::isfinite(x.number) || !(x.number > last)) return false;
      last = x.number;
    }
    return true;
  }
  /// A list of finite numbers, `size` of them where that is not 0.
  static bool finite_list(const TomlNode* n, std::size_t size) {
    if (n == nullptr || !n->is_list() || n->list.empty() || (size != 0 && n->list.size() != size)) return false;
    return std::all_of(n->list.begin(), n->list.end(),
                       [](const TomlNode& e) { return e.is_number() && std::isfinite(e.number); });
  }
  static bool property_ok(const SceneKey& k, const TomlNode& n) {
    if (!n.is_table()) return in_range(k, n, false);
    if (const TomlNode* points = n.find("table")) return n.table.size() == 1 && points_ok(k, *points, 2);
    if (!finite_list(n.find("polynomial"), 0)) return false;
    for (const auto& [name, value] : n.table) {
      const bool ok = name == "polynomial" || (name == "origin" && value.is_number() && std::isfinite(value.number)) ||
                      (name == "range" && finite_list(&value, 2) && value.list[0].number < value.list[1].number);
      if (!ok) return false;
    }
    return true;
  }
  bool value_ok(const SceneKey& k, const TomlNode& n) const {
    switch (k.type) {
      case KeyType::number:
        return in_range(k, n, false);
      case KeyType::number_or_none:
        return in_range(k, n, false) || (n.is_text() && n.text == "none");
      case KeyType::number_or_auto:
        return in_range(k, n, false) || (n.is_text() && n.text == "auto");
      case KeyType::integer:
        return in_range(k, n, true);
      case KeyType::boolean:
        return n.type == TomlNode::Type::boolean;
      case KeyType::text:
        return is_text(n);
      case KeyType::choice:
        return is_choice(k, n);
      case KeyType::vector:
        return list_of(k, n, 3, false);
      case KeyType::numbers:
        return list_of(k, n, 0, false);
      case KeyType::cells:
        return list_of(k, n, 3, true);
      case KeyType::text_pair:
        return n.is_list() && n.list.size() == 2 && is_text(n.list[0]) && is_text(n.list[1]);
      case KeyType::id_range:
        return list_of(k, n, 2, true) && n.list[0].integer <= n.list[1].integer;
      case KeyType::property:
        return property_ok(k, n);
      case KeyType::series:
        return in_range(k, n, false) || points_ok(k, n, 1);
      case KeyType::boundary:
        return boundary_ok(k, n);
    }
    return false;
  }
  /// A hint at the first word of a value, or of a list of them, that is no choice.
  static std::string wrong_choice(const SceneKey& k, const TomlNode& n) {
    if (n.is_text()) return is_choice(k, n) ? "" : choice_hint(n.text, choice_words(k), k.meanings);
    for (const TomlNode& entry : n.list)
      if (std::string hint = wrong_choice(k, entry); !hint.empty()) return hint;
    return "";
  }
  void check_value(const SceneKey& k, const TomlNode& n, const std::string& path) const {
    if (value_ok(k, n)) return;
    std::string hint;
    if (!k.choices.empty()) hint = wrong_choice(k, n);
    // an upper bound beyond every physical quantity is left out of allowed_text
    if (n.is_number() && n.number > k.high && std::isfinite(n.number)) hint = fmt::format(", at most {:g}", k.high);
    if (k.type == KeyType::numbers && n.is_list() && !n.list.empty() && n.list[0].is_list())
      hint = ": one after another, without inner brackets";
    fail_value(ctx_, path, n, "must be " + allowed_text(k) + hint);
  }
  /// A key that would have no effect here is an error, not noise.
  void check_only(std::string_view name, const TomlNode& n) const {
    const SceneKey* k = find_scene_key(section_, name);
    if (k == nullptr || k->only.empty()) return;
    const KeyCondition only = condition_of(k->only);
    const std::string value = node_of(&table_, section_, only.key).text;
    if (only.holds(value)) return;
    fail_value(ctx_, child(name), n,
               fmt::format("has no effect with {} = {}; allowed only for {}", only.key, value, only.text()));
  }

  const SceneContext& ctx_;
  const TomlNode& table_;
  const std::string& section_;
  const std::string& path_;
};

}  // namespace

const TomlNode& node_of(const TomlNode* table, const std::string& section, std::string_view name) {
  if (table != nullptr)
    if (const TomlNode* given = table->find(name); given != nullptr) return *given;
  const SceneKey* k = find_scene_key(section, name);
  if (k == nullptr) throw std::logic_error("key not in the table: " + section + "." + std::string(name));
  return default_node(*k);
}

void check_types(const SceneContext& context, const TomlNode& table, const std::string& section,
                 const std::string& path) {
  Checker(context, table, section, path).types();
}

void check_effects(const SceneContext& context, const TomlNode& table, const std::string& section,
                   const std::string& path) {
  Checker(context, table, section, path).effects();
}

}  // namespace talus
