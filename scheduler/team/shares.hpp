// Which thread works on which chunk. Who calls it: the first node of every lane of the step graph and the loops over
// chunks of a rebuild take their chunk here. Purpose: a thread meets the chunks of its last step again, whose rows and
// lists lie in its caches (the graph's own scheduler hands tasks to whoever asks first: a quarter of the chunks changed
// the thread in every step). Invariants: in a round every chunk is taken exactly once; who takes it and in which order
// changes no result (I8).
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

namespace talus {

class ChunkShares {
 public:
  /// Gives every thread consecutive chunks so that the most expensive share is as cheap as can be; keeps the present
  /// shares where they are nearly as good. Consecutive, because rows next to a share's border are written by one thread
  /// and read by the other: with shares that were only equal, integration took 30 % longer on two threads. Serial.
  void divide(const std::vector<double>& cost, int threads);
  /// Equal numbers of chunks, if the present shares are not for these numbers.
  void prepare(int chunks, int threads);
  /// A new round: all chunks are free again. Every second round goes backwards through the shares, since what was used
  /// last is still in cache: 5 % at 128k grains. Serial.
  void begin_round() noexcept {
    ++round_;
    used_up_.store(unused_, std::memory_order_relaxed);
  }
  /// A chunk for the calling thread of this slot (-1: none): the next of its own share, else the last one of the share
  /// with most left; -1 where every chunk of the round is taken.
  int take(int slot) noexcept;
  /// The chunk that take() will most likely give this slot next, or -1.
  int next(int slot) const noexcept;
  /// First chunk of every thread's share, and the number of chunks.
  const std::vector<int>& bounds() const noexcept { return bounds_; }

 private:
  /// What is left of a share, in one word: round (16 bits), first and end (24 bits each). A word of another round means
  /// "all": nobody has to visit every share at the start of a round.
  struct alignas(128) Share {
    std::atomic<std::uint64_t> word{0};
  };
  struct Left {
    std::uint32_t first, end;
  };
  Left left_of(std::size_t share, std::uint64_t word) const noexcept;
  int take_from(std::size_t share, bool own) noexcept;

  std::vector<int> bounds_;
  std::unique_ptr<Share[]> shares_;
  std::uint16_t round_ = 1;
  int unused_ = 0;               ///< shares without chunks
  std::atomic<int> used_up_{0};  ///< shares with none left: who finds all of them so need not visit each
};

}  // namespace talus
