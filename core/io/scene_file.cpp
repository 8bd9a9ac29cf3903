// Scene files. Three layers: a guarded TOML parse (the only unit that sees toml++), a Reader that checks one table
// against the key table, and build functions that fill the Scene section by section.
#include "core/io/scene_file.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <memory>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "core/det_math.hpp"
#include "core/error.hpp"
#include "core/io/scene_keys.hpp"

namespace talus {
[[noreturn]] static void toml_assertion(const char* text) { throw std::logic_error(text); }
}  // namespace talus
// toml++ drops its own assertion under NDEBUG and aborts otherwise; both are wrong for text that a user wrote.
#undef NDEBUG
#define TOML_ASSERT(expr) ((expr) ? static_cast<void>(0) : ::talus::toml_assertion(#expr))
#include <toml++/toml.h>

namespace talus {
namespace {

constexpr std::size_t k_max_bytes = std::size_t{1} << 20;

/// Where messages point: the text's name, and which paths were set on the command line.
struct Context {
  std::string name;
  std::map<std::string, std::string> overrides;  ///< path -> "path=value"

  std::string where(const std::string& path, const toml::source_region& at) const {
    for (std::string p = path;;) {
      if (auto it = overrides.find(p); it != overrides.end()) return "--set " + it->second;
      const std::size_t dot = p.rfind('.');
      if (dot == std::string::npos) break;
      p.resize(dot);
    }
    if (at.begin.line == 0) return name;
    return fmt::format("{}:{}:{}", name, at.begin.line, at.begin.column);
  }
};

/// A value as its author would write it, shortened.
std::string value_text(const toml::node& node) {
  std::string s;
  if (const toml::array* list = node.as_array()) {
    for (const toml::node& entry : *list) {
      s += (s.empty() ? "" : ", ") + value_text(entry);
      if (s.size() > 60) break;
    }
    s = "[" + s + "]";
  } else if (node.is_table()) {
    s = "{...}";
  } else if (node.is_floating_point()) {
    s = fmt::format("{}", *node.value<double>());
  } else {
    std::ostringstream out;
    node.visit([&](const auto& n) { out << n; });
    s = out.str();
  }
  return s.size() > 60 ? s.substr(0, 57) + "..." : s;
}

[[noreturn]] void fail_value(const Context& ctx, const std::string& path, const toml::node& node,
                             const std::string& allowed) {
  throw Error(ErrorCode::scene, fmt::format("{}: {}: {}", path, value_text(node), allowed),
              ctx.where(path, node.source()));
}

// ---------------------------------------------------------------------------------------------- guarded parse

/// Refuses what the TOML parser must never see and blanks comments (they may hold any UTF-8 text).
std::string guard(std::string_view text, const std::string& name) {
  if (text.size() > k_max_bytes)
    throw Error(ErrorCode::scene, fmt::format("the scene has {} bytes", text.size()), name, "at most 1 MiB is allowed");
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  std::string clean(text);
  int line = 1, column = 0;
  char quote = 0;       // the quote that opened the present string
  bool triple = false;  // of a multi-line string
  bool comment = false;
  for (std::size_t i = 0; i < clean.size(); ++i) {
    const char c = clean[i];
    ++column;
    if (c == '\n') {
      ++line;
      column = 0;
      comment = false;
      if (!triple) quote = 0;  // the parser reports the unterminated string
      continue;
    }
    const bool printable =
        (c >= 0x20 && c < 0x7f) || c == '\t' || (c == '\r' && i + 1 < clean.size() && clean[i + 1] == '\n');
    if (comment) {
      if (!printable) clean[i] = '?';
      continue;
    }
    if (!printable)
      throw Error(ErrorCode::scene, fmt::format("byte 0x{:02x} outside a comment", static_cast<unsigned char>(c)),
                  fmt::format("{}:{}:{}", name, line, column), "only printable ASCII characters are allowed");
    const bool three = clean.compare(i, 3, std::string(3, c)) == 0;
    if (quote != 0) {
      if (c == '\\' && quote == '"') {
        ++i, ++column;
        if (i < clean.size() && clean[i] == '\n') ++line, column = 0;
      } else if (c == quote && (!triple || three)) {
        if (triple) i += 2, column += 2;
        quote = 0;
      }
    } else if (c == '#') {
      comment = true;
    } else if (c == '"' || c == '\'') {
      quote = c;
      triple = three;
      if (triple) i += 2, column += 2;
    }
  }
  return clean;
}

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

void apply_override(toml::table& root, const std::string& text, Context& ctx) {
  const std::string where = "--set " + text;
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    throw Error(ErrorCode::scene, "not of the form section.key=value", where);
  if (text.size() > k_max_bytes) throw Error(ErrorCode::scene, "longer than 1 MiB", "--set");
  for (char c : text) {
    if (c < 0x20 || c >= 0x7f) throw Error(ErrorCode::scene, "only printable ASCII characters are allowed", where);
  }
  const std::string path(trim(std::string_view(text).substr(0, equals)));
  const std::string value(trim(std::string_view(text).substr(equals + 1)));
  const std::vector<std::string> parts = split_path(path);
  toml::table* table = &root;
  std::string section, so_far;
  for (std::size_t i = 0; i + 1 < parts.size(); ++i) {
    const std::string& part = parts[i];
    section += (section.empty() ? "" : ".") + part;
    so_far += (so_far.empty() ? "" : ".") + part;
    const SceneSection* known = find_scene_section(section);
    if (known == nullptr) {
      std::vector<std::string> names;
      for (const SceneSection& s : scene_sections()) names.emplace_back(s.name);
      throw Error(ErrorCode::scene, fmt::format("{}: unknown section{}", section, did_you_mean(section, names)), where);
    }
    toml::node* next = table->get(part);
    if (known->repeated) {
      toml::array* list = next != nullptr ? next->as_array() : nullptr;
      const std::size_t size = list != nullptr ? list->size() : 0;
      const std::string index = i + 2 < parts.size() ? parts[i + 1] : "";
      std::size_t at = 0;
      bool number = !index.empty() && index.size() < 7;
      for (char c : index) {
        number = number && c >= '0' && c <= '9';
        at = at * 10 + static_cast<std::size_t>(c - '0');
      }
      toml::table* entry = number && at < size ? list->get(at)->as_table() : nullptr;
      if (entry == nullptr)
        throw Error(ErrorCode::scene,
                    fmt::format("{}: {}: not an entry; the scene has {} [[{}]]", so_far, index, size, section), where,
                    fmt::format("write {}.INDEX.key with INDEX from 0", so_far));
      table = entry;
      so_far += "." + index;
      ++i;
      continue;
    }
    if (next == nullptr) {
      table->insert_or_assign(part, toml::table{});
      next = table->get(part);
    }
    if (next->as_table() == nullptr) throw Error(ErrorCode::scene, fmt::format("{} is not a section", so_far), where);
    table = next->as_table();
  }
  if (path == "time.steps") table->erase("duration");
  if (path == "time.duration") table->erase("steps");
  toml::table parsed;
  try {
    parsed = toml::parse("v = " + value, std::string_view("--set"));
  } catch (const std::exception&) {
    parsed.insert_or_assign("v", value);  // bare text
  }
  if (parsed.size() != 1 || parsed.get("v") == nullptr) parsed = toml::table{{"v", value}};
  parsed.get("v")->visit([&](auto& v) { table->insert_or_assign(parts.back(), std::move(v)); });
  ctx.overrides[path] = text;
}

// ---------------------------------------------------------------------------------------------- checked reading

/// The default of a key as a TOML node, parsed from the key table once.
const toml::node& default_node(const SceneKey& key) {
  static const auto defaults = [] {
    std::map<const SceneKey*, toml::table> m;
    for (const SceneKey& k : scene_keys()) {
      if (k.fallback == "required" || k.fallback.starts_with('(')) continue;
      m.emplace(&k, toml::parse(fmt::format("v = {}", k.fallback)));
    }
    return m;
  }();
  return *defaults.at(&key).get("v");
}

bool is_choice(const SceneKey& key, const toml::node* node) {
  if (node == nullptr || !node->is_string()) return false;
  const std::string bars = "|" + std::string(key.choices) + "|";
  const std::string& word = node->as_string()->get();
  return word.find('|') == std::string::npos && !word.empty() && bars.find("|" + word + "|") != std::string::npos;
}

/// One table of the scene, checked against its section of the key table on construction.
class Reader {
 public:
  Reader(const Context& ctx, const toml::table* table, std::string section, std::string path)
      : ctx_(ctx), table_(table), section_(std::move(section)), path_(std::move(path)) {
    if (table_ != nullptr) {
      for (auto&& [key, node] : *table_) check(key, node);
    }
    for (const SceneKey& k : scene_keys()) {
      if (k.section == section_ && k.fallback == "required" && !has(k.name)) missing(k.name);
    }
    if (table_ != nullptr) {
      for (auto&& [key, node] : *table_) check_only(key.str(), node);
    }
  }

