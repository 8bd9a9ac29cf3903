// What a failed run leaves for whoever wants to know why. Called by outputs.cpp. Invariant: reads the state before
// the failed step, in which every number is finite.
#pragma once

#include <string>

#include "scheduler/simulation.hpp"

namespace talus {

/// CSV of the particles that the failure names and all within four largest radii of them, nearest first: id, position,
/// radius, velocity, distance to the culprit and what each touches, as "partner:overlap/radius". Writes nothing where
/// the failure names nobody. Error{io}.
void write_neighbourhood(const Simulation& simulation, const std::string& path);

}  // namespace talus
