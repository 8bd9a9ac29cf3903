// Guarded TOML parse, overrides and the checks of one table against the key table. The only unit that sees toml++.
#include "core/scene/scene_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <sstream>
#include <stdexcept>

#include "core/base/error.hpp"
#include "core/base/text.hpp"
#include "core/heat/property.hpp"
#include "core/scene/scene_keys.hpp"
#include "core/scene/scene_suggest.hpp"
#include "core/scene/scene_text.hpp"
#include "core/scene/toml_tree.hpp"

namespace talus {
[[noreturn]] static void toml_assertion(const char* text) { throw std::logic_error(text); }
}  // namespace talus
// toml++ drops its own assertion under NDEBUG and aborts otherwise; both are wrong for text that a user wrote.
#undef NDEBUG
#define TOML_ASSERT(expr) ((expr) ? static_cast<void>(0) : ::talus::toml_assertion(#expr))
#include <toml++/toml.h>

namespace talus {
namespace {

constexpr double k_infinite = std::numeric_limits<double>::infinity();

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

// The only ways from a node to a value. toml++'s own value<T>() is empty for integers that T cannot hold exactly, which
// is easily taken for a wrong type or, unchecked, for a value.

/// Integers beyond 2^53 round as any other number would.
std::optional<double> number_in(const toml::node& node) {
  if (const auto* f = node.as_floating_point()) return f->get();
  if (const auto* i = node.as_integer()) return static_cast<double>(i->get());
  return {};
}
std::optional<std::int64_t> integer_in(const toml::node& node) {
  const auto* i = node.as_integer();
  return i != nullptr ? std::optional<std::int64_t>(i->get()) : std::nullopt;
}
std::optional<bool> boolean_in(const toml::node& node) {
  const auto* b = node.as_boolean();
  return b != nullptr ? std::optional<bool>(b->get()) : std::nullopt;
}
std::optional<std::string> text_in(const toml::node& node) {
  const auto* t = node.as_string();
  return t != nullptr ? std::optional<std::string>(t->get()) : std::nullopt;
}

/// A value whose type the Checker has established before.
template <class T>
T known(std::optional<T> value) {
  if (!value) throw std::logic_error("a value of a scene was read as another type than it was checked for");
  return *std::move(value);
}

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
    s = fmt::format("{}", known(number_in(node)));
  } else {
    std::ostringstream out;
    node.visit([&](const auto& n) { out << n; });
    s = out.str();
  }
  return shown(s, 60);
}

[[noreturn]] void fail_value(const Context& ctx, const std::string& path, const toml::node& node,
                             const std::string& allowed) {
  throw Error(ErrorCode::scene, fmt::format("{}: {}: {}", path, value_text(node), allowed),
              ctx.where(path, node.source()));
}

// ---------------------------------------------------------------------------------------------- guarded parse

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
  if (text.size() > k_scene_bytes) throw Error(ErrorCode::scene, "longer than 1 MiB", "--set");
  for (std::size_t i = 0, n = 0; i < text.size(); i += n) {
    n = utf8_length(text, i);
    if (n == 0 || control_length(text, i) != 0)
      throw Error(ErrorCode::scene, "control characters and bytes that are no UTF-8 are not allowed", where);
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
      throw Error(ErrorCode::scene, fmt::format("{}: unknown section '{}'{}", path, section, key_hint(path, true)),
                  where);
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
    parsed = toml::parse(guarded_scene_text("v = " + value, where), std::string_view("--set"));
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
      if (!k.has_default()) continue;
      m.emplace(&k, toml::parse(fmt::format("v = {}", k.fallback)));
    }
    return m;
  }();
  return *defaults.at(&key).get("v");
}

std::string join(std::string_view path, std::string_view name) {
  return path.empty() ? std::string(name) : fmt::format("{}.{}", path, name);
}

