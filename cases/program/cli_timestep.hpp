// The verdict on a scene's time step as the commands show it; the limits themselves are those that the Simulation was
// constructed under.
// Called by cli_check, cli_explain.
#pragma once

#include <string>

#include "cases/program/cli_json.hpp"
#include "core/rules/timestep.hpp"

namespace talus::cli {

/// Indented lines, one per limit.
std::string time_step_text(const TimeStepReport& step);
/// The same as member "time_step" of an open JSON object.
void add_time_step(Json& json, const TimeStepReport& step);

}  // namespace talus::cli
