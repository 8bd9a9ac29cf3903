// Which grains a scene can hold, and the fastest of them: what the limits of the time step are judged by. Filled by
// Insertion::population() (files are read) or for a range of radii; read by core/rules/timestep.cpp. Invariant: a pair
// of kinds that can never meet is in no judgement.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/scene/scene.hpp"

namespace talus {

/// Grains of one material, free ones and those that stay fixed apart. The two smallest and two largest radii [m] of
/// different grains: where only one grain is small, no pair of small ones exists.
struct GrainKind {
  int material = 0;
  bool fixed = false;
  double smallest[2] = {k_never, k_never}, largest[2] = {0, 0};
  std::int64_t count = 0;  ///< at most so many, capped at k_many_grains
  /// Of bodies, of which the radii are those of the roundest contacts: what answers a force on one over the mass of
  /// such a sphere; the smallest radius over that one.
  double weight = 1, thinnest = 1;
  double whole = 1;  ///< its whole mass over that of such a sphere
};
inline constexpr std::int64_t k_many_grains = 1000;

/// What states a velocity: a grain of a file, a source, an event.
struct Mover {
  std::string name;           ///< "particle 3", "source 'feed'"
  std::string place;          ///< "bed.csv:5", or empty
  double slowest = 0;         ///< [m/s] of its grains ...
  double fastest = 0;         ///< ... and the largest
  double smallest = k_never;  ///< radius [m] of its grains ...
  double largest = 0;         ///< ... and the largest
};

class Population {
 public:
  /// `count` grains of radius smallest to largest [m], with any radius in between.
  void add(int material, bool fixed, double smallest, double largest, std::int64_t count, double weight = 1,
           double thinnest = 1, double whole = 1);
  void add_velocity(Vec3 low, Vec3 high, double surface = 0);  ///< range per axis, of the surface by spin [m/s]
  double reach = 0;  ///< from the centre of a body of a file to its farthest point, at most [m]
  std::vector<GrainKind> kinds;
  std::vector<Mover> movers;
  std::int64_t free_grains() const;  ///< capped
  double smallest_free() const;      ///< [m], 0: none
  double largest_free() const;
  /// Largest stated speed, spins included, and the largest difference of two stated velocities, one of them possibly
  /// rest [m/s].
  double fastest() const;
  double spread() const;

 private:
  Vec3 low_, high_;
  double surface_ = 0;
};

/// Particles of radius r_min to r_max [m] of every material that the scene's sources name (a file may hold any),
/// without reading files.
Population population_of(const Scene& scene, double r_min, double r_max);
/// Velocities that events state, within the scene's duration; of sources other than files.
void add_stated_velocities(const Scene& scene, Population& population);

}  // namespace talus
