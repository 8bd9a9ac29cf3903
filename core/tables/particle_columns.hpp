// What the names of columns mean: Talus's own, and those that other programs write. Who calls it: the CSV reader.
// Invariant: a name means one thing or nothing; nothing is guessed from a part of it.
#pragma once

#include <string>
#include <string_view>

namespace talus {

enum class ParticleColumn {
  x,
  y,
  z,
  radius,
  vx,
  vy,
  vz,
  wx,
  wy,
  wz,
  material,
  fixed,
  diameter,
  density,
  type,
  id,
  shape,
  scale,
  qw,
  qx,
  qy,
  qz,
  body,
  none
};
constexpr int k_particle_columns = static_cast<int>(ParticleColumn::none);

struct ColumnMeaning {
  ParticleColumn column = ParticleColumn::none;
  std::string unit;  ///< in brackets behind the name, lower case; "" where none is stated
  bool own = false;  ///< Talus's own name, which goes before others with the same meaning
};

/// Upper or lower case; units in brackets; "Points:0", "Position X (m)", "velocity_y", "Angular Velocity:2", "omegaz";
/// "orientation:0" to 3 are w, x, y, z, as bodies.pvd has them.
ColumnMeaning column_meaning(std::string_view name);

/// Talus's name of a column.
std::string_view column_name(ParticleColumn column) noexcept;

}  // namespace talus
