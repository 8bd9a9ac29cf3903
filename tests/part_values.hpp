// Values that the parts of a simulation put into its series.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "scheduler/simulation.hpp"

namespace talus {

inline double value_of(const Simulation& sim, const std::string& name) {
  for (const PartValue& v : sim.part_values())
    if (v.name == name) return v.value;
  ADD_FAILURE() << "no value " << name;
  return 0;
}

}  // namespace talus
