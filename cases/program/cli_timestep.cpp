// Time step of a scene; see cli_timestep.hpp.
#include "cases/program/cli_timestep.hpp"

#include <fmt/format.h>

namespace talus::cli {

std::string time_step_text(const TimeStepReport& step) {
  std::string text = fmt::format("    dt = {:.6g} s\n", step.dt);
  for (const std::string& line : step.lines) text += "    " + line + "\n";
  return text;
}

void add_time_step(Json& json, const TimeStepReport& step) {
  json.begin_object("time_step").add("dt", step.dt).add("share", step.share);
  const auto limit = [&](const char* name, const TimeStepLimit& l) {
    json.begin_object(name).add("seconds", l.seconds).add("pair", l.pair).end_object();
  };
  limit("rayleigh", step.rayleigh);
  limit("contact", step.contact);
  limit("isolated_pair", step.isolated_pair);
  limit("packing", step.packing);
  json.add("fastest_grain", step.speeds.grain).add("fastest_wall", step.speeds.wall).add("speed", step.speeds.closing);
  json.add("warning", step.warning).end_object();
}

}  // namespace talus::cli