  bool has(std::string_view name) const { return table_ != nullptr && table_->get(name) != nullptr; }
  double number(std::string_view name) const { return *node(name).value<double>(); }
  double number_or(std::string_view name, double fallback) const { return has(name) ? number(name) : fallback; }
  std::int64_t integer(std::string_view name) const { return *node(name).value<std::int64_t>(); }
  bool boolean(std::string_view name) const { return *node(name).value<bool>(); }
  std::string text(std::string_view name) const { return *node(name).value<std::string>(); }
  Vec3 vector(std::string_view name) const {
    const toml::array& a = *node(name).as_array();
    return {*a[0].value<double>(), *a[1].value<double>(), *a[2].value<double>()};
  }
  /// A direction: normalised, must not vanish.
  Vec3 direction(std::string_view name) const {
    const Vec3 v = vector(name);
    const double length = std::sqrt(norm2(v));
    if (!(length > 0) || !std::isfinite(length)) fail(name, "must not be the zero vector");
    return {v.x / length, v.y / length, v.z / length};
  }
  std::vector<double> numbers(std::string_view name) const {
    std::vector<double> v;
    for (const toml::node& n : *node(name).as_array()) v.push_back(*n.value<double>());
    return v;
  }
  const toml::node& node(std::string_view name) const {
    if (has(name)) return *table_->get(name);  // also sections, for messages
    return default_node(key(name));
  }
  /// The index of the choice in the key table's order; enums are declared in that order.
  template <class E>
  E choice(std::string_view name) const {
    const std::string word = text(name);
    std::string_view rest = key(name).choices;
    for (int i = 0;; ++i) {
      const std::size_t bar = rest.find('|');
      if (rest.substr(0, bar) == word) return static_cast<E>(i);
      rest = rest.substr(bar + 1);
    }
  }
  /// The index of a name in a list; error with the nearest one.
  int index(std::string_view name, const std::vector<std::string>& names, std::string_view what) const {
    return find_name(name, node(name), names, what);
  }
  int find_name(std::string_view name, const toml::node& n, const std::vector<std::string>& names,
                std::string_view what) const {
    const std::string wanted = *n.value<std::string>();
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (names[i] == wanted) return static_cast<int>(i);
    }
    std::string list;
    for (const std::string& s : names) list += (list.empty() ? "" : ", ") + s;
    fail_value(
        ctx_, child(name), n,
        fmt::format("no such {}{}; there is {}", what, did_you_mean(wanted, names), list.empty() ? "none" : list));
  }
  void require(std::string_view name, std::string_view why) const {
    if (!has(name)) missing(name, why);
  }
  /// Both keys given: `b` is reported.
  void exclusive(std::string_view a, std::string_view b) const {
    if (has(a) && has(b)) fail(b, fmt::format("contradicts '{}'; give one of the two", a));
  }
  [[noreturn]] void fail(std::string_view name, const std::string& allowed) const {
    fail_value(ctx_, child(name), node(name), allowed);
  }
  [[noreturn]] void missing(std::string_view name, std::string_view why = {}) const {
    const SceneKey* k = find_scene_key(section_, name);
    const std::string what = k != nullptr ? allowed_text(*k) : "a table";
    throw Error(ErrorCode::scene,
                fmt::format("{}: missing: required{}{}; must be {}", child(name), why.empty() ? "" : " ", why, what),
                ctx_.where(path_, table_ != nullptr ? table_->source() : toml::source_region{}));
  }
  Reader section(std::string_view name) const {
    const toml::node* n = table_ != nullptr ? table_->get(name) : nullptr;
    return Reader(ctx_, n != nullptr ? n->as_table() : nullptr, full(name), child(name));
  }
  std::vector<Reader> sections(std::string_view name) const {
    std::vector<Reader> list;
    const toml::node* n = table_ != nullptr ? table_->get(name) : nullptr;
    if (n == nullptr) return list;
    int i = 0;
    for (const toml::node& entry : *n->as_array())
      list.emplace_back(ctx_, entry.as_table(), full(name), fmt::format("{}.{}", child(name), i++));
    return list;
  }
  std::string child(std::string_view name) const {
    return path_.empty() ? std::string(name) : fmt::format("{}.{}", path_, name);
  }