std::vector<std::string> choice_words(const SceneKey& key) {
  const std::vector<std::string_view> words = split_words(key.choices, ", ");
  return {words.begin(), words.end()};
}

bool is_choice(const SceneKey& key, const toml::node* node) {
  if (node == nullptr || !node->is_string()) return false;
  const std::vector<std::string> words = choice_words(key);
  return std::find(words.begin(), words.end(), node->as_string()->get()) != words.end();
}

template <class T>
std::vector<T> list_values(const toml::node& node, std::optional<T> (*value_in)(const toml::node&)) {
  const toml::array* list = node.as_array();
  if (list == nullptr) throw std::logic_error("a value of a scene was read as a list");
  std::vector<T> values;
  for (const toml::node& n : *list) values.push_back(known(value_in(n)));
  return values;
}

const toml::node& node_of(const toml::table* table, const std::string& section, std::string_view name) {
  if (table != nullptr && table->get(name) != nullptr) return *table->get(name);  // also sections, for messages
  const SceneKey* k = find_scene_key(section, name);
  if (k == nullptr) throw std::logic_error("key not in the table: " + section + "." + std::string(name));
  return default_node(*k);
}

/// Checks of one table: unknown keys, types, ranges, keys without effect.
class Checker {
 public:
  Checker(const Context& ctx, const toml::table& table, const std::string& section, const std::string& path)
      : ctx_(ctx), table_(table), section_(section), path_(path) {}
  void types() const {
    for (auto&& [key, node] : table_) check(key, node);
  }
  void effects() const {
    for (auto&& [key, node] : table_) check_only(key.str(), node);
  }

