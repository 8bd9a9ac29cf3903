// Enums whose enumerators are the words that users write: name and word are one token, so they cannot disagree. Who
// uses it: core/scene (choices of keys), whatever prints such a value.
#pragma once

#include <cstdint>
#include <string_view>

/// enum class `name` and its words, which enum_words(name{}) returns as "a, b, c" in the order of the enumerators.
#define TALUS_WORDS(name, ...)                    \
  enum class name : std::uint8_t { __VA_ARGS__ }; \
  [[maybe_unused]] constexpr std::string_view enum_words(name) noexcept { return #__VA_ARGS__; }

/// The same for an enum within a class.
#define TALUS_MEMBER_WORDS(name, ...)             \
  enum class name : std::uint8_t { __VA_ARGS__ }; \
  friend constexpr std::string_view enum_words(name) noexcept { return #__VA_ARGS__; }

namespace talus {

/// The word of a value; "" for one that is no enumerator.
template <class E>
constexpr std::string_view enum_word(E value) noexcept {
  std::string_view words = enum_words(value);
  for (int k = static_cast<int>(value); k > 0; --k) {
    const std::size_t comma = words.find(", ");
    if (comma == std::string_view::npos) return {};
    words.remove_prefix(comma + 2);
  }
  return words.substr(0, words.find(", "));
}

/// The value of a word that is one.
template <class E>
constexpr E enum_value(std::string_view word) noexcept {
  int k = 0;
  while (enum_word(static_cast<E>(k)) != word) ++k;
  return static_cast<E>(k);
}

}  // namespace talus
