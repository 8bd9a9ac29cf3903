// See suggest.hpp.
#include "core/base/suggest.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace talus {
namespace {

std::string plain(std::string_view name) {
  std::string s(name);
  for (char& c : s) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    if (c == '-') c = '_';
  }
  return s;
}

}  // namespace

constexpr std::size_t k_longest = 200;  // no name is; a hostile text must not cost its square

std::size_t edit_distance(std::string_view first, std::string_view second) {
  const std::string a = plain(first.substr(0, k_longest)), b = plain(second.substr(0, k_longest));
  std::vector<std::size_t> before(b.size() + 1), row(b.size() + 1), next(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    next[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      next[j] = std::min({row[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1), row[j] + 1, next[j - 1] + 1});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        next[j] = std::min(next[j], before[j - 2] + 1);
    }
    std::swap(before, row);
    std::swap(row, next);
  }
  return row[b.size()];
}

bool has_word(std::string_view name, std::string_view word) {
  if (word.empty()) return false;
  const auto ends = [&](std::size_t at) {
    return at >= name.size() || name[at] == '_' || name[at] == '-' || name[at] == '.';
  };
  for (std::size_t at = name.find(word); at != std::string_view::npos; at = name.find(word, at + 1))
    if ((at == 0 || ends(at - 1)) && ends(at + word.size())) return true;
  return false;
}

std::string nearest_name(std::string_view name, const std::vector<std::string>& candidates) {
  std::string best;
  std::size_t best_distance = std::min(name.size(), k_longest) / 2 + 1;  // exclusive bound
  for (const std::string& c : candidates) {
    const std::size_t distance = edit_distance(name, c);
    if (distance >= best_distance) continue;
    best_distance = distance;
    best = c;
  }
  // "--every" for "--checkpoint-every" is nearer in meaning than a name of the same length with other letters.
  std::string word = plain(name);
  word.erase(0, word.find_first_not_of('_'));  // the dashes of an option
  constexpr std::size_t k_short = 3;
  if (best_distance > 2 && word.size() >= k_short)
    for (const std::string& c : candidates) {
      const std::string other = plain(c);
      if (has_word(other, word) || (other.size() >= k_short && has_word(word, other))) return c;
    }
  return best;
}

std::string choice_hint(std::string_view word, const std::vector<std::string>& choices,
                        const std::vector<Meaning>& meanings) {
  const auto hint = [](std::string_view choice) { return fmt::format(" (did you mean '{}'?)", choice); };
  const std::string typed = plain(word.substr(0, k_longest));
  const std::size_t allowed = std::max<std::size_t>(typed.size() / 3, 1);
  std::string_view best;
  std::size_t least = allowed + 1;
  const auto offer = [&](std::string_view spelt, std::string_view choice) {
    const std::size_t distance = edit_distance(typed, spelt);
    // a wrong letter in one or two is another word
    if (distance >= least || (distance > 0 && spelt.size() < 3)) return;
    least = distance;
    best = choice;
  };
  for (const std::string& c : choices) offer(c, c);
  for (const Meaning& m : meanings) offer(m.word, m.choice);
  if (!best.empty()) return hint(best);
  for (const std::string& c : choices)
    if (typed.size() > 2 && (has_word(c, typed) || has_word(typed, c))) return hint(c);
  for (const Meaning& m : meanings)
    if (has_word(typed, m.word)) return hint(m.choice);
  return "";
}

std::string did_you_mean(std::string_view name, const std::vector<std::string>& candidates) {
  const std::string best = nearest_name(name, candidates);
  return best.empty() ? "" : fmt::format(" (did you mean '{}'?)", best);
}

}  // namespace talus
