// See scene_search.hpp.
#include "core/scene/scene_search.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/scene/scene_keys.hpp"

namespace talus {
namespace {

bool in_word(char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9'); }

std::string lower_case(std::string_view text) {
  std::string s(text);
  for (char& c : s)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return s;
}

/// `word` between two ends of words, a plural too.
bool speaks_of(std::string_view text, const std::string& word) {
  const std::string lower = lower_case(text);
  for (std::size_t at = lower.find(word); at != std::string::npos; at = lower.find(word, at + 1)) {
    std::size_t end = at + word.size();
    if (end < lower.size() && lower[end] == 's') ++end;
    if ((at == 0 || !in_word(lower[at - 1])) && (end >= lower.size() || !in_word(lower[end]))) return true;
  }
  return false;
}

bool speaks_of(const SceneKey& key, const std::string& word) {
  for (std::string_view text : {key.name, key.doc, key.choices, key.only})
    if (speaks_of(text, word)) return true;
  const auto says = [&](const auto& other) { return speaks_of(other.word, word); };
  return std::any_of(key.also.begin(), key.also.end(), says) ||
         std::any_of(key.meanings.begin(), key.meanings.end(), says);
}

/// Up to the first end of a sentence or clause, so that a line stays one line.
std::string_view first_clause(std::string_view doc) { return doc.substr(0, doc.find_first_of(";:")); }

std::string line(std::string_view name, std::string_view doc) {
  return fmt::format("  {:<32} {}\n", name, first_clause(doc));
}

std::string of_sections(std::string_view last) {
  std::string text;
  for (const SceneSection& s : scene_sections()) {
    if (!s.name.ends_with("." + std::string(last))) continue;
    text += fmt::format("{}{}: {}\n", text.empty() ? "" : "\n", header_text(s), s.doc);
    for (const SceneKey& k : scene_keys())
      if (k.section == s.name) text += line(full_name(k), k.doc);
  }
  return text;
}

}  // namespace

std::string search_help(std::string_view asked) {
  constexpr std::size_t k_shortest = 3;
  std::string word = lower_case(asked);
  if (word.size() > k_shortest && word.back() == 's') word.pop_back();
  if (word.size() < k_shortest || !std::all_of(word.begin(), word.end(), in_word)) return "";
  std::string text = of_sections(word);
  if (text.empty()) {
    for (const SceneSection& s : scene_sections())
      if (speaks_of(s.doc, word)) text += line(header_text(s), s.doc);
    for (const SceneKey& k : scene_keys())
      if (speaks_of(k, word)) text += line(full_name(k), k.doc);
    if (!text.empty()) text = fmt::format("no key is called '{}'; these are about it:\n", asked) + text;
  }
  return text.empty() ? text : text + "\n'talus help KEY' tells all of one of them\n";
}

}  // namespace talus
