// Checks and getters of grain_table.hpp.
#include "core/conversion/grain_table.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <stdexcept>

#include "core/base/error.hpp"
#include "core/base/suggest.hpp"

namespace talus::conversion {
namespace {

using Type = TomlNode::Type;

bool is_number(const TomlNode& n) { return n.type == Type::number || n.type == Type::integer; }

bool in_range(const GrainKey& k, const TomlNode& n) {
  if (!is_number(n) || !std::isfinite(n.number)) return false;
  return (k.low_open ? n.number > k.low : n.number >= k.low) && n.number <= k.high;
}

/// [[x, value], ...] with ascending x.
bool is_table(const GrainKey& k, const TomlNode& n, std::size_t least) {
  if (n.type != Type::list || n.list.size() < least) return false;
  for (std::size_t i = 0; i < n.list.size(); ++i) {
    const TomlNode& p = n.list[i];
    if (p.type != Type::list || p.list.size() != 2 || !is_number(p.list[0]) || !std::isfinite(p.list[0].number))
      return false;
    if (!in_range(k, p.list[1])) return false;
    if (i > 0 && !(p.list[0].number > n.list[i - 1].list[0].number)) return false;
  }
  return true;
}

bool is_property(const GrainKey& k, const TomlNode& n) {
  if (is_number(n)) return in_range(k, n);
  if (n.type != Type::table) return false;
  for (const auto& [name, value] : n.table)
    if (name != "polynomial" && name != "origin" && name != "range" && name != "table") return false;
  const TomlNode *table = n.find("table"), *polynomial = n.find("polynomial");
  if (table != nullptr) return n.table.size() == 1 && is_table(k, *table, 2);
  if (polynomial == nullptr || polynomial->type != Type::list || polynomial->list.empty()) return false;
  for (const TomlNode& c : polynomial->list)
    if (!is_number(c) || !std::isfinite(c.number)) return false;
  if (const TomlNode* origin = n.find("origin"); origin != nullptr && !is_number(*origin)) return false;
  const TomlNode* range = n.find("range");
  return range == nullptr || (range->type == Type::list && range->list.size() == 2 && is_number(range->list[0]) &&
                              is_number(range->list[1]) && range->list[0].number < range->list[1].number);
}

std::vector<std::string> words_of(std::string_view choices) {
  std::vector<std::string> words{""};
  for (const char c : choices) {
    if (c == '|')
      words.emplace_back();
    else
      words.back() += c;
  }
  return words;
}

[[noreturn]] void fault(const std::string& where, const std::string& path, const std::string& shown,
                        const std::string& why) {
  throw Error(ErrorCode::scene, fmt::format("{}: {}: {}", path, shown, why), where);
}

}  // namespace

GrainTable::GrainTable(const TomlNode* node, std::string section, std::string path, std::string file)
    : node_(node), section_(std::move(section)), path_(std::move(path)), file_(std::move(file)) {
  if (node_ != nullptr) {
    if (node_->type != Type::table) fault(node_->where, path_, node_->shown, "must be a table");
    for (const auto& [name, value] : node_->table) check(name, value);
  }
  if (node_ == nullptr && section_ != "grain" && section_ != "time" && section_ != "material" &&
      section_ != "heat_capacity" && section_ != "conductivity" && section_ != "surroundings")
    return;
  for (const GrainKey& k : grain_keys())
    if (k.section == section_ && k.fallback == "required" && !has(k.name)) missing(k.name, "required");
}

void GrainTable::check(const std::string& name, const TomlNode& value) const {
  std::vector<std::string> names;
  for (const GrainKey& k : grain_keys()) {
    if (k.section != section_) continue;
    names.emplace_back(k.name);
    if (k.name != name) continue;
    if (!fits(k, value)) {
      const bool word = k.type == GrainKeyType::choice && value.type == Type::text;
      fault(value.where, full(name), value.shown,
            "must be " + allowed_text(k) + (word ? choice_hint(value.text, words_of(k.choices)) : ""));
    }
    return;
  }
  if (section_.empty())
    for (const GrainSection& s : grain_sections()) {
      if (s.name.empty()) continue;
      names.emplace_back(s.name);
      if (s.name != name) continue;
      bool tables = value.type == Type::list;
      for (const TomlNode& entry : value.list) tables = tables && entry.type == Type::table;
      if (s.repeated ? !tables : value.type != Type::table)
        fault(value.where, name, value.shown,
              s.repeated ? "must be a list of tables, each written [[" + name + "]]"
                         : "must be a table, written [" + name + "]");
      return;
    }
  std::string all;
  for (const std::string& n : names) all += (all.empty() ? "" : ", ") + n;
  throw Error(ErrorCode::scene,
              fmt::format("{}: unknown key{}; allowed here: {}", full(name), did_you_mean(name, names), all),
              value.where);
}

bool GrainTable::fits(const GrainKey& k, const TomlNode& v) const {
  switch (k.type) {
    case GrainKeyType::number:
      return in_range(k, v);
    case GrainKeyType::integer:
      return v.type == Type::integer && in_range(k, v);
    case GrainKeyType::boolean:
      return v.type == Type::boolean;
    case GrainKeyType::text:
      return v.type == Type::text && !v.text.empty();
    case GrainKeyType::choice: {
      if (v.type != Type::text) return false;
      for (const std::string& w : words_of(k.choices))
        if (w == v.text) return true;
      return false;
    }
    case GrainKeyType::property:
      return is_property(k, v);
    case GrainKeyType::series:
      return is_number(v) ? in_range(k, v) : is_table(k, v, 1);
    case GrainKeyType::one_or_three: {
      if (is_number(v)) return in_range(k, v);
      if (v.type != Type::list || v.list.size() != 3) return false;
      for (const TomlNode& n : v.list)
        if (!in_range(k, n)) return false;
      return true;
    }
    case GrainKeyType::shares:
      if (v.type != Type::table || v.table.empty()) return false;
      for (const auto& [name, n] : v.table)
        if (!in_range(k, n)) return false;
      return true;
  }
  return false;
}

const GrainKey& GrainTable::key(std::string_view name) const {
  for (const GrainKey& k : grain_keys())
    if (k.section == section_ && k.name == name) return k;
  throw std::logic_error("no such grain key: " + section_ + "." + std::string(name));
}

std::string GrainTable::where(std::string_view name) const {
  const TomlNode* n = node_ != nullptr ? node_->find(name) : nullptr;
  return n != nullptr ? n->where : node_ != nullptr ? node_->where : file_;
}

void GrainTable::fail(std::string_view name, const std::string& why) const {
  const TomlNode* n = node_ != nullptr ? node_->find(name) : nullptr;
  fault(where(name), full(name), n != nullptr ? n->shown : std::string(key(name).fallback), why);
}

void GrainTable::missing(std::string_view name, const std::string& why) const {
  throw Error(ErrorCode::scene, fmt::format("{}: missing: {}; must be {}", full(name), why, allowed_text(key(name))),
              node_ != nullptr ? node_->where : file_);
}

void GrainTable::exclusive(std::string_view a, std::string_view b) const {
  if (has(a) && has(b)) fail(b, fmt::format("contradicts '{}'; give one of the two", a));
}

double GrainTable::number(std::string_view name) const {
  return has(name) ? node_->find(name)->number : std::strtod(std::string(key(name).fallback).c_str(), nullptr);
}
std::int64_t GrainTable::integer(std::string_view name) const {
  return has(name) ? node_->find(name)->integer : std::strtoll(std::string(key(name).fallback).c_str(), nullptr, 10);
}
bool GrainTable::boolean(std::string_view name) const {
  return has(name) ? node_->find(name)->boolean : key(name).fallback == "true";
}
std::string GrainTable::text(std::string_view name) const {
  if (has(name)) return node_->find(name)->text;
  const std::string_view f = key(name).fallback;
  return f.size() >= 2 && f.front() == '"' ? std::string(f.substr(1, f.size() - 2)) : "";
}

int GrainTable::choice_index(std::string_view name) const {
  const std::vector<std::string> words = words_of(key(name).choices);
  const std::string word = text(name);
  for (std::size_t i = 0; i < words.size(); ++i)
    if (words[i] == word) return static_cast<int>(i);
  throw std::logic_error("a choice without its words");
}

Property GrainTable::property(std::string_view name) const {
  if (!has(name)) return Property::constant(number(name));
  const GrainKey& k = key(name);
  const TomlNode& n = *node_->find(name);
  if (is_number(n)) return Property::constant(n.number);
  std::vector<double> a, b;
  if (const TomlNode* table = n.find("table")) {
    for (const TomlNode& p : table->list) {
      a.push_back(p.list[0].number);
      b.push_back(p.list[1].number);
    }
    return Property::table(a, b);
  }
  for (const TomlNode& c : n.find("polynomial")->list) a.push_back(c.number);
  const TomlNode *origin = n.find("origin"), *range = n.find("range");
  const double low = range != nullptr ? range->list[0].number : 250,
               high = range != nullptr ? range->list[1].number : 2000;
  const Property p = Property::polynomial(a, origin != nullptr ? origin->number : 0, low, high);
  const double smallest = p.least_on(low, high);
  // A conductivity may fall below its floor, which then holds.
  const bool floored = section_ == "conductivity" && has("least") && number("least") > 0;
  if (!(smallest > k.low) && !floored)
    fail(name, fmt::format("falls to {:.4g} between {:g} and {:g} K; give a range in which it stays above {:g}",
                           smallest, low, high, k.low));
  return p;
}

Series GrainTable::series(std::string_view name) const {
  if (!has(name)) return {{0}, {number(name)}};
  const TomlNode& n = *node_->find(name);
  if (is_number(n)) return {{0}, {n.number}};
  Series s;
  for (const TomlNode& p : n.list) {
    s.time.push_back(p.list[0].number);
    s.value.push_back(p.list[1].number);
  }
  return s;
}

std::optional<Series> GrainTable::series_if(std::string_view name) const {
  return has(name) ? std::optional<Series>(series(name)) : std::nullopt;
}

std::vector<double> GrainTable::numbers(std::string_view name) const {
  if (!has(name)) return {number(name)};
  const TomlNode& n = *node_->find(name);
  if (is_number(n)) return {n.number};
  std::vector<double> all;
  for (const TomlNode& e : n.list) all.push_back(e.number);
  return all;
}

std::vector<std::pair<std::string, double>> GrainTable::shares(std::string_view name) const {
  std::vector<std::pair<std::string, double>> all;
  if (has(name))
    for (const auto& [word, n] : node_->find(name)->table) all.emplace_back(word, n.number);
  return all;
}

}  // namespace talus::conversion
