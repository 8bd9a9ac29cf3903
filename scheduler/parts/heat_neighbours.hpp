// What grains exchange heat with over a distance: grains, their periodic images, walls. Made at heat steps, row by row
// on all threads. Who uses it: heat_step. Invariants: partners of a row come in ascending storage index, images of one
// in the order of their periods (I3); what two grains exchange is the same seen from both, to the bit.
#pragma once

#include <vector>

#include "scheduler/parts/heat.hpp"
#include "scheduler/parts/heat_near.hpp"

namespace talus {

inline constexpr Row k_heat_rows = 1024;  // per block

/// A grain, or an image of it, that another exchanges with over a distance.
struct Near {
  Row j;
  double gap;   ///< conductance of the gas between; of two fixed grains that of their contact too [W/K]
  double area;  ///< of radiation, not yet shaded [m2]
};

struct NearWall {
  int entry;         ///< of [[heat.wall]]
  double gap, area;  ///< as in Near
  double emissivity;
  double layer = 0;  ///< conductance of its layer [W/K]; 0: it has none
  double touch = 0;  ///< of the contact, which passes the same layer [W/K]
};

/// Neighbours of the rows of a block.
struct NearRows {
  std::vector<Near> all;
  std::vector<NearWall> walls;
  std::vector<std::int32_t> first, first_wall;
};

class HeatNeighbours {
 public:
  HeatNeighbours(const HeatState& s, const PartView& w) : s_(s), w_(w), box_(w.rules.scene.domain.box()) {}
  /// Those of all rows; nothing where no grain has any.
  void find(int blocks);
  bool any() const { return !near_.empty(); }
  const NearRows& of(int block) const { return near_[static_cast<std::size_t>(block)]; }
  /// Share of what row i would see that is in sight.
  double shade(Row i) const { return shade_[static_cast<std::size_t>(i)]; }

 private:
  /// Something acts without touching.
  bool reaches() const { return s_.scene.gap.conductivity > 0 || s_.scene.radiation.grains; }
  /// Of two fixed grains no list of the engine holds the contact: neither can move.
  bool fixed(Row i) const { return w_.rules.has.fixed && w_.rows.fixed[i] != 0; }
  double reach(double r, double q) const;
  double largest_radius() const;
  bool meets_itself(double r) const;
  void find(const NearGrid& grid, int block);
  double find_grains(Row i, const std::vector<Row>& partners, std::vector<Near>& found) const;
  double add_grain(Row i, Row j, double distance, bool nearest, std::vector<Near>& found) const;
  double find_walls(Row i, std::vector<NearWall>& found, std::vector<std::int32_t>& elements) const;

  const HeatState& s_;
  const PartView& w_;
  const Box box_;
  std::vector<NearRows> near_;
  std::vector<int> entry_;     ///< of each wall
  std::vector<double> shade_;  ///< by row
};

}  // namespace talus
