// See shares.hpp.
#include "scheduler/team/shares.hpp"

#include <algorithm>
#include <numeric>

namespace talus {

namespace {

/// Shares stay as they are while the slowest thread would win less than this part.
constexpr double k_worth = 0.01;

/// Bounds of consecutive shares of which none costs more than `most`; the last one takes what is left.
std::vector<int> cut(const std::vector<double>& cost, int threads, double most) {
  std::vector<int> bounds{0};
  const int chunks = static_cast<int>(cost.size());
  double sum = 0;
  for (int c = 0; c < chunks; ++c) {
    const int open = static_cast<int>(bounds.size());  // shares begun
    // no thread may go without a chunk for the sake of those before it
    const bool others_wait = chunks - c <= threads - open;
    if (open < threads && c > bounds.back() && (sum + cost[static_cast<std::size_t>(c)] > most || others_wait)) {
      bounds.push_back(c);
      sum = 0;
    }
    sum += cost[static_cast<std::size_t>(c)];
  }
  bounds.resize(static_cast<std::size_t>(threads) + 1, chunks);
  return bounds;
}

double slowest(const std::vector<int>& bounds, const std::vector<double>& cost) {
  double most = 0;
  for (std::size_t t = 0; t + 1 < bounds.size(); ++t)
    most = std::max(most, std::accumulate(cost.begin() + bounds[t], cost.begin() + bounds[t + 1], 0.0));
  return most;
}

}  // namespace

void ChunkShares::divide(const std::vector<double>& cost, int threads) {
  // bisection for the least bound that can be kept
  double low = 0, high = std::accumulate(cost.begin(), cost.end(), 0.0);
  for (int k = 0; k < 20; ++k) {
    const double most = 0.5 * (low + high);
    (slowest(cut(cost, threads, most), cost) <= most ? high : low) = most;
  }
  std::vector<int> bounds = cut(cost, threads, high);
  const bool same_numbers = bounds.size() == bounds_.size() && bounds.back() == bounds_.back();
  if (same_numbers && slowest(bounds_, cost) * (1 - k_worth) <= slowest(bounds, cost)) return;
  if (bounds.size() != bounds_.size()) shares_ = std::make_unique<Share[]>(static_cast<std::size_t>(threads));
  bounds_ = std::move(bounds);
  unused_ = 0;
  for (std::size_t t = 0; t + 1 < bounds_.size(); ++t) unused_ += bounds_[t] == bounds_[t + 1] ? 1 : 0;
}

void ChunkShares::prepare(int chunks, int threads) {
  if (bounds_.size() == static_cast<std::size_t>(threads) + 1 && bounds_.back() == chunks) return;
  divide(std::vector<double>(static_cast<std::size_t>(chunks), 1.0), threads);
}

ChunkShares::Left ChunkShares::left_of(std::size_t share, std::uint64_t word) const noexcept {
  if (static_cast<std::uint16_t>(word >> 48) != round_)
    return {static_cast<std::uint32_t>(bounds_[share]), static_cast<std::uint32_t>(bounds_[share + 1])};
  return {static_cast<std::uint32_t>(word >> 24) & 0xffffffU, static_cast<std::uint32_t>(word) & 0xffffffU};
}

int ChunkShares::take_from(std::size_t share, bool own) noexcept {
  std::uint64_t seen = shares_[share].word.load(std::memory_order_relaxed);
  for (;;) {
    Left left = left_of(share, seen);
    if (left.first >= left.end) return -1;
    const bool from_front = own == ((round_ & 1U) == 0);
    const std::uint32_t chunk = from_front ? left.first++ : --left.end;
    const std::uint64_t then = std::uint64_t{round_} << 48 | std::uint64_t{left.first} << 24 | left.end;
    if (shares_[share].word.compare_exchange_weak(seen, then, std::memory_order_relaxed)) {
      if (left.first == left.end) used_up_.fetch_add(1, std::memory_order_relaxed);
      return static_cast<int>(chunk);
    }
  }
}

int ChunkShares::next(int slot) const noexcept {
  if (slot < 0 || static_cast<std::size_t>(slot) + 1 >= bounds_.size()) return -1;
  const auto share = static_cast<std::size_t>(slot);
  const Left left = left_of(share, shares_[share].word.load(std::memory_order_relaxed));
  if (left.first >= left.end) return -1;
  return static_cast<int>((round_ & 1U) == 0 ? left.first : left.end - 1);
}

int ChunkShares::take(int slot) noexcept {
  const std::size_t shares = bounds_.size() - 1;
  if (slot >= 0 && static_cast<std::size_t>(slot) < shares)
    if (const int c = take_from(static_cast<std::size_t>(slot), true); c >= 0) return c;
  while (used_up_.load(std::memory_order_relaxed) < static_cast<int>(shares)) {
    std::uint32_t most = 0;
    std::size_t victim = 0;
    for (std::size_t t = 0; t < shares; ++t) {
      const Left left = left_of(t, shares_[t].word.load(std::memory_order_relaxed));
      if (left.first < left.end && left.end - left.first > most) {
        most = left.end - left.first;
        victim = t;
      }
    }
    if (most == 0) return -1;
    if (const int c = take_from(victim, false); c >= 0) return c;
  }
  return -1;
}

}  // namespace talus
