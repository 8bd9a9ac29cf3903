// Advice on a grain: Biot number, level, shells, heat step. Who calls it: the command.
#pragma once

#include <string>

#include "core/conversion/grain_file.hpp"

namespace talus::conversion {

struct GrainAdvice {
  double film = 0;          ///< coefficient at the start, radiation included [W/m2/K]
  double biot = 0;          ///< film times radius over 3 times the conductivity
  double monotone = 0;      ///< largest step at which tr_bdf2 keeps every profile monotone [s]
  double diffusion = 0;     ///< R^2 / diffusivity [s]
  double lumped_error = 0;  ///< of the slowest decay when one temperature is taken for all
};

GrainAdvice advise(const GrainJob& job);
std::string advice_text(const GrainJob& job);

}  // namespace talus::conversion
