// Lets the lanes of the step graph wait between two steps instead of being queued anew. Who calls it: the lanes
// (await), the node that starts a step (open), the node that decides on a rebuild and every loop outside of the lanes
// (dismiss). Purpose: queued lanes are found by threads that look for work at random, one after another, which took 5
// to 7 % of a step of 125k grains on 28 cores (perf/schedule.py); a lane that waits sees the step begin after one cache
// line has come. Invariants: a lane waits only after it has reported to the join; only the one thread that runs serial
// nodes opens and dismisses; a lane gives its thread back by itself after k_patience by the clock. It never yields: on
// a core that others use, too, one yield takes a whole time slice, and the step that begins meanwhile waits for the
// lane.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <utility>

namespace talus {

class StepGate {
 public:
  /// For lanes 0..lanes-1 (below 65535), none of them waiting or running. patient: false where threads share cores:
  /// then every lane gives its thread back at once.
  void prepare(int lanes, bool patient = true) {
    links_ = std::make_unique<std::atomic<std::uint64_t>[]>(static_cast<std::size_t>(lanes));
    patient_ = patient;
    dismissed_ = true;
  }
  /// Number of the present round: to be read before the lane reports that it has no chunk left.
  std::uint32_t round() const noexcept { return round_of(word_.load(std::memory_order_relaxed)); }
  /// Waits for the round after `round`. True: the lane goes on in it. False: it has to end; it is started again by
  /// whoever opens the gate, if at all.
  bool await(std::uint32_t round, int lane) noexcept {
    Clock::time_point begin;
    bool waits = patient_;
    for (unsigned tries = 0;; ++tries) {
      const std::uint64_t seen = word_.load(std::memory_order_acquire);
      if (round_of(seen) != round)
        // a lane that was dismissed and looks late may find the number of a round that goes on without it
        return round_of(seen) == round + 1 && (seen & k_dismissed) == 0;
      if (waits) {
        pause();
        if (tries == k_tries_per_look) begin = Clock::now();
        if (tries > k_tries_per_look && tries % k_tries_per_look == 0) waits = Clock::now() - begin < k_patience;
      } else if (const Look look = look_at(lane); round_of(look.word) == round && leave(look, lane)) {
        return false;
      }
    }
  }
  /// await() gives up in two parts: what a lane sees,
  struct Look {
    std::uint64_t link, word;
  };
  Look look_at(int lane) const noexcept {
    // the link first: where the round is still the lane's own afterwards, nobody else has begun this lane before
    const std::uint64_t link = links_[static_cast<std::size_t>(lane)].load(std::memory_order_acquire);
    return {link, word_.load(std::memory_order_acquire)};
  }
  /// and its leaving, if that still holds. A thread may be stopped in between for long: then its lane was sent away and
  /// handed out again, and may have left a later round. That link must stay, or the lanes behind it are lost.
  bool leave(Look look, int lane) noexcept {
    const std::uint64_t link = (look.word >> 32 << 32) | (look.word & k_none);
    if (!links_[static_cast<std::size_t>(lane)].compare_exchange_strong(look.link, link, std::memory_order_acq_rel))
      return false;
    const std::uint64_t then = (look.word & ~std::uint64_t{k_none}) | static_cast<std::uint64_t>(lane);
    return word_.compare_exchange_strong(look.word, then, std::memory_order_acq_rel);
  }
  /// All lanes have to be started by the caller; else open() is enough.
  bool dismissed() const noexcept { return dismissed_; }
  /// Begins a round: lanes that wait go on; again(lane) is called for those that have given up waiting.
  template <class F>
  void open(F again) {
    const std::uint64_t before = advance(0);
    for (auto lane = static_cast<std::uint16_t>(before & k_none); lane != k_none;)
      again(std::exchange(lane, static_cast<std::uint16_t>(links_[lane].load(std::memory_order_relaxed) & k_none)));
  }
  /// Sends all waiting lanes away: their threads are wanted elsewhere, or nothing is left to do.
  void dismiss() noexcept {
    if (dismissed_) return;
    dismissed_ = true;
    advance(k_dismissed);
  }
  /// All lanes have been started.
  void started() noexcept { dismissed_ = false; }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::microseconds k_patience{60};
  static constexpr unsigned k_tries_per_look = 64;  ///< looks at the clock are dearer than pauses
  static constexpr std::uint16_t k_none = 0xffff;
  static constexpr std::uint64_t k_dismissed = 1U << 16;

  static std::uint32_t round_of(std::uint64_t word) noexcept { return static_cast<std::uint32_t>(word >> 32); }
  static void pause() noexcept {
#if defined(__x86_64__)
    __builtin_ia32_pause();
#endif
  }
  std::uint64_t advance(std::uint64_t flags) noexcept {
    const std::uint64_t next = std::uint64_t{round() + 1} << 32 | flags | k_none;
    return word_.exchange(next, std::memory_order_acq_rel);
  }

  /// Round, whether it was begun by dismissing, and the last lane that gave up waiting; its link: the round, and the
  /// lane that gave up before it.
  alignas(128) std::atomic<std::uint64_t> word_{k_none};
  alignas(128) std::unique_ptr<std::atomic<std::uint64_t>[]> links_;
  bool patient_ = false;
  bool dismissed_ = true;
};

}  // namespace talus
