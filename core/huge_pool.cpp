// The pool of pieces cut from huge pages; see huge_pool.hpp.

#include "core/huge_pool.hpp"

#include <sys/mman.h>

#include <bit>
#include <cstdlib>
#include <mutex>
#include <vector>

namespace talus {

namespace {

constexpr std::size_t k_huge = std::size_t{2} << 20, k_block = std::size_t{16} << 20;

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

struct Pool {
  std::mutex mutex;
  std::vector<void*> free[4 * 24];
  char *next = nullptr, *end = nullptr;
};

/// Never destroyed: columns with static storage may be freed after any destructor of ours would have run.
Pool& pool() noexcept {
  static Pool* const p = new Pool;
  return *p;
}

}  // namespace

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
    auto* const block = static_cast<char*>(std::aligned_alloc(k_huge, k_block));
    if (block == nullptr) return nullptr;
    madvise(block, k_block, MADV_HUGEPAGE);
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
