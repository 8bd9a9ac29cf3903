// Between rows and cells of the gas: who lies where, what grains give to the cells, what the gas does to grains. Who
// calls it: scheduler/parts/gas.cpp. Invariant (I3): sums over grains run in row order, whatever the chunks.
#pragma once

#include <array>
#include <cstring>
#include <vector>

#include "core/gas/gas.hpp"
#include "scheduler/parts/doors.hpp"
#include "scheduler/parts/gas_bodies.hpp"

namespace talus {

/// The force of the gas on a grain until the next gas step: drag * (gas - v) + push.
struct GasForce {
  double drag = 0;  ///< [kg/s]
  Vec3 gas;         ///< velocity of the gas between the grains [m/s]
  Vec3 push;        ///< volume times falling pressure [N]
  /// On a grain of this velocity [N].
  Vec3 at(const double* v) const {
    return {drag * (gas.x - v[0]) + push.x, drag * (gas.y - v[1]) + push.y, drag * (gas.z - v[2]) + push.z};
  }
};

/// The gas around a grain at the begin of a gas step.
struct GasAtGrain {
  double conductance = 0;  ///< h A of what lies in the grid, without outflow [W/K]
  double film = 0;         ///< h [W/m2/K]
  double slip = 0;         ///< superficial [m/s]
};

/// Rows of a column that hold one of these, which is all doubles.
template <class T>
inline constexpr int k_width = static_cast<int>(sizeof(T) / sizeof(double));
template <class T>
T row_of(const Column<double>& column, Row i) {
  T t;
  std::memcpy(static_cast<void*>(&t), column.data() + static_cast<long>(k_width<T>) * i, sizeof t);
  return t;
}
template <class T>
void set_row(Column<double>& column, Row i, const T& t) {
  std::memcpy(column.data() + static_cast<long>(k_width<T>) * i, &t, sizeof t);
}

/// Adds the forces of a column of GasForce to the force rows of a chunk, those of bodies at their centres.
void push_grains(const PartView& w, const Chunk& c, const Column<double>& force);

/// Parts of the grains in the cells, row after row; rows of a body behind its first one have none.
class GasShares {
 public:
  /// `grains` outlives it.
  explicit GasShares(const GasGrains& grains) : grains_(grains) {}
  /// Of the living rows.
  void find(const PartView& w, const gas::Grid& grid);
  /// Volume and size of the grains into `to`.
  void give(const PartView& w, gas::FromGrains& to) const;
  /// Velocity and drag factor into `to`, each grain with the weight that its own size and velocity give its drag in the
  /// gas of the step before.
  void weigh(const PartView& w, const GasSettings& s, const gas::Grid& grid, const gas::ToGrains& gas,
             gas::FromGrains& to);
  /// Row i's part of what the gas of its cells gives to their grains: with these weights, so that both are one sum.
  GasForce force(const PartView& w, const gas::Grid& grid, const gas::FromGrains& from, const gas::ToGrains& gas,
                 Row i) const;
  GasAtGrain around(const PartView& w, const GasSettings& s, const gas::ToGrains& gas, Row i) const;
  bool reaches(Row i) const { return begin_[static_cast<std::size_t>(i)] < begin_[static_cast<std::size_t>(i) + 1]; }
  /// Calls add(cell, volume in it, share of what lies in the grid) for each cell of row i.
  template <class Add>
  void each(Row i, const Add& add) const {
    double whole = 0;
    for (std::size_t k = begin_[static_cast<std::size_t>(i)]; k < begin_[static_cast<std::size_t>(i) + 1]; ++k)
      whole += parts_[k].second;
    for (std::size_t k = begin_[static_cast<std::size_t>(i)]; k < begin_[static_cast<std::size_t>(i) + 1]; ++k)
      add(static_cast<std::size_t>(parts_[k].first), parts_[k].second, parts_[k].second / whole);
  }

 private:
  const GasGrains& grains_;
  std::vector<std::size_t> begin_;             ///< [rows + 1]
  std::vector<std::pair<int, double>> parts_;  ///< cell, volume of the grain in it [m3]
  std::vector<double> weight_;                 ///< of parts: own drag per volume / that of the cell's law [-]
};

/// What grains take from the gas and give to it: oxidants for their char, steam that condenses on them, gas that they
/// release. Grains together take no more of a cell than there is, and no more steam than brings it to saturation at the
/// coldest of them.
class GasMatter {
 public:
  /// Species that grains take: as GasNear::kept.
  static constexpr std::size_t k_taken[3] = {static_cast<std::size_t>(GasSpecies::o2),
                                             static_cast<std::size_t>(GasSpecies::co2),
                                             static_cast<std::size_t>(GasSpecies::h2o)};

  /// `duration`: of a step [s]. Both references outlive it.
  GasMatter(gas::Gas& gas, const GasShares& shares, double duration)
      : gas_(gas), shares_(shares), duration_(duration) {}

  void add_kept(std::size_t cell, double weight, std::array<double, 3>& to) const {
    for (std::size_t k = 0; k < 3 && !kept_.empty(); ++k) to[k] += weight * kept_[cell][k];
  }
  // as in GasCells
  void offer(Row rows, const std::vector<GasUptake>& uptake);
  double saturable(Row i) const;
  GasSteam steam(Row i) const;
  void give(Row i, const GasFractions& released, const std::array<double, 3>& taken, double condensed, double enthalpy);

 private:
  double steam_pressure(std::size_t c) const;
  /// Fraction of steam in cell c at which the surface of a grain is in balance with it; above 1: it is so dry.
  double balanced(std::size_t c, double saturation) const;
  void keep_steam(Row rows, const std::vector<double>& oxidant);
  void take_condensed(Row i, double condensed, double& enthalpy);
  /// Calls use(cell, mass, kept over balanced) for what would condense on row i: see GasSteam.
  template <class Use>
  void each_condensing(Row i, const Use& use) const;

  gas::Gas& gas_;
  const GasShares& shares_;
  const double duration_;
  std::vector<std::array<double, 3>> kept_;  ///< by cell: see GasNear
  std::vector<GasUptake> offered_;           ///< by row
};

/// The gas as columns of a .vti file.
GridData grid_data(const gas::Grid& grid, const gas::ToGrains& fields);

}  // namespace talus
