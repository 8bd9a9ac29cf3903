// Views of a run: energies, frames, plan, memory. Nothing here changes anything.
#pragma once

#include <optional>

#include "core/base/types.hpp"
#include "core/frame/frame.hpp"
#include "scheduler/reports.hpp"

namespace talus {

struct World;

Energies energies_of(const World& w);
/// Energy rows of the contacts of the present positions, as Ledger::rows; only with energies (frame.cpp). `walls_of`:
/// on the calling thread alone, within a step; the scene's walls act as at that step.
Column<double> energy_rows(const World& w, std::optional<std::int64_t> walls_of = {});
Frame frame_of(const World& w, const FrameRequest& request);  ///< frame.cpp
Plan plan_of(const World& w);                                 ///< explain.cpp
std::size_t bytes_of(const World& w);

}  // namespace talus