 private:
  std::string child(std::string_view name) const { return join(path_, name); }
  std::string full(std::string_view name) const { return join(section_, name); }

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
    const std::string where = ctx_.where(path, name.source());
    // A table with this name is a section that is written wrongly; anything else is a key.
    std::string hint = n.is_table() || n.is_array_of_tables() ? did_you_mean(name.str(), names) : "";
    if (hint.empty()) hint = key_hint(path, where.starts_with("--set "));
    std::string list;
    for (const std::string& s : names) list += (list.empty() ? "" : ", ") + s;
    throw Error(ErrorCode::scene, fmt::format("{}: unknown key{}; allowed here: {}", path, hint, list), where);
  }

  void check_section(const SceneSection& s, const toml::node& n, const std::string& path) const {
    if (!s.repeated) {
      if (!n.is_table())
        fail_value(ctx_, path, n,
                   fmt::format("must be a table, written [{0}] or {1} = {{ key = value }} (`talus help scene {0}`)",
                               s.name, s.name.substr(s.name.rfind('.') + 1)));
      return;
    }
    bool tables = n.is_array();
    if (tables) {
      for (const toml::node& entry : *n.as_array()) tables = tables && entry.is_table();
    }
    if (!tables) fail_value(ctx_, path, n, fmt::format("must be a list of tables, each written [[{}]]", s.name));
  }

  static bool in_range(const SceneKey& k, const toml::node& n, bool integer) {
    const std::optional<double> v = number_in(n);
    if (!v || (integer && !n.is_integer())) return false;
    return std::isfinite(*v) && (k.low_open ? *v > k.low : *v >= k.low) && *v <= k.high;
  }
  static bool is_text(const toml::node* n) {
    return n != nullptr && n->is_string() && is_scene_text(n->as_string()->get());
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
  /// [[x, value], ...] with ascending x.
  static bool points_ok(const SceneKey& k, const toml::node& n, std::size_t least) {
    const toml::array* a = n.as_array();
    if (a == nullptr || a->size() < least) return false;
    double last = -k_infinite;
    for (const toml::node& e : *a) {
      const toml::array* point = e.as_array();
      if (point == nullptr || point->size() != 2 || !in_range(k, *point->get(1), false)) return false;
      const std::optional<double> x = number_in(*point->get(0));
      if (!x || !std::isfinite(*x) || !(*x > last)) return false;
      last = *x;
    }
    return true;
  }
  /// A finite list of numbers, `size` of them where that is not 0.
  static bool finite_list(const toml::node* n, std::size_t size) {
    const toml::array* a = n != nullptr ? n->as_array() : nullptr;
    if (a == nullptr || a->empty() || (size != 0 && a->size() != size)) return false;
    for (const toml::node& e : *a)
      if (const std::optional<double> v = number_in(e); !v || !std::isfinite(*v)) return false;
    return true;
  }
  static bool property_ok(const SceneKey& k, const toml::node& n) {
    const toml::table* t = n.as_table();
    if (t == nullptr) return in_range(k, n, false);
    if (const toml::node* points = t->get("table")) return t->size() == 1 && points_ok(k, *points, 2);
    if (!finite_list(t->get("polynomial"), 0)) return false;
    for (auto&& [name, value] : *t) {
      if (name.str() == "polynomial") continue;
      if (name.str() == "origin") {
        const std::optional<double> x = number_in(value);
        if (!x || !std::isfinite(*x)) return false;
      } else if (name.str() == "range") {
        if (!finite_list(&value, 2)) return false;
        const std::vector<double> ends = list_values<double>(value, number_in);
        if (!(ends[0] < ends[1])) return false;
      } else {
        return false;
      }
    }
    return true;
  }
  bool value_ok(const SceneKey& k, const toml::node& n) const {
    switch (k.type) {
      case KeyType::number:
        return in_range(k, n, false);
      case KeyType::number_or_none:
        return in_range(k, n, false) || (n.is_string() && n.as_string()->get() == "none");
      case KeyType::number_or_auto:
        return in_range(k, n, false) || (n.is_string() && n.as_string()->get() == "auto");
      case KeyType::integer:
        return in_range(k, n, true);
      case KeyType::boolean:
        return n.is_boolean();
      case KeyType::text:
        return is_text(&n);
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
        return a != nullptr && a->size() == 2 && is_text(a->get(0)) && is_text(a->get(1));
      }
      case KeyType::id_range: {
        const toml::array* a = n.as_array();
        return list_of(k, n, 2, true) && integer_in(*a->get(0)) <= integer_in(*a->get(1));
      }
      case KeyType::property:
        return property_ok(k, n);
      case KeyType::series:
        return in_range(k, n, false) || points_ok(k, n, 1);
      case KeyType::boundary:
        return boundary_ok(k, n);
    }
    return false;
  }
  void check_value(const SceneKey& k, const toml::node& n, const std::string& path) const {
    if (value_ok(k, n)) return;
    std::string hint;
    if (k.type == KeyType::choice && n.is_string()) {
      hint = did_you_mean(n.as_string()->get(), choice_words(k));
    }
    // an upper bound beyond every physical quantity is left out of allowed_text
    if (const std::optional<double> v = number_in(n); v && *v > k.high && std::isfinite(*v))
      hint = fmt::format(", at most {:g}", k.high);
    fail_value(ctx_, path, n, "must be " + allowed_text(k) + hint);
  }
  /// A key that would have no effect here is an error, not noise.
  void check_only(std::string_view name, const toml::node& n) const {
    const SceneKey* k = find_scene_key(section_, name);
    if (k == nullptr || k->only.empty()) return;
    const KeyCondition only = condition_of(k->only);
    const std::string value = known(text_in(node_of(&table_, section_, only.key)));
    if (only.holds(value)) return;
    fail_value(ctx_, child(name), n,
               fmt::format("has no effect with {} = {}; allowed only for {}", only.key, value, only.text()));
  }

  const Context& ctx_;
  const toml::table& table_;
  const std::string& section_;
  const std::string& path_;
};

const toml::table* as_table(const void* table) { return static_cast<const toml::table*>(table); }

}  // namespace

