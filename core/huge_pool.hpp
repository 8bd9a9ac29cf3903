// Memory for the many medium-sized arrays of the chunks (lists, history): cut from blocks of 2 MiB pages. With small
// pages the lists of 10^5 grains take more translations than the processor holds, which costs 5 to 10 % of a step.
// Called by AlignedAllocator; thread safe. Freed pieces are kept for the next array of the same size class.
#pragma once

#include <cstddef>

namespace talus {

inline constexpr std::size_t k_pool_smallest = std::size_t{16} << 10, k_pool_largest = std::size_t{4} << 20;

/// Memory for `bytes` in [k_pool_smallest, k_pool_largest], aligned to 64 bytes; nullptr where the system has no more.
void* pool_allocate(std::size_t bytes) noexcept;
/// Gives back what pool_allocate(bytes) returned.
void pool_free(void* p, std::size_t bytes) noexcept;

}  // namespace talus
