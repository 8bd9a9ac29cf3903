// Buffers that threads take and give back. Who calls it: the step graph (Scratch: from narrow phase to integration of a
// chunk) and list builds (ListScratch). Invariant: what a buffer holds beyond `clean` means nothing to the next taker.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "core/base/types.hpp"
#include "kernels/views.hpp"

namespace talus {

/// Makes room for n elements and some more; keeps the content. New elements are zero: kernels read whole vectors, also
/// behind the last one that counts.
template <class T>
void grow(Column<T>& c, std::size_t n) {
  if (c.size() < n) c.resize(n + n / 8 + 64, T{});
}

/// Makes room for n elements and some more; the content is lost where it has to grow.
template <class T>
void grow_discarding(Column<T>& c, std::size_t n) {
  if (c.size() < n) {
    c.clear();  // nothing to copy
    c.resize(n + n / 8 + 64);
  }
}

struct ShapedLanes;  // scheduler/nodes/shaped_contacts.cpp
struct BodyBatch;    // scheduler/nodes/body_batch.hpp

/// Per-execution buffers of one chunk between narrow phase and integration; pooled so that they stay in cache.
struct Scratch {
  Column<std::int32_t> ci, cj;
  Column<double> f;  ///< force rows of the chunk; all zero while `clean`
  bool clean = false;
  Column<HistoryRun> runs;          ///< where the contacts' history of the last step is; the chunk's run_count of them
  Column<double> h[k_max_columns];  ///< history of the present step, swapped with the chunk's where contacts have moved
  std::vector<std::unique_ptr<LateContacts>> late;  ///< contacts that begin or end in the step; linear law only
  std::vector<std::int32_t> wall_near;              ///< elements that a row can touch
  Column<double> m;                                 ///< moment rows {M, 0} of the chunk: rolling and twisting only
  Column<std::uint8_t> before;                      ///< touch bits of the last step: where add_ons.cpp carries history
  Column<double> depth;                ///< overlap over the inner radius; -1: of spheres. Superquadrics only
  std::shared_ptr<ShapedLanes> lanes;  ///< superquadrics only
  std::shared_ptr<BodyBatch> bodies;   ///< scenes with bodies only
};

/// Pool of scratch buffers. Every thread gets back the one it gave, which lies in its caches; the rest is last in first
/// out.
class ScratchPool {
 public:
  void prepare(int threads) { home_ = std::vector<Home>(static_cast<std::size_t>(threads)); }
  Scratch* take(int slot);  ///< slot: of the calling thread, or -1
  void give(Scratch* s, int slot = -1);
  std::size_t bytes() const;

 private:
  struct alignas(128) Home {
    Scratch* scratch = nullptr;
  };
  std::vector<Home> home_;  ///< by slot; only its thread looks
  std::mutex mutex_;
  std::vector<std::unique_ptr<Scratch>> all_;
  std::vector<Scratch*> free_;
};

/// Buffers of one running list build; pooled, so that there are as many as threads.
struct ListScratch {
  Column<float> x, y, z, r;  ///< candidates of a group of rows
  Column<std::int32_t> tag, hits;
  Column<std::int32_t> build[6];   ///< sections before they are laid end to end: own row, partner row
  Column<std::uint64_t> keys;      ///< touching pairs of the old list
  std::vector<std::int64_t> lost;  ///< contacts that the new list lacks
  Column<std::uint8_t> mask;       ///< of outer slots; outer_inner only
};

class ListScratchPool {
 public:
  ListScratch* take();
  void give(ListScratch* s);
  std::size_t bytes() const;

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<ListScratch>> all_;
  std::vector<ListScratch*> free_;
};

}  // namespace talus