struct SceneTable::Text {
  Context context;
  toml::table root;
};

SceneTable SceneTable::parse(std::string_view text, const std::string& name,
                             const std::vector<std::string>& overrides) {
  auto whole = std::make_shared<Text>();
  whole->context.name = name;
  whole->root = parse_text(guarded_scene_text(text, name), name);
  for (const std::string& o : overrides) apply_override(whole->root, o, whole->context);
  const void* root = &whole->root;
  return SceneTable(std::move(whole), root, "", "");
}

SceneTable::SceneTable(std::shared_ptr<const Text> text, const void* table, std::string section, std::string path)
    : text_(std::move(text)), table_(table), section_(std::move(section)), path_(std::move(path)) {
  if (table_ == nullptr && find_scene_section(section_) == nullptr) throw std::logic_error("no section " + section_);
  if (table_ != nullptr) Checker(text_->context, *as_table(table_), section_, path_).types();
  for (const SceneKey& k : scene_keys()) {
    if (k.section == section_ && k.required() && !has(k.name)) missing(k.name);
  }
  if (table_ != nullptr) Checker(text_->context, *as_table(table_), section_, path_).effects();
}

std::string SceneTable::child(std::string_view name) const { return join(path_, name); }
std::string SceneTable::full(std::string_view name) const { return join(section_, name); }

bool SceneTable::has(std::string_view name) const {
  return table_ != nullptr && as_table(table_)->get(name) != nullptr;
}

double SceneTable::number(std::string_view name) const {
  return known(number_in(node_of(as_table(table_), section_, name)));
}
std::optional<double> SceneTable::number_or_text(std::string_view name) const {
  const toml::node& n = node_of(as_table(table_), section_, name);
  return n.is_string() ? std::nullopt : number_in(n);
}
std::int64_t SceneTable::integer(std::string_view name) const {
  return known(integer_in(node_of(as_table(table_), section_, name)));
}
bool SceneTable::boolean(std::string_view name) const {
  return known(boolean_in(node_of(as_table(table_), section_, name)));
}
std::string SceneTable::text(std::string_view name) const {
  return known(text_in(node_of(as_table(table_), section_, name)));
}

Vec3 SceneTable::vector(std::string_view name) const {
  const std::vector<double> v = numbers(name);
  return {v[0], v[1], v[2]};
}

Vec3 SceneTable::direction(std::string_view name) const {
  const Vec3 v = vector(name);
  const double length = std::sqrt(norm2(v));
  if (!(length > 0) || !std::isfinite(length)) fail(name, "must not be the zero vector");
  return {v.x / length, v.y / length, v.z / length};
}

std::vector<double> SceneTable::numbers(std::string_view name) const {
  return list_values<double>(node_of(as_table(table_), section_, name), number_in);
}
namespace {

void read_points(const toml::node& list, std::vector<double>& at, std::vector<double>& value) {
  for (const toml::node& point : *list.as_array()) {
    at.push_back(known(number_in(*point.as_array()->get(0))));
    value.push_back(known(number_in(*point.as_array()->get(1))));
  }
}

}  // namespace

Curve SceneTable::curve(std::string_view name) const {
  const toml::node& n = node_of(as_table(table_), section_, name);
  if (const auto number = number_in(n)) return Curve::constant(*number);
  Curve c;
  const toml::table& t = *n.as_table();
  if (const toml::node* points = t.get("table")) {
    read_points(*points, c.at, c.value);
    return c;
  }
  c.coefficients = list_values<double>(*t.get("polynomial"), number_in);
  if (const toml::node* origin = t.get("origin")) c.origin = known(number_in(*origin));
  if (const toml::node* range = t.get("range")) {
    const std::vector<double> ends = list_values<double>(*range, number_in);
    c.low = ends[0];
    c.high = ends[1];
  }
  const SceneKey& key = *find_scene_key(section_, name);
  const heat::Property p = heat::Property::of(c);
  for (int k = 0; k <= 256; ++k) {
    const double T = c.low + (c.high - c.low) * k / 256, v = p.at(T);
    if (!(std::isfinite(v) && (key.low_open ? v > key.low : v >= key.low) && v <= key.high))
      fail(name, fmt::format("is {:.4g} at {:.4g} K; give a range = [T1, T2] in which it is {}", v, T,
                             allowed_text(key).substr(0, allowed_text(key).find(','))));
  }
  return c;
}

