// Cost of a scene, measured on its own first steps: what `talus check` predicts from. Called by cli_check.cpp.
#pragma once

#include <cstdint>
#include <string>

#include "scheduler/simulation.hpp"

namespace talus::cli {

struct Cost {
  std::int64_t steps = 0;          ///< measured; 0: nothing was there to measure
  std::int64_t last = 0;           ///< step at which the measurement ended
  double spent = 0;                ///< on all steps up to it [s]
  double per_particle_step = 0;    ///< [s] in the second half of the measurement: the state that goes on
  double dense = 0;                ///< [s] with the contacts of a dense bed, if fewer were there
  double contacts = 0;             ///< per particle, at the end of the measurement
  double shaped = 0;               ///< share of superquadrics among the particles then
  double rebuild = 0, narrow = 0;  ///< [s] per rebuild, per step
  double frame = 0, row = 0;       ///< [s] per output of particles and of the series, without the disk
  double speed = 0;                ///< rms speed [m/s]
  std::string failure;             ///< the measured steps ended with this
  std::string stated;              ///< where nothing could be measured: what is assumed instead
};

/// Runs the simulation for about `seconds`, not beyond its last step; writes nothing.
Cost measure_cost(Simulation& simulation, double seconds);

/// K at which rebuilding and list upkeep balance: n* = sqrt(B R / (3 c v dt)) steps between rebuilds (B: cost of a
/// rebuild, c: cost of the narrow phase per step), within [1, R / (2 v dt)], where the skin's cap ends its growth. 0
/// where nothing moves.
double advised_k(const Cost& cost, double radius, double dt);

}  // namespace talus::cli