 private:
  std::string full(std::string_view name) const {
    return section_.empty() ? std::string(name) : fmt::format("{}.{}", section_, name);
  }
  const SceneKey& key(std::string_view name) const {
    const SceneKey* k = find_scene_key(section_, name);
    if (k == nullptr) throw std::logic_error("key not in the table: " + full(name));
    return *k;
  }

  void check(const toml::key& name, const toml::node& n) const {
    const std::string path = child(name.str());
    if (const SceneSection* s = find_scene_section(full(name.str())); s != nullptr && !s->name.empty()) {
      check_section(*s, n, path);
      return;
    }
    const SceneKey* k = find_scene_key(section_, name.str());
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
    std::string hint;
    for (const SceneKey& other : scene_keys()) {  // right name, wrong section
      if (hint.empty() && other.name == name.str()) hint = fmt::format(" (did you mean '{}'?)", full_name(other));
    }
    if (hint.empty()) hint = did_you_mean(name.str(), names);
    std::string list;
    for (const std::string& s : names) list += (list.empty() ? "" : ", ") + s;
    fail_value(
        ctx_, child(name), n,
        fmt::format("no such {}{}; there is {}", what, did_you_mean(wanted, names), list.empty() ? "none" : list));
  }
  void require(std::string_view name, std::string_view why) const {
    if (!has(name)) missing(name, why);
  }
  /// Both keys given: `b` is reported.
  void exclusive(std::string_view a, std::string_view b) const {
    if (has(a) && has(b)) fail(b, fmt::format("contradicts '{}'; give one of the two", a));
  }
  [[noreturn]] void fail(std::string_view name, const std::string& allowed) const {
    fail_value(ctx_, child(name), node(name), allowed);
  }
  [[noreturn]] void missing(std::string_view name, std::string_view why = {}) const {
    const SceneKey* k = find_scene_key(section_, name);
    const std::string what = k != nullptr ? allowed_text(*k) : "a table";
    throw Error(ErrorCode::scene,
                fmt::format("{}: missing: required{}{}; must be {}", child(name), why.empty() ? "" : " ", why, what),
                ctx_.where(path_, table_ != nullptr ? table_->source() : toml::source_region{}));
  }
  Reader section(std::string_view name) const {
    const toml::node* n = table_ != nullptr ? table_->get(name) : nullptr;
    return Reader(ctx_, n != nullptr ? n->as_table() : nullptr, full(name), child(name));
  }
  std::vector<Reader> sections(std::string_view name) const {
    std::vector<Reader> list;
    const toml::node* n = table_ != nullptr ? table_->get(name) : nullptr;
    if (n == nullptr) return list;
    int i = 0;
    for (const toml::node& entry : *n->as_array())
      list.emplace_back(ctx_, entry.as_table(), full(name), fmt::format("{}.{}", child(name), i++));
    return list;
  }
  std::string child(std::string_view name) const {
    return path_.empty() ? std::string(name) : fmt::format("{}.{}", path_, name);
  }