TimeTable SceneTable::time_table(std::string_view name) const {
  const toml::node& n = node_of(as_table(table_), section_, name);
  if (const auto number = number_in(n)) return TimeTable::constant(*number);
  TimeTable t;
  read_points(n, t.time, t.value);
  return t;
}

std::vector<std::int64_t> SceneTable::integers(std::string_view name) const {
  return list_values<std::int64_t>(node_of(as_table(table_), section_, name), integer_in);
}
std::vector<std::string> SceneTable::texts(std::string_view name) const {
  return list_values<std::string>(node_of(as_table(table_), section_, name), text_in);
}

std::array<std::array<std::string, 2>, 3> SceneTable::boundary(std::string_view name) const {
  std::array<std::array<std::string, 2>, 3> words;
  const toml::node& n = node_of(as_table(table_), section_, name);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const toml::node& a = n.is_array() ? *n.as_array()->get(axis) : n;
    for (std::size_t side = 0; side < 2; ++side)
      words[axis][side] = known(text_in(a.is_array() ? *a.as_array()->get(side) : a));
  }
  return words;
}

int SceneTable::choice_index(std::string_view name) const {
  const std::string word = text(name);
  const std::vector<std::string> words = choice_words(*find_scene_key(section_, name));
  return static_cast<int>(std::find(words.begin(), words.end(), word) - words.begin());
}

int SceneTable::index(std::string_view name, const std::vector<std::string>& names, std::string_view what,
                      int entry) const {
  const toml::node& whole = node_of(as_table(table_), section_, name);
  const toml::node& n = entry < 0 ? whole : *whole.as_array()->get(static_cast<std::size_t>(entry));
  const std::string wanted = known(text_in(n));
  std::string list;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == wanted) return static_cast<int>(i);
    list += (list.empty() ? "" : ", ") + names[i];
  }
  fail_value(text_->context, child(name), n,
             fmt::format("no such {}{}; there is {}", what, did_you_mean(wanted, names), list.empty() ? "none" : list));
}

void SceneTable::require(std::string_view name, std::string_view why) const {
  if (!has(name)) missing(name, why);
}

void SceneTable::exclusive(std::string_view a, std::string_view b) const {
  if (has(a) && has(b)) fail(b, fmt::format("contradicts '{}'; give one of the two", a));
}

void SceneTable::fail(std::string_view name, const std::string& allowed) const {
  fail_value(text_->context, child(name), node_of(as_table(table_), section_, name), allowed);
}

void SceneTable::missing(std::string_view name, std::string_view why) const {
  const SceneKey* k = find_scene_key(section_, name);
  throw Error(ErrorCode::scene,
              fmt::format("{}: missing: required{}{}; must be {}", child(name), why.empty() ? "" : " ", why,
                          k != nullptr ? allowed_text(*k) : "a table"),
              text_->context.where(path_, table_ != nullptr ? as_table(table_)->source() : toml::source_region{}));
}

SceneTable SceneTable::section(std::string_view name) const {
  const toml::node* n = table_ != nullptr ? as_table(table_)->get(name) : nullptr;
  return SceneTable(text_, n != nullptr ? n->as_table() : nullptr, full(name), child(name));
}

