// Averages over regions and grids, and flux through planes, from frames. Who calls it: cases/ (run) at output times.
// Pure reading: nothing here influences a trajectory. Invariant: a grid over the whole domain contains each sphere's
// volume once (weights of a sphere over all cells sum to 1, up to what sticks out of the domain).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/frame.hpp"
#include "core/io/vtp.hpp"
#include "core/scene.hpp"

namespace talus {

/// Averages over one region; a sphere that is partly inside counts by its share w of volume inside (share_inside in
/// core/region.hpp: also what sticks through a periodic side counts where it comes in again).
struct RegionAverage {
  double particles = 0;            ///< sum of w
  double solid_fraction = 0;       ///< sum of w V_p / region volume
  Vec3 velocity;                   ///< mass-weighted mean [m/s]; 0 if empty
  double temperature = 0;          ///< granular: mass-weighted mean of |v - mean|^2 / 3 [m2/s2]
  double coordination = 0;         ///< mean over particles; 0 unless the frame has it
  std::array<double, 6> stress{};  ///< contact stress, sum of w V_p sigma_p / volume: xx yy zz xy xz yz [Pa]
};

RegionAverage average_region(const Frame& frame, const Scene& scene, const Region& region);

/// The same averages on nx*ny*nz cells over the domain as cell columns solid_fraction, velocity, granular_temperature
/// and, where the frame has them, coordination and stress (VTK order). Periodic axes wrap. Error{io} if cells < 1.
GridData average_grid(const Frame& frame, const Scene& scene, std::array<int, 3> cells);
/// Memory that average_grid() takes [B].
double grid_bytes(std::array<int, 3> cells) noexcept;

/// Net passage through a plane along its normal since the start.
struct FluxTotal {
  std::int64_t particles = 0;
  double mass = 0;  ///< [kg]
};

/// Counts net passages through infinite planes by comparing the side of each particle id between successive frames.
/// Chosen over a crossing test in every step: it needs nothing from the engine, and the net count of a particle present
/// in both frames is exact for any interval, since passing and returning cancel. Periodic displacements are unwrapped
/// by minimum image (right while a particle moves less than half a period per interval). A particle that is gone is
/// taken to the open side of the domain that it left by (where its straight path from the last frame meets one, else
/// the nearest); if a `remove` event lies in the interval, it is only followed straight for the interval. A particle
/// that is new counts from its first frame on.
class FluxPlanes {
 public:
  explicit FluxPlanes(const Scene& scene);
  /// Compares with the frame before (none at first).
  void update(const Frame& frame);
  const std::vector<FluxTotal>& totals() const noexcept { return totals_; }
  /// All state as bytes for the checkpoint (section "flux") and back. Error{io} if it does not fit the scene.
  std::vector<std::uint8_t> save() const;
  void load(std::span<const std::uint8_t> bytes);

 private:
  struct Past {
    ParticleId id = 0;
    Vec3 x, v;
    double mass = 0;
  };
  void count(const Past& from, Vec3 displacement, Vec3 shift);
  Vec3 departure(const Past& from, double interval, bool removed_by_event) const;
  Scene scene_;
  std::vector<Past> past_;
  double time_ = 0;
  std::vector<FluxTotal> totals_;
};

}  // namespace talus
