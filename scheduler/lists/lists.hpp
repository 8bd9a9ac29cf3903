// Lists: what the pair lists were made from and how long they hold: reference rows, skins, the cell grid, the tuner.
// The lists themselves lie in the chunks (state/contacts.hpp). Who writes it: rebuild and sort epochs; integration says
// when a skin is used up. Invariants: I1, I2; nothing here is state (a resume makes it anew).
#pragma once

#include <atomic>
#include <cstdint>

#include "core/base/columns.hpp"
#include "core/base/types.hpp"
#include "kernels/views.hpp"
#include "scheduler/lists/list_frame.hpp"
#include "scheduler/lists/skin.hpp"
#include "scheduler/lists/tuner.hpp"
#include "scheduler/state/contacts.hpp"
#include "scheduler/state/rules.hpp"

namespace talus {

/// The cell grid of the last rebuild.
struct CellGrid {
  Column<float> reach;                              ///< by row: inflated reach [m]
  Column<std::int32_t> cell_of_row, place_in_cell;  ///< by row
  Column<float> sx, sy, sz, sr;                     ///< sorted by cell
  Column<std::int32_t> sorted_row, cell_start;
  GridLevel level[k_max_levels] = {};
  int levels = 0;
};

struct Lists {
  Column<double> x0;         ///< {x, y, z at the rebuild, skin^2}
  Column<float> drift;       ///< [4 n] only with Policy::row_drift: {u, 0}, the profile's at x0 [m/s]
  Column<double> outer;      ///< [4 n] only with Policy::cuts: {x, y, z at the outer list, its skin}
  Column<double> near;       ///< [4 n] the same: {x, y, z, reach in the inner list}
  Column<double> next_skin;  ///< only with Policy::past [m]; -1: no past
  SkinRule skin;
  ListFrame frame;
  SkinTuner tuner;
  ListSeries series;
  CellGrid grid;
  bool valid = false;                   ///< false: the next check must rebuild whatever the skins say
  std::atomic<bool> any_expired{true};  ///< some row has used up its skin since the lists were made
  std::int64_t last_rebuild_step = 0;
  RebuildSeconds seconds{};  ///< of the parts that are not done chunk by chunk

  Lists(const Rules& rules, const SkinRule& rule, Columns& columns);
  /// Drift velocity of a row for the policies that have one (SkinRule::drifts()) [m/s].
  Vec3 drift_of(Row i) const {
    const float* u = drift.empty() ? frame.drift : drift.data() + 4L * i;
    return {u[0], u[1], u[2]};
  }
};

void mark_gone(Rows& rows, Lists& lists, Row i);  ///< makes a row dead (I2)

}  // namespace talus
