// Heat of a scene, as its sections say it: matter, walls, sources, gas, radiation. Plain data, which belongs to Scene.
// Who fills it: core/scene/sections/heat.cpp; who reads it: the part in scheduler/parts/heat.hpp.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/curve.hpp"
#include "core/base/types.hpp"
#include "core/base/words.hpp"

namespace talus {

TALUS_WORDS(NusseltLaw, ranz_marshall, whitaker, gunn, wakao)
/// What the contacts of a softened model share with real ones: the energy of an impact, or the load.
TALUS_WORDS(HeatSoftening, impact, load)

/// Of one material.
struct MatterHeat {
  Curve capacity;      ///< [J/kg/K]
  Curve conductivity;  ///< [W/m/K]
  double emissivity = 0.9;
  double young = 0;                  ///< real modulus [Pa]; 0: that of the contact law
  double solidus = 0, liquidus = 0;  ///< between which it melts [K]
  double latent_heat = 0;            ///< of melting [J/kg]; 0: it does not
  double expansion = 0;              ///< of the radius per rise of temperature [1/K]
};

/// Of the grains of a source.
struct SourceHeat {
  double temperature = 0;  ///< [K]
  bool held = false;       ///< its grains keep it
};

/// Of a wall, named; those without are adiabatic.
struct WallHeat {
  std::string wall;
  TimeTable temperature;      ///< of the wall, or beyond its layer [K]
  TimeTable flux;             ///< into the grains that touch it [W/m2]
  std::vector<double> layer;  ///< between that temperature and the grains: thickness [m], conductivity [W/m/K]
};

/// Gas of given temperature and velocity around all grains.
struct GasHeat {
  bool on = false;
  TimeTable temperature;  ///< [K]
  Vec3 velocity;          ///< [m/s]
  NusseltLaw law = NusseltLaw::ranz_marshall;
  double conductivity = 0.026, viscosity = 1.8e-5, density = 1.2, capacity = 1005;
  double porosity = 0.4;  ///< laws of beds only
  double film = -1;       ///< coefficient given in place of a law [W/m2/K]
};

/// Heat through stagnant gas between near surfaces.
struct GapHeat {
  double conductivity = 0;  ///< [W/m/K]; 0: none
  double layer = 0.4;       ///< thickness of the layer that a grain carries / radius
  double least_gap = 2.75e-8;
};

struct RadiationHeat {
  TimeTable enclosure;  ///< temperature [K]; not given: none
  bool grains = false;  ///< between grains
  double range = 1.5;   ///< largest gap between two grains that see each other / their mean radius
};

/// A beam from above, along -z, whose axis moves along straight lines between way points.
struct Laser {
  TimeTable power;             ///< [W]
  double radius = 0;           ///< at which the intensity is 1/e2 of that on the axis [m]
  double absorptivity = 0;     ///< of the first grain that a ray meets
  std::vector<double> x, y;    ///< way points [m]
  double speed = 0;            ///< [m/s]
  double start = 0, stop = 0;  ///< on from start on, off from stop or its last way point on [s]
  std::int64_t rays = 48;      ///< along each side of the square that they fill
};

struct HeatScene {
  bool on = false;
  std::int64_t every = 100;     ///< steps per heat step
  double error = 0;             ///< wanted of temperatures [K]: every times a power of two; 0: always `every`
  std::int64_t every_most = 0;  ///< most steps then; 0: k_heat_growth times every
  double temperature = 0;       ///< at the start, of grains whose source gives none [K]
  HeatSoftening softening = HeatSoftening::impact;
  bool friction = false;            ///< what contacts dissipate heats the grains
  std::vector<MatterHeat> matter;   ///< by material
  std::vector<SourceHeat> sources;  ///< by source
  std::vector<WallHeat> walls;
  GasHeat gas;
  GapHeat gap;
  RadiationHeat radiation;
  std::vector<Laser> lasers;
};

inline constexpr std::int64_t k_heat_growth = 64;

/// Distance from the middle of a grain of radius r within which it exchanges something with a wall [m].
inline double heat_reach(const HeatScene& h, double r) noexcept {
  const double layer = h.gap.conductivity > 0 ? h.gap.layer : 0,
               sight = h.radiation.grains ? 0.5 * h.radiation.range : 0;
  return r * (1 + (layer > sight ? layer : sight));
}

}  // namespace talus
