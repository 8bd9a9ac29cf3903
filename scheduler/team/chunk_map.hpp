// Which chunk owns a row. Who calls it: everything that cuts rows into chunks. Invariants: chunks are consecutive and
// not empty; rows behind the last border, inserted since it was set, get chunks of the nominal size. Results do not
// depend on the borders (I8).
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

#include "core/base/types.hpp"

namespace talus {

class ChunkMap {
 public:
  /// Equal chunks of `size` rows.
  explicit ChunkMap(int size = 4096)
      : size_(size),
        shift_(30 + std::bit_width(static_cast<unsigned>(size) - 1U)),
        factor_(((std::uint64_t{1} << shift_) + static_cast<unsigned>(size) - 1U) / static_cast<unsigned>(size)) {}

  /// Chunks of equal cost, as many as equal ones would be: of n rows, those of group g of group_rows() cost cost[g].
  ChunkMap(int size, Row n, const std::vector<double>& cost) : ChunkMap(size) {
    const Row rows = group_rows(size);
    const int count = ChunkMap(size).count(n);
    if (count < 2 || cost.empty()) return;
    double total = 0, sum = 0;
    for (const double c : cost) total += c;
    lo_.push_back(0);
    group_chunk_.reserve(cost.size());
    for (std::size_t g = 0; g < cost.size(); ++g) {
      const int k = static_cast<int>(lo_.size());  // chunks begun
      const bool full = sum + 0.5 * cost[g] > total * k / count;
      const bool others_wait = static_cast<int>(cost.size() - g) <= count - k;
      if (g > 0 && k < count && (full || others_wait)) lo_.push_back(static_cast<Row>(g) * rows);
      group_chunk_.push_back(static_cast<std::int32_t>(lo_.size()) - 1);
      sum += cost[g];
    }
    mapped_ = static_cast<Row>(cost.size()) * rows;
    shift_rows_ = std::bit_width(static_cast<unsigned>(rows)) - 1;
  }

  /// Borders lie at multiples of this: a power of two, at most 64.
  static Row group_rows(int size) { return std::clamp<Row>(std::bit_floor(static_cast<unsigned>(size) / 16U), 1, 64); }

  /// The same borders over n rows, each moved down to `border(row)`, where one may lie; without those that then
  /// coincide.
  template <class F>
  ChunkMap moved(Row n, const F& border) const {
    ChunkMap m(static_cast<int>(size_));
    m.lo_.push_back(0);
    const int kept = exact_ ? static_cast<int>(lo_.size()) : count(n);
    for (int k = 1; k < kept; ++k)
      if (const Row at = border(lo(k)); at > m.lo_.back()) m.lo_.push_back(at);
    // rows that have come fill the last chunk first; none is cut
    for (auto k = std::max<std::int64_t>(m.lo_.back() + size_, mapped_); exact_ && k < n; k += size_)
      if (const Row at = border(static_cast<Row>(k)); at > m.lo_.back()) m.lo_.push_back(at), k = at;
    m.mapped_ = n;
    m.exact_ = true;
    const Row rows = group_rows(static_cast<int>(size_));
    m.shift_rows_ = std::bit_width(static_cast<unsigned>(rows)) - 1;
    std::int32_t k = 0;
    for (Row first = 0; first < n; first += rows) {
      while (k + 1 < static_cast<std::int32_t>(m.lo_.size()) && m.lo_[static_cast<std::size_t>(k) + 1] <= first) ++k;
      m.group_chunk_.push_back(k);
    }
    return m;
  }

  int operator()(Row i) const {
    if (i < mapped_) {
      std::int32_t k = group_chunk_[static_cast<std::size_t>(i >> shift_rows_)];
      if (exact_)  // borders within groups
        while (k + 1 < static_cast<std::int32_t>(lo_.size()) && lo_[static_cast<std::size_t>(k) + 1] <= i) ++k;
      return k;
    }
    // without a division: (row * factor) >> shift is exact for rows below 2^30
    return static_cast<int>(lo_.size()) +
           static_cast<int>((static_cast<std::uint64_t>(static_cast<std::uint32_t>(i - mapped_)) * factor_) >> shift_);
  }
  /// First row of a chunk.
  Row lo(int k) const {
    const auto mapped = static_cast<std::int64_t>(lo_.size());
    return k < mapped ? lo_[static_cast<std::size_t>(k)] : static_cast<Row>(mapped_ + (k - mapped) * size_);
  }
  Row hi(int k, Row n) const { return std::min(n, k + 1 == static_cast<int>(lo_.size()) ? mapped_ : lo(k + 1)); }
  /// Chunks of n rows, at least one.
  int count(Row n) const { return n > 0 ? (*this)(n - 1) + 1 : 1; }

 private:
  std::int64_t size_;
  int shift_;
  std::uint64_t factor_;
  std::vector<Row> lo_;                    ///< empty: equal chunks
  std::vector<std::int32_t> group_chunk_;  ///< chunk of a group of rows
  Row mapped_ = 0;                         ///< rows that these cover
  int shift_rows_ = 0;
  bool exact_ = false;  ///< borders may lie anywhere
};

}  // namespace talus
