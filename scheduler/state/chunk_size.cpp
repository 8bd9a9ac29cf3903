// How many rows a chunk has, and what its step costs. Results do not depend on either (I8).
#include <algorithm>

#include "scheduler/state/contacts.hpp"

namespace talus {

namespace {

/// Cost of a chunk's step [ns]; only the ratios count (perf/limits.md: list slots of the narrow phase, contacts, rows,
/// wall contacts).
constexpr double k_slot_cost = 2.2, k_contact_cost = 11.5, k_row_cost = 4.5, k_wall_cost = 110;

}  // namespace

int choose_chunk(const Rules& rules, const Rows& rows) {
  if (rules.options.chunk > 0) return rules.options.chunk;
  // Results do not depend on it (I8). One thread: 16384 rows where all rows stay near, else 8192. Pairs across borders
  // are computed twice, 11.1 % of the contacts of settle32 and 11.7 % of settle128 with 4096 rows, 6.6 and 9.2 with
  // 8192, 2.7 and 6.9 with 16384. That the rows of a larger chunk leave L2 between narrow phase and integration costs
  // less (AMD Zen 5, 1 MiB of L2; ns per grain and step with 4096, 8192, 16384: settle32 22.2, 21.7, 21.2; settle128
  // 27.9, 27.4, 27.9; settle512 28.4, 27.9, 28.2; flow128 17.8, 17.3, 17.5; radii5 25.7, 26.1, 26.1).
  // More threads: every thread gets the same whole number of equal chunks, of at most 3072 rows (4096 on two threads),
  // but none below 1024: there pairs across borders cost more than idle threads (perf/schedule.py: 125k particles on 28
  // threads, predicted efficiency 87 % with 1528 rows, 79 % with 1024, 55 % with 4096, which leaves 4 of the 28 with
  // two chunks). At least 3, and 6 where that leaves them 1300 rows, so that stealing can balance them: 128k grains on
  // 16 threads ran 235, 221, 269 M particle-steps/s with 6 chunks per thread, 208, 194, 214 with 3; 8 or 12 on 8
  // threads brought nothing more. Two threads, Zen 5: 32k and 128k grains alike within 3 % with 2667 to 8000 rows.
  const std::int64_t threads = rules.threads, most = threads <= 2 ? 4096 : 3072;
  if (threads == 1) return rows_stay_near(rows) ? 16384 : 8192;
  const std::int64_t least = std::clamp<std::int64_t>(rows.n / (1300 * threads), 3, 6);
  const std::int64_t each = std::max<std::int64_t>(least, (rows.n + most * threads - 1) / (most * threads));
  const std::int64_t size = (rows.n + each * threads - 1) / (each * threads);
  return static_cast<int>(std::clamp<std::int64_t>((size + 7) / 8 * 8, 1024, 4096));
}

std::vector<double> chunk_costs(const Contacts& contacts) {
  std::vector<double> cost;
  for (const auto& c : contacts.chunks)
    cost.push_back(k_slot_cost * static_cast<double>(c->list.end[2]) +
                   k_contact_cost * static_cast<double>(c->contacts.end[2]) + k_row_cost * (c->hi - c->lo) +
                   k_wall_cost * static_cast<double>(c->wall.state.size()));
  return cost;
}

}  // namespace talus
