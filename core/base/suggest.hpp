// What a user may have meant by a name that does not exist. Who calls it: readers of scenes, the command line.
// Invariant: a suggestion is one of the candidates, or nothing where none is near.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace talus {

/// Insertions, deletions, substitutions and swaps of neighbours between two names; case, '-' and '_' do not count.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The candidate with the smallest edit distance to `name`; else one that contains it, or that it contains, as a word;
/// "" if none is near (more than half of the letters wrong).
std::string nearest_name(std::string_view name, const std::vector<std::string>& candidates);
/// " (did you mean 'x'?)" or "".
std::string did_you_mean(std::string_view name, const std::vector<std::string>& candidates);

/// A word of everyday language or of other codes, and the choice that it means.
struct Meaning {
  std::string_view word, choice;
};
/// The same for one of a few choices, whose words say nothing by their letters: what the word means, else one that is
/// misspelt (up to a third of the letters wrong) or contains it as a word.
std::string choice_hint(std::string_view word, const std::vector<std::string>& choices,
                        const std::vector<Meaning>& meanings = {});

/// True if `word` stands in `name` between its ends, '_', '-' and '.'.
bool has_word(std::string_view name, std::string_view word);

}  // namespace talus
