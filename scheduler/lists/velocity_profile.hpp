// The velocity profile that list policy velocity_profile measures speeds and displacements against.
// Who calls it: prepare_skins(). Invariants: I1, I2; the proof is in skin_check.cpp.
#pragma once

#include "scheduler/lists/lists.hpp"
#include "scheduler/team/team.hpp"

namespace talus {

/// Fits a drift velocity that is piecewise linear along one axis to the particles, as hat-weighted means at equidistant
/// nodes along the open axis that explains most of their kinetic energy, and writes each row's value to Lists::drift.
/// The slope is bounded by (1 - 1 / k_most_stretch) / life, `life` [s] being how long the lists may last. Sets
/// ListFrame::stretch = 1 / (1 - slope life). One value for all rows where every axis is periodic.
/// Returns the largest drift speed [m/s].
double fit_velocity_profile(const Rules& rules, const Rows& rows, const Contacts& contacts, Lists& lists, Team& team,
                            double life);

}  // namespace talus
