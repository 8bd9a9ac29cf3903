// Text to the terminal. Called by all cli_*.cpp. Invariants: what cannot be written to standard output is an error,
// since the caller asked for it, unless its reader has gone (a pipe to head); what cannot be written to standard error
// is lost without harm, since a run must not end over a message.
#pragma once

#include <fmt/format.h>

#include <exception>
#include <string>
#include <string_view>
#include <utility>

#include "core/base/text.hpp"

namespace talus::cli {

/// Nobody reads standard output any more: the program ends without a word, as others do.
struct ReaderGone : std::exception {};

/// Writes to standard output. Error{io} with the system's reason; ReaderGone.
void put_text(std::string_view text);
/// Writes to standard error, or nothing.
void tell_text(std::string_view text) noexcept;
/// Writes out what is buffered. Error{io}, ReaderGone.
void flush_output();

template <class... T>
void put(fmt::format_string<T...> form, T&&... values) {
  put_text(fmt::format(form, std::forward<T>(values)...));
}
template <class... T>
void tell(fmt::format_string<T...> form, T&&... values) {
  tell_text(fmt::format(form, std::forward<T>(values)...));
}

/// A path in a message: whole, in one line, whatever its name holds.
inline std::string shown_path(std::string_view path) { return shown(path, 1 << 16); }

/// Opens descriptors 0 to 2 where they are closed, on /dev/null: otherwise the next files that the program opens would
/// get these numbers, and messages would be written into them.
void secure_descriptors() noexcept;

}  // namespace talus::cli
