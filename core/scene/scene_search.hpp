// Keys by a word of their text: "clump" is no key, but a few keys are about clumps. Who calls it: scene_help.
// Invariant: finds whole words only, so that a misspelt key finds nothing and is answered with what was meant.
#pragma once

#include <string>
#include <string_view>

namespace talus {

/// Help on the sections whose last name is `word` ("region": source.region, event.region, ...), one line per key; else
/// one line for each key or section whose text, choices or words of other codes hold `word`; "" where none does.
std::string search_help(std::string_view word);

}  // namespace talus
