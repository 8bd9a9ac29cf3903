// The verdict on a scene's time step as the commands show it; the limits themselves come from core/timestep.
// Called by cli_run, cli_check, cli_explain.
#pragma once

#include <string>

#include "cases/cli_json.hpp"
#include "core/scene.hpp"
#include "core/timestep.hpp"

namespace talus::cli {

/// Limits for all radii that the scene's sources can deliver. Error{scene} where dt is beyond the packing limit and the
/// scene does not allow it, or where a file of particles is bad.
TimeStepReport judge_time_step(const Scene& scene);
/// Indented lines, one per limit.
std::string time_step_text(const TimeStepReport& step);
/// The same as member "time_step" of an open JSON object.
void add_time_step(Json& json, const TimeStepReport& step);

}  // namespace talus::cli
