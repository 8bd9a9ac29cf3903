// One section of a grain file, checked against the key table when it is made. Who calls it: grain_file.cpp only.
// Invariant: a getter never sees an unknown key, a wrong type or a value out of range.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/conversion/grain_file.hpp"
#include "core/conversion/grain_keys.hpp"
#include "core/scene/toml_tree.hpp"

namespace talus::conversion {

class GrainTable {
 public:
  /// node == nullptr: the section is not in the file. Error{scene}.
  GrainTable(const TomlNode* node, std::string section, std::string path, std::string file);

  bool has(std::string_view name) const { return node_ != nullptr && node_->find(name) != nullptr; }
  bool given() const { return node_ != nullptr; }
  double number(std::string_view name) const;
  std::int64_t integer(std::string_view name) const;
  bool boolean(std::string_view name) const;
  std::string text(std::string_view name) const;
  /// The choice as an enum in the order of the key table.
  template <class E>
  E choice(std::string_view name) const {
    return static_cast<E>(choice_index(name));
  }
  Property property(std::string_view name) const;
  Property property_or(std::string_view name, const Property& other) const {
    return has(name) ? property(name) : other;
  }
  Series series(std::string_view name) const;
  std::optional<Series> series_if(std::string_view name) const;
  std::vector<double> numbers(std::string_view name) const;
  std::vector<std::pair<std::string, double>> shares(std::string_view name) const;

  [[noreturn]] void fail(std::string_view name, const std::string& why) const;
  [[noreturn]] void missing(std::string_view name, const std::string& why) const;
  void exclusive(std::string_view a, std::string_view b) const;
  std::string where(std::string_view name) const;

 private:
  const GrainKey& key(std::string_view name) const;
  int choice_index(std::string_view name) const;
  std::string full(std::string_view name) const {
    return path_.empty() ? std::string(name) : path_ + "." + std::string(name);
  }
  void check(const std::string& name, const TomlNode& value) const;
  bool fits(const GrainKey& k, const TomlNode& v) const;

  const TomlNode* node_;
  std::string section_, path_, file_;
};

}  // namespace talus::conversion
