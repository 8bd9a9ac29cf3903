// Conversion of grains in a bed, as its section says it. Plain data, which belongs to Scene. Who fills it:
// core/scene/sections/conversion.cpp; who reads it: the part in scheduler/parts/conversion.hpp.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace talus {

struct ConversionScene {
  bool on = false;
  std::int64_t every = 100;  ///< steps per step of conversion
  int shells = 20;
  double gone_below = 0;  ///< grains leave below this share of their first radius; 0: never
  bool resize = true;
  std::vector<std::string> grain;  ///< by material: the file that describes its grains; empty: they do not convert
};

}  // namespace talus
