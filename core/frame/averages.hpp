// Averages over regions and grids, from frames. Who calls it: cases/ (run) at output times. Pure reading: nothing here
// influences a trajectory. All of it is of the moment of the frame, nothing is averaged over time. Invariant: a grid
// over the whole domain contains each grain's volume once (weights of a grain over all cells sum to 1, up to what
// sticks out of the domain). A body that is no sphere is one grain, with its true volume (body_shares.hpp).
#pragma once

#include <array>
#include <span>
#include <string_view>
#include <vector>

#include "core/frame/columns.hpp"
#include "core/frame/frame.hpp"
#include "core/scene/scene.hpp"

namespace talus {

class BodyShares;

/// Averages over one region; a sphere that is partly inside counts by its share w of volume inside (share_inside in
/// core/grains/region.hpp: also what sticks through a periodic side counts where it comes in again).
struct RegionAverage {
  double particles = 0;            ///< sum of w
  double solid_fraction = 0;       ///< sum of w V_p / region volume
  Vec3 velocity;                   ///< mass-weighted mean [m/s]; 0 if empty
  double temperature = 0;          ///< granular: mass-weighted mean of |v - mean|^2 / 3 [m2/s2]
  double coordination = 0;         ///< mean over particles; 0 unless the frame has it
  std::array<double, 6> stress{};  ///< contact stress, sum of w V_p sigma_p / volume: xx yy zz xy xz yz [Pa]
};

/// One of the averages: a column of the series for each region, and a cell column of grids.
struct AverageQuantity {
  std::string_view name, unit, doc;
  int components;                                ///< 6: xx yy zz xy xz yz
  void (*value)(const RegionAverage&, double*);  ///< puts its components
  bool (*wanted)(const Scene&) = nullptr;        ///< nullptr: always
  bool in_grids = true;
};
std::span<const AverageQuantity> average_quantities() noexcept;
/// Those that a scene asks for.
std::vector<const AverageQuantity*> averages_of(const Scene& scene);

RegionAverage average_region(const Frame& frame, const Scene& scene, const Region& region);
/// `shares`: of the scene, kept by whoever asks more than once.
RegionAverage average_region(const Frame& frame, const Scene& scene, const Region& region, const BodyShares& shares);

/// The same averages on nx*ny*nz cells over the domain as cell columns (tensors in VTK's order). Periodic axes wrap.
/// Error{io} if cells < 1.
GridData average_grid(const Frame& frame, const Scene& scene, std::array<int, 3> cells);
GridData average_grid(const Frame& frame, const Scene& scene, std::array<int, 3> cells, const BodyShares& shares);
/// Memory that average_grid() takes [B].
double grid_bytes(std::array<int, 3> cells) noexcept;

}  // namespace talus
