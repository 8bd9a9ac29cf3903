// Part "conversion": heat, drying, reactions, burning and shrinkage within the grains of a bed. Each material that
// converts is described as a single grain is (core/conversion/grain_file.hpp); its surroundings are those given there.
// Who makes it: parts.cpp from the scene, tests.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/conversion/grain_file.hpp"
#include "scheduler/part.hpp"

namespace talus {

struct ConversionSettings {
  std::int64_t every = 100;  ///< contact steps per step of conversion
  int shells = 20;
  double gone_below = 0;  ///< grains leave below this share of their first radius; 0: never
  bool resizes = true;    ///< radius and mass follow
  std::vector<std::shared_ptr<const conversion::GrainJob>> matter;  ///< by material; null: does not convert
};

/// Of a scene; null where it has none. Error{scene, io}: as below, or a grain file that cannot be read.
std::unique_ptr<Part> make_conversion(const Rules& rules);
/// Error{scene}: another density than that of the material, or what the solver of many grains does not compute.
std::unique_ptr<Part> make_conversion(const Rules& rules, const ConversionSettings& settings);

}  // namespace talus
