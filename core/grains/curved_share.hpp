// How much of a sphere lies within a ball or a round bar with flat ends. Who calls it: core/grains/region.cpp.
// Invariant: I4.
#pragma once

namespace talus {

/// Share of a sphere of radius r in a ball of radius R, at a distance of their centres: the lens in closed form.
double share_in_ball(double R, double distance, double r) noexcept;

/// The same in a bar of radius R about an axis, between two flat ends at `low` and `high` along the axis from the
/// sphere's centre, which is `off` from the axis: areas of lenses along the axis, summed to about 1e-5.
double share_in_bar(double R, double low, double high, double off, double r) noexcept;

}  // namespace talus
