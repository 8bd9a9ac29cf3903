// What a scene text must be before the TOML parser may see it. Who calls it: core/scene/scene_table.cpp. Invariant: the
// parser, which aborts on some inputs, gets at most 1 MiB of printable ASCII and, within quotes, of valid UTF-8.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace talus {

constexpr std::size_t k_scene_bytes = std::size_t{1} << 20;  ///< a scene or a replacement may have

/// The text without byte order mark and with blanked comments (they may hold anything). Error{scene} with
/// name:line:col for a text that is too long or UTF-16, and for any byte outside comments that is not allowed there.
std::string guarded_scene_text(std::string_view text, const std::string& name);

/// Texts of a scene (titles, names, files) are one line of valid UTF-8 without control characters, at most 4096 bytes.
bool is_scene_text(std::string_view text) noexcept;

}  // namespace talus