 private:
  std::string full(std::string_view name) const {
    return section_.empty() ? std::string(name) : fmt::format("{}.{}", section_, name);
  }
  const SceneKey& key(std::string_view name) const {
    const SceneKey* k = find_scene_key(section_, name);
    if (k == nullptr) throw std::logic_error("key not in the table: " + full(name));
    return *k;
  }

  void check(const toml::key& name, const toml::node& n) const {
    const std::string path = child(name.str());
    if (const SceneSection* s = find_scene_section(full(name.str())); s != nullptr && !s->name.empty()) {
      check_section(*s, n, path);
      return;
    }
    const SceneKey* k = find_scene_key(section_, name.str());
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
    std::string hint = did_you_mean(name.str(), names);
    // A key in the wrong section is the next most frequent slip.
    for (const SceneKey& other : scene_keys()) {
      if (hint.empty() && other.name == name.str()) hint = fmt::format(" (did you mean '{}'?)", full_name(other));
    }
    std::string list;
    for (const std::string& s : names) list += (list.empty() ? "" : ", ") + s;
    throw Error(ErrorCode::scene, fmt::format("{}: unknown key{}; allowed here: {}", path, hint, list),
                ctx_.where(path, name.source()));
  }

  void check_section(const SceneSection& s, const toml::node& n, const std::string& path) const {
    if (!s.repeated) {
      if (!n.is_table()) fail_value(ctx_, path, n, fmt::format("must be a table, written [{}]", s.name));
      return;
    }
    bool tables = n.is_array();
    if (tables) {
      for (const toml::node& entry : *n.as_array()) tables = tables && entry.is_table();
    }
    if (!tables) fail_value(ctx_, path, n, fmt::format("must be a list of tables, each written [[{}]]", s.name));
  }

  static bool in_range(const SceneKey& k, const toml::node& n, bool integer) {
    if (integer && !n.is_integer()) return false;
    if (!n.is_number()) return false;
    const double v = *n.value<double>();
    return std::isfinite(v) && (k.low_open ? v > k.low : v >= k.low) && v <= k.high;
  }
  static bool list_of(const SceneKey& k, const toml::node& n, std::size_t size, bool integer) {
    const toml::array* a = n.as_array();
    if (a == nullptr || (size != 0 && a->size() != size)) return false;
    for (const toml::node& e : *a) {
      if (!in_range(k, e, integer)) return false;
    }
    return true;
  }
  static bool boundary_ok(const SceneKey& k, const toml::node& n) {
    if (is_choice(k, &n)) return true;
    const toml::array* a = n.as_array();
    if (a == nullptr || a->size() != 3) return false;
    for (const toml::node& e : *a) {
      if (is_choice(k, &e)) continue;
      const toml::array* pair = e.as_array();
      if (pair == nullptr || pair->size() != 2 || !is_choice(k, pair->get(0)) || !is_choice(k, pair->get(1)))
        return false;
    }
    return true;
  }
  bool value_ok(const SceneKey& k, const toml::node& n) const {
    switch (k.type) {
      case KeyType::number:
        return in_range(k, n, false);
      case KeyType::number_or_none:
        return in_range(k, n, false) || (n.is_string() && n.as_string()->get() == "none");
      case KeyType::integer:
        return in_range(k, n, true);
      case KeyType::boolean:
        return n.is_boolean();
      case KeyType::text:
        return n.is_string();
      case KeyType::choice:
        return is_choice(k, &n);
      case KeyType::vector:
        return list_of(k, n, 3, false);
      case KeyType::numbers:
        return list_of(k, n, 0, false);
      case KeyType::cells:
        return list_of(k, n, 3, true);
      case KeyType::text_pair: {
        const toml::array* a = n.as_array();
        return a != nullptr && a->size() == 2 && a->get(0)->is_string() && a->get(1)->is_string();
      }
      case KeyType::id_range: {
        const toml::array* a = n.as_array();
        return list_of(k, n, 2, true) && *a->get(0)->value<std::int64_t>() <= *a->get(1)->value<std::int64_t>();
      }
      case KeyType::boundary:
        return boundary_ok(k, n);
    }
    return false;
  }
  void check_value(const SceneKey& k, const toml::node& n, const std::string& path) const {
    if (value_ok(k, n)) return;
    std::string hint;
    if (k.type == KeyType::choice && n.is_string()) {
      std::vector<std::string> words;
      std::string rest(k.choices);
      for (std::size_t bar; (bar = rest.find('|')) != std::string::npos; rest.erase(0, bar + 1))
        words.push_back(rest.substr(0, bar));
      words.push_back(rest);
      hint = did_you_mean(n.as_string()->get(), words);
    }
    fail_value(ctx_, path, n, "must be " + allowed_text(k) + hint);
  }
  /// A key that would have no effect here is an error, not noise.
  void check_only(std::string_view name, const toml::node& n) const {
    const SceneKey* k = find_scene_key(section_, name);
    if (k == nullptr || k->only.empty()) return;
    const std::size_t equals = k->only.find('=');
    const std::string_view decider = k->only.substr(0, equals);
    const std::string bars = "|" + std::string(k->only.substr(equals + 1)) + "|";
    if (bars.find("|" + text(decider) + "|") != std::string::npos) return;
    std::string list = bars.substr(1, bars.size() - 2);
    for (std::size_t bar; (bar = list.find('|')) != std::string::npos;) list.replace(bar, 1, ", ");
    fail_value(ctx_, child(name), n,
               fmt::format("has no effect with {} = {}; allowed only for {}", decider, text(decider), list));
  }

