// The verdict on a scene's time step as the commands show it: limits, shares of them, a warning or a refusal.
// Called by cli_run, cli_check, cli_explain; the limits themselves come from core/timestep.hpp.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "cases/cli_json.hpp"
#include "core/scene.hpp"

namespace talus::cli {

struct TimeStep {
  double dt = 0;                                       ///< [s]
  std::vector<std::pair<std::string, double>> limits;  ///< name, value [s]
  std::string warning;                                 ///< empty where dt is comfortable
};

/// Error{scene} where dt is beyond the packing limit and the scene does not allow it.
TimeStep judge_time_step(const Scene& scene);
/// Indented lines, one per limit with the share of it that dt takes.
std::string time_step_text(const TimeStep& step);
/// The same as member "time_step" of an open JSON object.
void add_time_step(Json& json, const TimeStep& step);

}  // namespace talus::cli
