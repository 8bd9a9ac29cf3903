// What the lists of the last rebuild rest on beside x0, and the course of the lists over a run.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/types.hpp"
#include "scheduler/reports.hpp"

namespace talus {

struct ListFrame {
  std::int64_t built = 0;           ///< step of the rebuild
  Row rows = 0;                     ///< rows it has seen
  double life = 1e300;              ///< the lists hold no longer than this [s]
  double stretch = 1;               ///< factor of reaches, see Policy::stretch
  double rounding = 0;              ///< what to add to them for drifts in single precision [m]
  double common_speed = 0;          ///< largest speed [m/s]
  double mean_skin = 0;             ///< of its diameter, over particles
  double travelled = 0;             ///< sum of the largest travels of the steps [m]
  alignas(16) float drift[4] = {};  ///< of all rows, where none has its own [m/s]
  bool noted = false;               ///< Lists::next_skin is that of the rebuild to come
};

/// The last rebuilds, thinned: when full, every second entry goes and from then on only half as many are taken.
class ListSeries {
 public:
  void add(const ListRecord& r) {
    if (seen_++ % stride_ != 0) return;
    if (records.size() == k_room) {
      for (std::size_t k = 0; k < k_room / 2; ++k) records[k] = records[2 * k];
      records.resize(k_room / 2);
      stride_ *= 2;
    }
    records.push_back(r);
  }
  std::vector<ListRecord> records;

 private:
  static constexpr std::size_t k_room = 512;
  std::int64_t seen_ = 0, stride_ = 1;
};

}  // namespace talus
