// Texts of users in messages and files. Who calls it: Error (every message goes through it), readers, JSON output.
// Invariant: what shown() returns is one line of valid UTF-8 without control characters.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace talus {

/// Length of the valid UTF-8 sequence that starts at text[at] (RFC 3629: no overlong forms, no surrogates), or 0.
std::size_t utf8_length(std::string_view text, std::size_t at) noexcept;

/// Position of the first byte that is no valid UTF-8, or npos.
std::size_t first_invalid_utf8(std::string_view text) noexcept;

/// Length of the control character at text[at] (C0, DEL, C1, line and paragraph separators, bidirectional controls), or
/// 0 where there is none.
std::size_t control_length(std::string_view text, std::size_t at) noexcept;

/// The text as one line for people: control characters and bytes that are no UTF-8 are escaped (\n, \x1b), and of a
/// text longer than `most` bytes only its beginning and its end are kept, "..." between them.
std::string shown(std::string_view text, std::size_t most = 80);

/// The text as one line from which unescaped_line() restores every byte: \\, \n and \xNN stand for backslashes,
/// control characters and bytes that are no UTF-8.
std::string escaped_line(std::string_view text);
std::string unescaped_line(std::string_view line);

}  // namespace talus
