// Is a text one whole JSON value? Who calls it: readers of summary.json. Invariant: accepts exactly RFC 8259, up to a
// depth that no file of Talus comes near.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace talus {

/// Position of the first byte at which `text` is not JSON (its length where it ends too early), or nothing.
std::optional<std::size_t> json_error(std::string_view text);

}  // namespace talus
