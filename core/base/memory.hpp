// How much memory the process may still take. Who calls it: whoever is about to allocate what an input asks for.
// Invariant: memory is judged before it is taken, by the machine, the control groups and the process's own limits.
#pragma once

#include <string>
#include <string_view>

#include "core/base/error.hpp"

namespace talus {

struct AvailableMemory {
  double bytes = 0;     ///< that can still be taken [B]
  std::string_view by;  ///< what sets the limit, for messages
};

/// The least of: free and reclaimable memory of the machine, what the control groups (versions 1 and 2, all levels)
/// leave, and the limit of the address space. `root` stands before /proc and /sys (tests). Where nothing can be read,
/// an infinite amount.
AvailableMemory available_memory(const std::string& root = {});

/// Error{code} in one line with both numbers where `bytes` exceed what is available: "`what` needs 3.1 TiB of memory,
/// 12.4 GiB are available (...)".
void require_memory(double bytes, std::string_view what, std::string_view where, std::string_view cure,
                    ErrorCode code = ErrorCode::scene);

/// "12.4 GiB".
std::string bytes_text(double bytes);

}  // namespace talus