std::vector<SceneTable> SceneTable::sections(std::string_view name) const {
  std::vector<SceneTable> list;
  const toml::node* n = table_ != nullptr ? as_table(table_)->get(name) : nullptr;
  if (n == nullptr) return list;
  for (const toml::node& entry : *n->as_array())
    list.push_back(SceneTable(text_, entry.as_table(), full(name), fmt::format("{}.{}", child(name), list.size())));
  return list;
}

namespace {

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\')
      (out += '\\') += c;
    else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
      out += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    else
      out += c;
  }
  return out + "\"";
}

/// A value of a key in normal form: numbers as the shortest text that reads back to the same double.
std::string normal_text(const SceneKey& key, const toml::node& node) {
  if (const toml::array* list = node.as_array()) {
    std::string s;
    for (const toml::node& entry : *list) s += (s.empty() ? "" : ", ") + normal_text(key, entry);
    return "[" + s + "]";
  }
  if (const toml::table* table = node.as_table()) {
    std::string s;
    for (auto&& [name, value] : *table)
      s += fmt::format("{}{} = {}", s.empty() ? "" : ", ", name.str(), normal_text(key, value));
    return "{ " + s + " }";
  }
  if (node.is_string()) return quoted(node.as_string()->get());
  if (node.is_boolean()) return node.as_boolean()->get() ? "true" : "false";
  const bool whole = key.type == KeyType::integer || key.type == KeyType::cells || key.type == KeyType::id_range;
  if (!node.is_integer()) return fmt::format("{}", known(number_in(node)));
  const std::int64_t n = node.as_integer()->get();
  return whole ? fmt::format("{}", n) : fmt::format("{}", static_cast<double>(n));
}

}  // namespace

std::vector<SceneValue> SceneTable::values() const {
  std::vector<SceneValue> all;
  if (table_ == nullptr) return all;
  for (const SceneKey& k : scene_keys()) {
    if (k.section != section_ || !has(k.name)) continue;
    all.push_back({child(k.name), section_, std::string(k.name), normal_text(k, *as_table(table_)->get(k.name))});
  }
  for (const SceneSection& s : scene_sections()) {
    const std::size_t dot = s.name.rfind('.');
    const std::string_view parent = dot == std::string_view::npos ? "" : s.name.substr(0, dot);
    const std::string_view name = dot == std::string_view::npos ? s.name : s.name.substr(dot + 1);
    if (s.name.empty() || parent != section_ || !has(name)) continue;
    const std::vector<SceneTable> entries = s.repeated ? sections(name) : std::vector<SceneTable>{section(name)};
    for (const SceneTable& entry : entries) {
      const std::vector<SceneValue> below = entry.values();
      all.insert(all.end(), below.begin(), below.end());
    }
  }
  return all;
}

namespace {

TomlNode tree_of(const toml::node& node, const std::string& name) {
  TomlNode out;
  out.where = fmt::format("{}:{}:{}", name, node.source().begin.line, node.source().begin.column);
  out.shown = value_text(node);
  if (const auto number = number_in(node)) {
    out.type = node.is_integer() ? TomlNode::Type::integer : TomlNode::Type::number;
    out.number = *number;
    out.integer = integer_in(node).value_or(0);
  } else if (const auto boolean = boolean_in(node)) {
    out.type = TomlNode::Type::boolean;
    out.boolean = *boolean;
  } else if (const auto text = text_in(node)) {
    out.type = TomlNode::Type::text;
    out.text = *text;
  } else if (const toml::array* list = node.as_array()) {
    out.type = TomlNode::Type::list;
    for (const toml::node& n : *list) out.list.push_back(tree_of(n, name));
  } else if (const toml::table* table = node.as_table()) {
    out.type = TomlNode::Type::table;
    for (auto&& [key, value] : *table) out.table.emplace_back(std::string(key.str()), tree_of(value, name));
  }
  return out;
}

}  // namespace

TomlNode parse_toml_tree(std::string_view text, const std::string& name) {
  return tree_of(parse_text(guarded_scene_text(text, name), name), name);
}

}  // namespace talus
