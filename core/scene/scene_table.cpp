// Reading of one table of a scene that scene_check.cpp has let pass.
#include "core/scene/scene_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/base/error.hpp"
#include "core/heat/property.hpp"
#include "core/scene/scene_check.hpp"
#include "core/scene/scene_override.hpp"
#include "core/scene/scene_suggest.hpp"

namespace talus {
namespace {

std::optional<double> number_in(const TomlNode& node) {
  return node.is_number() ? std::optional<double>(node.number) : std::nullopt;
}
std::optional<std::int64_t> integer_in(const TomlNode& node) {
  return node.is_integer() ? std::optional<std::int64_t>(node.integer) : std::nullopt;
}
std::optional<bool> boolean_in(const TomlNode& node) {
  return node.type == TomlNode::Type::boolean ? std::optional<bool>(node.boolean) : std::nullopt;
}
std::optional<std::string> text_in(const TomlNode& node) {
  return node.is_text() ? std::optional<std::string>(node.text) : std::nullopt;
}

/// A value whose type the checks have established before.
template <class T>
T known(std::optional<T> value) {
  if (!value) throw std::logic_error("a value of a scene was read as another type than it was checked for");
  return *std::move(value);
}

template <class T>
std::vector<T> list_values(const TomlNode& node, std::optional<T> (*value_in)(const TomlNode&)) {
  if (!node.is_list()) throw std::logic_error("a value of a scene was read as a list");
  std::vector<T> values;
  for (const TomlNode& n : node.list) values.push_back(known(value_in(n)));
  return values;
}

}  // namespace

struct SceneTable::Text {
  SceneContext context;
  TomlNode root;
};

SceneTable SceneTable::parse(std::string_view text, const std::string& name,
                             const std::vector<std::string>& overrides) {
  auto whole = std::make_shared<Text>();
  whole->context.name = name;
  whole->root = parse_toml_tree(text, name);
  for (const std::string& o : overrides) apply_override(whole->root, o, whole->context);
  const TomlNode* root = &whole->root;
  return SceneTable(std::move(whole), root, "", "");
}

SceneTable::SceneTable(std::shared_ptr<const Text> text, const TomlNode* table, std::string section, std::string path)
    : text_(std::move(text)), table_(table), section_(std::move(section)), path_(std::move(path)) {
  if (table_ == nullptr && find_scene_section(section_) == nullptr) throw std::logic_error("no section " + section_);
  if (table_ != nullptr) check_types(text_->context, *table_, section_, path_);
  for (const SceneKey& k : scene_keys()) {
    if (k.section == section_ && k.required() && !has(k.name)) missing(k.name);
  }
  if (table_ != nullptr) check_effects(text_->context, *table_, section_, path_);
}

std::string SceneTable::child(std::string_view name) const { return join_path(path_, name); }
std::string SceneTable::full(std::string_view name) const { return join_path(section_, name); }

bool SceneTable::has(std::string_view name) const { return table_ != nullptr && table_->find(name) != nullptr; }

double SceneTable::number(std::string_view name) const { return known(number_in(node_of(table_, section_, name))); }
std::optional<double> SceneTable::number_or_text(std::string_view name) const {
  const TomlNode& n = node_of(table_, section_, name);
  return n.is_text() ? std::nullopt : number_in(n);
}
std::int64_t SceneTable::integer(std::string_view name) const {
  return known(integer_in(node_of(table_, section_, name)));
}
bool SceneTable::boolean(std::string_view name) const { return known(boolean_in(node_of(table_, section_, name))); }
std::string SceneTable::text(std::string_view name) const { return known(text_in(node_of(table_, section_, name))); }

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
  return list_values<double>(node_of(table_, section_, name), number_in);
}
namespace {

void read_points(const TomlNode& list, std::vector<double>& at, std::vector<double>& value) {
  for (const TomlNode& point : list.list) {
    at.push_back(known(number_in(point.list[0])));
    value.push_back(known(number_in(point.list[1])));
  }
}

}  // namespace

