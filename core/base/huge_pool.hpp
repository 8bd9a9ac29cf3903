// Memory in pages of 2 MiB: whole mappings for large arrays (rows), and pieces cut from mappings for the many
// medium-sized arrays of the chunks (lists, history). With small pages the lists of 10^5 grains take more translations
// than the processor holds, which costs 5 to 10 % of a step. Mappings are our own: what malloc hands out may have been
// touched before, and then its pages stay small whatever madvise says.
// Called by AlignedAllocator; thread safe. Freed pieces are kept for the next array of the same size class, freed
// mappings, up to 64 MiB in all, for the next one of the same size (its pages stay on the node that touched them
// first).
#pragma once

#include <cstddef>

namespace talus {

inline constexpr std::size_t k_pool_smallest = std::size_t{16} << 10, k_pool_largest = std::size_t{4} << 20;

/// Memory for `bytes` above k_pool_largest, aligned to 64 bytes; nullptr where the system has no more.
void* map_allocate(std::size_t bytes) noexcept;
/// Gives back what map_allocate(bytes) returned.
void map_free(void* p, std::size_t bytes) noexcept;

/// Memory for `bytes` in [k_pool_smallest, k_pool_largest], aligned to 64 bytes; nullptr where the system has no more.
void* pool_allocate(std::size_t bytes) noexcept;
/// Gives back what pool_allocate(bytes) returned.
void pool_free(void* p, std::size_t bytes) noexcept;

}  // namespace talus
