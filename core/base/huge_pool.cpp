// The pool of pieces cut from huge pages; see huge_pool.hpp.

#include "core/base/huge_pool.hpp"

#include <sys/mman.h>

#include <bit>
#include <cstdint>
#include <mutex>
#include <vector>

namespace talus {

namespace {

constexpr std::size_t k_huge = std::size_t{2} << 20, k_block = std::size_t{16} << 20;
constexpr std::size_t k_kept = std::size_t{64} << 20;  ///< of freed mappings
// Arrays that are walked together start at different lines, or they would meet in the same cache sets.
constexpr std::size_t k_shift = 5 * 64, k_shifts = 12;

std::size_t mapped(std::size_t bytes) noexcept { return (bytes + k_shift * k_shifts + k_huge - 1) / k_huge * k_huge; }

/// `size` bytes (a multiple of k_huge) at a multiple of k_huge, zero, or nullptr.
char* map(std::size_t size) noexcept {
  void* const all = mmap(nullptr, size + k_huge, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (all == MAP_FAILED) return nullptr;
  char* const begin = static_cast<char*>(all);
  const std::size_t before = (k_huge - reinterpret_cast<std::uintptr_t>(begin) % k_huge) % k_huge;
  if (before > 0) munmap(begin, before);
  if (before < k_huge) munmap(begin + before + size, k_huge - before);
  madvise(begin + before, size, MADV_HUGEPAGE);
  return begin + before;
}

/// Four size classes per power of two: rounding wastes at most a quarter.
struct SizeClass {
  std::size_t index, bytes;
};

SizeClass size_class(std::size_t bytes) noexcept {
  const auto power = static_cast<std::size_t>(std::bit_width(bytes - 1)) - 1;  // 2^power < bytes <= 2^(power + 1)
  const std::size_t quarter = (std::size_t{1} << power) / 4;
  const std::size_t steps = (bytes - (std::size_t{1} << power) + quarter - 1) / quarter;  // 1 .. 4
  // five lines more than a multiple of the page: arrays that are walked together do not meet in the same cache sets
  return {4 * power + steps, (std::size_t{1} << power) + steps * quarter + 320};
}

struct Mapping {
  char* begin;
  std::size_t size;
};

struct Pool {
  std::mutex mutex;
  std::vector<Mapping> kept;
  std::size_t kept_bytes = 0, maps = 0;
  std::vector<void*> free[4 * 24];
  char *next = nullptr, *end = nullptr;
};

/// Never destroyed: columns with static storage may be freed after any destructor of ours would have run.
Pool& pool() noexcept {
  static Pool* const p = new Pool;
  return *p;
}

}  // namespace

void* map_allocate(std::size_t bytes) noexcept {
  const std::size_t size = mapped(bytes);
  Pool& p = pool();
  const std::lock_guard<std::mutex> lock(p.mutex);
  char* begin = nullptr;
  for (Mapping& m : p.kept)
    if (m.size == size) {
      begin = m.begin;
      p.kept_bytes -= size;
      m = p.kept.back();
      p.kept.pop_back();
      break;
    }
  if (begin == nullptr) begin = map(size);
  return begin == nullptr ? nullptr : begin + k_shift * (p.maps++ % k_shifts);
}

void map_free(void* array, std::size_t bytes) noexcept {
  const std::size_t size = mapped(bytes);
  char* const begin = static_cast<char*>(array) - reinterpret_cast<std::uintptr_t>(array) % k_huge;
  Pool& p = pool();
  const std::lock_guard<std::mutex> lock(p.mutex);
  if (p.kept_bytes + size <= k_kept) {
    try {
      p.kept.push_back({begin, size});
      p.kept_bytes += size;
      return;
    } catch (...) {  // no memory to remember it
    }
  }
  munmap(begin, size);
}

void* pool_allocate(std::size_t bytes) noexcept {
  const SizeClass c = size_class(bytes);
  Pool& p = pool();
  const std::lock_guard<std::mutex> lock(p.mutex);
  auto& list = p.free[c.index];
  if (!list.empty()) {
    void* const piece = list.back();
    list.pop_back();
    return piece;
  }
  if (static_cast<std::size_t>(p.end - p.next) < c.bytes) {  // what is left of the last block is lost: under 4 MiB
    char* const block = map(k_block);
    if (block == nullptr) return nullptr;
    p.next = block;
    p.end = block + k_block;
  }
  void* const piece = p.next;
  p.next += c.bytes;
  return piece;
}

void pool_free(void* piece, std::size_t bytes) noexcept {
  const SizeClass c = size_class(bytes);
  Pool& p = pool();
  const std::lock_guard<std::mutex> lock(p.mutex);
  try {
    p.free[c.index].push_back(piece);
  } catch (...) {  // no memory to remember it: the piece is lost, nothing is wrong
  }
}

}  // namespace talus