  const Context& ctx_;
  const toml::table* table_;
  std::string section_, path_;
};

// ---------------------------------------------------------------------------------------------- building the scene

void check_box(const Reader& r, Vec3 lower, Vec3 upper) {
  for (int k = 0; k < 3; ++k) {
    if (!(lower[k] < upper[k])) r.fail("upper", "must be above 'lower' on every axis");
  }
}

Region read_region(const Reader& r) {
  Region region;
  region.lower = r.vector("lower");
  region.upper = r.vector("upper");
  check_box(r, region.lower, region.upper);
  region.radius = r.number_or("radius", 0);
  return region;
}

/// Names must be unique, since other sections refer to them.
std::string unique_name(const Reader& r, const std::string& fallback, std::vector<std::string>& names) {
  const std::string name = r.has("name") ? r.text("name") : fallback;
  for (const std::string& other : names) {
    if (other != name) continue;
    if (r.has("name")) r.fail("name", "this name is taken; names must be unique");
    return unique_name(r, fallback + "_", names);
  }
  if (r.has("name") && name.empty()) r.fail("name", "must not be empty");
  names.push_back(name);
  return name;
}

void read_domain(const Reader& r, Scene& scene, const std::vector<std::string>& materials) {
  Domain& d = scene.domain;
  d.lower = r.vector("lower");
  d.upper = r.vector("upper");
  check_box(r, d.lower, d.upper);
  const auto word = [](const toml::node& n) {
    const std::string& s = n.as_string()->get();
    return s == "periodic" ? Boundary::periodic : s == "open" ? Boundary::open : Boundary::wall;
  };
  const toml::node& n = r.node("boundary");
  for (int k = 0; k < 3; ++k) {
    const toml::node& axis = n.is_array() ? *n.as_array()->get(static_cast<std::size_t>(k)) : n;
    for (int side = 0; side < 2; ++side)
      d.boundary[k][side] = word(axis.is_array() ? *axis.as_array()->get(static_cast<std::size_t>(side)) : axis);
    if ((d.boundary[k][0] == Boundary::periodic) != (d.boundary[k][1] == Boundary::periodic))
      r.fail("boundary", "an axis is periodic on both sides or on none");
  }
  if (r.has("wall_material")) d.wall_material = r.index("wall_material", materials, "material");
}

void read_time(const Reader& r, Scene& scene) {
  scene.dt = r.number("step");
  r.exclusive("steps", "duration");
  if (r.has("steps")) {
    scene.steps = r.integer("steps");
  } else if (r.has("duration")) {
    const double steps = r.number("duration") / scene.dt;
    if (!(steps < 1e15)) r.fail("duration", "is more than 1e15 steps");
    scene.steps = det::nearest(steps);
  } else {
    r.missing("steps", "(or time.duration)");
  }
}

std::vector<std::string> read_materials(const std::vector<Reader>& list, Scene& scene, const Reader& root) {
  if (list.empty()) root.missing("material", "([[material]] with name and density)");
  if (list.size() > 255) root.fail("material", "at most 255 materials are allowed");
  std::vector<std::string> names;
  for (const Reader& r : list) {
    Material m;
    m.name = unique_name(r, "", names);
    m.density = r.number("density");
    m.young = r.number_or("young", 0);
    m.poisson = r.number_or("poisson", 0);
    scene.materials.push_back(m);
  }
  return names;
}

/// Friction of a section: absent -> fallback, "none" -> 0.
double read_friction(const Reader& r, double fallback) {
  if (!r.has("friction")) return fallback;
  return r.node("friction").is_string() ? 0 : r.number("friction");
}

void read_contact(const Reader& r, const std::vector<Reader>& pairs, const std::vector<Reader>& materials,
                  const std::vector<std::string>& names, Scene& scene) {
  ContactLaw& c = scene.contact;
  c.model = r.choice<ContactModel>("model");
  c.dashpot = r.choice<Dashpot>("dashpot");
  c.lever = r.choice<Lever>("lever");
  c.onset_correction = r.boolean("onset_correction");
  c.synchronised = r.boolean("synchronised");

  const std::size_t n = names.size();
  scene.pairs.assign(n * n, {read_friction(r, 0), r.number_or("restitution", -1)});
  bool any_restitution = r.has("restitution");
  std::vector<char> seen(n * n);
  for (const Reader& p : pairs) {
    const toml::array& two = *p.node("materials").as_array();
    const auto a = static_cast<std::size_t>(p.find_name("materials", *two.get(0), names, "material"));
    const auto b = static_cast<std::size_t>(p.find_name("materials", *two.get(1), names, "material"));
    if (seen[a * n + b]) p.fail("materials", "this pair is given twice");
    seen[a * n + b] = seen[b * n + a] = 1;
    PairCoefficients& k = scene.pairs[a * n + b];
    k.friction = read_friction(p, k.friction);
    k.restitution = p.number_or("restitution", k.restitution);
    any_restitution = any_restitution || p.has("restitution");
    if (p.has("restitution") && r.has("normal_damping"))
      p.fail("restitution", "contradicts 'contact.normal_damping'; give one of the two");
    scene.pairs[b * n + a] = k;
  }
  c.friction = false;
  for (const PairCoefficients& k : scene.pairs) c.friction = c.friction || k.friction > 0;

  if (c.model == ContactModel::linear) {
    r.require("normal_stiffness", "by contact.model = linear");
    r.exclusive("restitution", "normal_damping");
    c.normal_stiffness = r.number("normal_stiffness");
    c.tangential_stiffness = r.number_or("tangential_stiffness", 2.0 / 7.0 * c.normal_stiffness);
    c.normal_damping = r.number("normal_damping");
    c.tangential_damping = r.number("tangential_damping");
    c.by_restitution = any_restitution;
  } else {
    for (const Reader& m : materials) {
      m.require("young", "by the Hertz models");
      m.require("poisson", "by the Hertz models");
    }
  }
  if (c.model != ContactModel::linear || c.by_restitution) {
    for (const PairCoefficients& k : scene.pairs) {
      if (k.restitution < 0) r.missing("restitution", "because some pair of materials has none of its own");
    }
  }
}

SizeDistribution read_size(const Reader& r) {
  SizeDistribution s;
  using Kind = SizeDistribution::Kind;
  s.kind = r.choice<Kind>("kind");
  const std::string why = "by kind = " + r.text("kind");
  s.by_mass = r.text("by") == "mass";
  switch (s.kind) {
    case Kind::constant:
      r.require("diameter", why);
      s.diameter = r.number("diameter");
      break;
    case Kind::normal:
    case Kind::lognormal:
      r.require("mean", why);
      r.require("stddev", why);
      s.mean = r.number("mean");
      s.stddev = r.number("stddev");
      [[fallthrough]];
    case Kind::uniform:
      r.require("min", why);
      r.require("max", why);
      s.min = r.number("min");
      s.max = r.number("max");
      if (!(s.min <= s.max)) r.fail("max", "must not be below 'min'");
      if (s.kind != Kind::uniform && (s.mean + 6 * s.stddev < s.min || s.mean - 6 * s.stddev > s.max))
        r.fail("mean", "lies more than 6 standard deviations outside [min, max]");
      break;
    case Kind::sieve: {
      r.require("edges", why);
      r.require("weights", why);
      s.edges = r.numbers("edges");
      s.weights = r.numbers("weights");
      if (s.weights.empty() || s.edges.size() != s.weights.size() + 1)
        r.fail("edges", fmt::format("must have one entry more than 'weights' ({})", s.weights.size()));
      double sum = 0;
      for (std::size_t i = 0; i < s.weights.size(); ++i) {
        if (!(s.edges[i] < s.edges[i + 1])) r.fail("edges", "must ascend");
        sum += s.weights[i];
      }
      if (!(sum > 0)) r.fail("weights", "must not all be 0");
      break;
    }
  }
  return s;
}

void check_inside(const Reader& source, const Region& region, const Domain& domain) {
  for (int k = 0; k < 3; ++k) {
    if (region.lower[k] < domain.lower[k] || region.upper[k] > domain.upper[k])
      source.section("region").fail(region.lower[k] < domain.lower[k] ? "lower" : "upper",
                                    "the region must lie within the domain");
  }
}

Source read_source(const Reader& r, const Scene& scene, const std::vector<std::string>& materials,
                   const std::vector<std::string>& groups, std::vector<std::string>& names) {
  Source s;
  using Kind = Source::Kind;
  s.kind = r.choice<Kind>("kind");
  s.name = unique_name(r, fmt::format("source_{}", names.size()), names);
  if (r.has("material")) s.material = r.index("material", materials, "material");
  if (r.has("group")) s.group = r.index("group", groups, "group");
  if (s.kind == Kind::file) {
    r.require("file", "by kind = file");
    s.file = r.text("file");
    if (s.file.empty()) r.fail("file", "must not be empty");
    for (std::string_view unused : {"region", "size"}) {
      if (r.has(unused)) r.fail(unused, "has no effect with kind = file");
    }
    return s;
  }
  const std::string why = "by kind = " + r.text("kind");
  r.require("region", why);
  r.require("size", why);
  s.region = read_region(r.section("region"));
  check_inside(r, s.region, scene.domain);
  s.size = read_size(r.section("size"));
  s.velocity = r.vector("velocity");
  s.velocity_jitter = r.number("velocity_jitter");
  if (r.has("number")) s.number = r.integer("number");
  if (r.has("mass")) s.mass = r.number("mass");
  if (r.has("number") && s.number == 0) r.fail("number", "must be 1 or more; leave the key out for no limit");
  if (r.has("mass") && s.mass == 0) r.fail("mass", "must be > 0; leave the key out for no limit");
  s.spacing = r.number("spacing");
  s.lattice = r.choice<Source::Lattice>("lattice");
  s.start = r.number("start");
  s.end = r.number_or("end", k_never);
  if (!(s.end > s.start)) r.fail("end", "must be after 'start'");
  if (s.kind == Kind::random && s.number == 0 && s.mass == 0) r.missing("number", "(or mass) by kind = random");
  if (s.kind == Kind::stream) {
    r.exclusive("number_rate", "mass_rate");
    if (!r.has("number_rate") && !r.has("mass_rate")) r.missing("number_rate", "(or mass_rate) by kind = stream");
    s.number_rate = r.number_or("number_rate", 0);
    s.mass_rate = r.number_or("mass_rate", 0);
    r.require("interval", why);
    s.interval = r.number("interval");
    if (s.interval < scene.dt) r.fail("interval", fmt::format("must be at least one time step ({:g})", scene.dt));
  }
  return s;
}

WallMotion read_motion(const Reader& r) {
  WallMotion m;
  m.velocity = r.vector("velocity");
  m.rotation_axis = r.direction("rotation_axis");
  m.rotation_rate = r.number("rotation_rate");
  m.rotation_origin = r.vector("rotation_origin");
  m.amplitude = r.vector("amplitude");
  m.frequency = r.number("frequency");
  m.phase = r.number("phase");
  m.start = r.number("start");
  m.end = r.number_or("end", k_never);
  if (!(m.end > m.start)) r.fail("end", "must be after 'start'");
  return m;
}

WallSpec read_wall(const Reader& r, const std::vector<std::string>& materials, std::vector<std::string>& names) {
  WallSpec w;
  w.name = unique_name(r, fmt::format("wall_{}", names.size()), names);
  w.shape = r.choice<WallShape>("shape");
  const std::string why = "by shape = " + r.text("shape");
  if (r.has("material")) w.material = r.index("material", materials, "material");
  w.point = r.vector("point");
  w.normal = r.direction("normal");
  w.axis = r.direction("axis");
  if (w.shape == WallShape::cylinder || w.shape == WallShape::cone) {
    r.require("length", why);
    r.require("radius", why);
    w.length = r.number("length");
    w.radius = r.number("radius");
    w.radius_end = w.radius;
    if (w.shape == WallShape::cylinder && w.radius == 0) r.fail("radius", "must be > 0 for a cylinder");
  }
  if (w.shape == WallShape::cone) {
    r.require("radius_end", why);
    w.radius_end = r.number("radius_end");
    if (w.radius == 0 && w.radius_end == 0) r.fail("radius_end", "one of the two radii must be > 0");
  }
  if (w.shape == WallShape::box) {
    r.require("lower", why);
    r.require("upper", why);
    w.lower = r.vector("lower");
    w.upper = r.vector("upper");
    check_box(r, w.lower, w.upper);
  }
  if (w.shape == WallShape::mesh) {
    r.require("file", why);
    w.file = r.text("file");
    if (w.file.empty()) r.fail("file", "must not be empty");
    w.scale = r.number("scale");
    w.shift = r.vector("shift");
  }
  if (r.has("motion")) w.motion = read_motion(r.section("motion"));
  w.appear = r.number("appear");
  w.vanish = r.number_or("vanish", k_never);
  if (!(w.vanish > w.appear)) r.fail("vanish", "must be after 'appear'");
  return w;
}

GroupSpec read_group(const Reader& r, std::vector<std::string>& names) {
  GroupSpec g;
  g.name = unique_name(r, "", names);
  g.fixed_in_file = r.boolean("fixed_in_file");
  if (r.has("region")) g.region = read_region(r.section("region"));
  if (r.has("ids")) {
    const toml::array& a = *r.node("ids").as_array();
    g.ids = {*a.get(0)->value<std::int64_t>(), *a.get(1)->value<std::int64_t>()};
  }
  if (g.ids && (g.region || g.fixed_in_file)) r.fail("ids", "a group has one rule: ids, region or fixed_in_file");
  if (g.region && g.fixed_in_file) r.fail("fixed_in_file", "a group has one rule: ids, region or fixed_in_file");
  return g;
}

Event read_event(const Reader& r, const std::vector<std::string>& groups) {
  Event e;
  e.time = r.number("time");
  e.action = r.choice<Event::Action>("action");
  const std::string why = "by action = " + r.text("action");
  if (e.action == Event::Action::gravity) {
    r.require("gravity", why);
    e.vector = r.vector("gravity");
    return e;
  }
  r.require("group", why);
  e.group = r.index("group", groups, "group");
  e.vector = r.vector("velocity");
  e.spin = r.vector("spin");
  return e;
}

ListSettings read_list(const Reader& r) {
  ListSettings l;
  l.policy = r.choice<ListPolicy>("policy");
  const bool paper = l.policy == ListPolicy::paper;
  l.verlet_k = r.number("verlet_k");
  l.floor = r.number_or("floor", paper ? 0 : l.floor);
  l.floor_on = l.floor > 0;
  l.acceleration_on = r.has("acceleration") ? r.boolean("acceleration") : !paper;
  l.cap_on = r.boolean("cap");
  l.uniform_skin = r.number("uniform_skin");
  l.cell_factor = r.number("cell_factor");
  if (l.cell_factor != 0 && l.cell_factor < 1) r.fail("cell_factor", "must be 0 (chosen by the policy) or at least 1");
  return l;
}

OutputSettings read_output(const Reader& r) {
  OutputSettings o;
  o.particles_every = r.number("particles_every");
  o.vtkhdf = r.boolean("vtkhdf");
  o.vtp = r.boolean("vtp");
  o.csv_every = r.number("csv_every");
  o.energies = r.boolean("energies");
  o.contacts = r.boolean("contacts");
  o.coordination = r.boolean("coordination");
  o.stress = r.boolean("stress");
  if (r.has("grid")) {
    o.grid.on = true;
    for (std::size_t k = 0; k < 3; ++k)
      o.grid.cells[k] = static_cast<int>(*r.node("grid").as_array()->get(k)->value<std::int64_t>());
  }
  std::vector<std::string> names;
  for (const Reader& p : r.sections("plane"))
    o.flux_planes.push_back({unique_name(p, "", names), p.vector("point"), p.direction("normal")});
  names.clear();
  for (const Reader& p : r.sections("region")) o.regions.push_back({unique_name(p, "", names), read_region(p)});
  return o;
}

Scene build(const Context& ctx, const toml::table& table, std::string directory) {
  Scene scene;
  const Reader root(ctx, &table, "", "");
  scene.file = ctx.name;
  scene.directory = std::move(directory);
  scene.title = root.text("title");
  scene.seed = static_cast<std::uint64_t>(root.integer("seed"));
  scene.gravity = root.vector("gravity");
  scene.integrator = root.choice<Integrator>("integrator");
  scene.sort_every = root.integer("sort_every");

  read_time(root.section("time"), scene);
  const std::vector<Reader> materials = root.sections("material");
  const std::vector<std::string> material_names = read_materials(materials, scene, root);
  read_domain(root.section("domain"), scene, material_names);
  const Reader damping = root.section("damping");
  scene.viscous_damping = damping.number("viscous");
  scene.local_damping = damping.number("local");
  read_contact(root.section("contact"), root.sections("pair"), materials, material_names, scene);

  std::vector<std::string> group_names, names;
  for (const Reader& r : root.sections("group")) scene.groups.push_back(read_group(r, group_names));
  for (const Reader& r : root.sections("source"))
    scene.sources.push_back(read_source(r, scene, material_names, group_names, names));
  names.clear();
  for (const Reader& r : root.sections("wall")) scene.walls.push_back(read_wall(r, material_names, names));
  for (const Reader& r : root.sections("event")) scene.events.push_back(read_event(r, group_names));
  scene.list = read_list(root.section("list"));
  scene.output = read_output(root.section("output"));
  const Reader checks = root.section("checks");
  scene.max_overlap = checks.number("max_overlap");
  scene.allow_initial_overlap = checks.boolean("allow_initial_overlap");
  scene.allow_unstable_step = checks.boolean("allow_unstable_step");
  return scene;
}

}  // namespace

Scene parse_scene(std::string_view text, std::string name, std::string directory,
                  const std::vector<std::string>& overrides) {
  Context ctx{std::move(name), {}};
  toml::table table = parse_text(guard(text, ctx.name), ctx.name);
  for (const std::string& o : overrides) apply_override(table, o, ctx);
  return build(ctx, table, std::move(directory));
}

Scene load_scene(const std::string& path, const std::vector<std::string>& overrides) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw Error(ErrorCode::scene, "cannot open the scene file", path, "give the path of a TOML scene file");
  std::string text(k_max_bytes + 1, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (in.bad() || (in.fail() && !in.eof())) throw Error(ErrorCode::scene, "cannot read the scene file", path);
  text.resize(static_cast<std::size_t>(in.gcount()));
  const std::size_t slash = path.rfind('/');
  return parse_scene(text, path, slash == std::string::npos ? "." : path.substr(0, slash + 1), overrides);
}

}  // namespace talus