Curve SceneTable::curve(std::string_view name) const {
  constexpr const char* below_zero = "has a temperature below 0: they are in kelvin";
  const TomlNode& n = node_of(table_, section_, name);
  if (const auto number = number_in(n)) return Curve::constant(*number);
  Curve c;
  if (const TomlNode* points = n.find("table")) {
    read_points(*points, c.at, c.value);
    if (c.at.front() < 0) fail(name, below_zero);
    return c;
  }
  c.coefficients = list_values<double>(*n.find("polynomial"), number_in);
  if (const TomlNode* origin = n.find("origin")) c.origin = known(number_in(*origin));
  if (const TomlNode* range = n.find("range")) {
    const std::vector<double> ends = list_values<double>(*range, number_in);
    c.low = ends[0];
    c.high = ends[1];
  }
  if (c.low < 0 || c.origin < 0) fail(name, below_zero);
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
  const TomlNode& n = node_of(table_, section_, name);
  if (const auto number = number_in(n)) return TimeTable::constant(*number);
  TimeTable t;
  read_points(n, t.time, t.value);
  return t;
}

std::vector<std::int64_t> SceneTable::integers(std::string_view name) const {
  return list_values<std::int64_t>(node_of(table_, section_, name), integer_in);
}
std::vector<std::string> SceneTable::texts(std::string_view name) const {
  return list_values<std::string>(node_of(table_, section_, name), text_in);
}

std::array<std::array<std::string, 2>, 3> SceneTable::boundary(std::string_view name) const {
  std::array<std::array<std::string, 2>, 3> words;
  const TomlNode& n = node_of(table_, section_, name);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const TomlNode& a = n.is_list() ? n.list[axis] : n;
    for (std::size_t side = 0; side < 2; ++side) words[axis][side] = known(text_in(a.is_list() ? a.list[side] : a));
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
  const TomlNode& whole = node_of(table_, section_, name);
  const TomlNode& n = entry < 0 ? whole : whole.list[static_cast<std::size_t>(entry)];
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
  const TomlNode& node = node_of(table_, section_, name);
  const bool list = node.is_list() && !node.list.empty();
  if (!node.is_table() && !(list && node.list.front().is_table()))
    fail_value(text_->context, child(name), node, allowed);
  // A whole section: its name and line say which; it has no value that a line could show.
  throw Error(ErrorCode::scene, fmt::format("{}: {}", child(name), allowed),
              text_->context.where(child(name), node.where.empty() ? text_->context.name : node.where));
}

void SceneTable::missing(std::string_view name, std::string_view why) const {
  const SceneKey* k = find_scene_key(section_, name);
  throw Error(ErrorCode::scene,
              fmt::format("{}: missing: required{}{}; must be {}", child(name), why.empty() ? "" : " ", why,
                          k != nullptr ? allowed_text(*k) : "a table"),
              text_->context.where(path_, table_ != nullptr ? table_->where : text_->context.name));
}

SceneTable SceneTable::section(std::string_view name) const {
  const TomlNode* n = table_ != nullptr ? table_->find(name) : nullptr;
  return SceneTable(text_, n != nullptr && n->is_table() ? n : nullptr, full(name), child(name));
}

std::vector<SceneTable> SceneTable::sections(std::string_view name) const {
  std::vector<SceneTable> list;
  const TomlNode* n = table_ != nullptr ? table_->find(name) : nullptr;
  if (n == nullptr) return list;
  for (const TomlNode& entry : n->list)
    list.push_back(SceneTable(text_, &entry, full(name), fmt::format("{}.{}", child(name), list.size())));
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
std::string normal_text(const SceneKey& key, const TomlNode& node) {
  if (node.is_list()) {
    std::string s;
    for (const TomlNode& entry : node.list) s += (s.empty() ? "" : ", ") + normal_text(key, entry);
    return "[" + s + "]";
  }
  if (node.is_table()) {
    std::string s;
    for (const auto& [name, value] : node.table)
      s += fmt::format("{}{} = {}", s.empty() ? "" : ", ", name, normal_text(key, value));
    return "{ " + s + " }";
  }
  if (node.is_text()) return quoted(node.text);
  if (node.type == TomlNode::Type::boolean) return node.boolean ? "true" : "false";
  const bool whole = key.type == KeyType::integer || key.type == KeyType::cells || key.type == KeyType::id_range;
  if (!node.is_integer()) return fmt::format("{}", known(number_in(node)));
  const std::int64_t n = node.integer;
  return whole ? fmt::format("{}", n) : fmt::format("{}", static_cast<double>(n));
}

}  // namespace

std::vector<SceneValue> SceneTable::values() const {
  std::vector<SceneValue> all;
  if (table_ == nullptr) return all;
  for (const SceneKey& k : scene_keys()) {
    if (k.section != section_ || !has(k.name)) continue;
    all.push_back({child(k.name), section_, std::string(k.name), normal_text(k, *table_->find(k.name))});
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

}  // namespace talus
