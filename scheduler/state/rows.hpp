// Rows: the particles, one row each, in storage order. Who writes them: insert (append), integrate (p2, v2), sort
// epochs (order), the step's end (swap). Invariants: I2 (a removed row stays in place, dead), I3 (storage order is
// canonical), I6. Position rows are relative to the domain's lower corner. Behind the last row there is a dead one, and
// padding.
#pragma once

#include "core/base/columns.hpp"
#include "core/base/types.hpp"
#include "core/grains/insertion.hpp"
#include "scheduler/state/bodies.hpp"
#include "scheduler/state/clock.hpp"
#include "scheduler/state/rules.hpp"

namespace talus {

inline constexpr double k_gone = 1e150;  ///< coordinate of removed rows: touches nothing, stays finite
inline constexpr double k_far = 1e100;   ///< present rows have smaller coordinates

struct Rows {
  Row n = 0;
  Row alive = 0;
  ParticleId next_id = 0;
  int stride = 4;        ///< doubles per row of v
  Column<double> p, p2;  ///< {x, y, z, r}
  Column<double> v, v2;  ///< {v, 0 | r w, 1/m} or {v, 1/m}
  Column<ParticleId> id;
  Column<std::uint8_t> material;  ///< only with several materials
  Column<std::uint8_t> fixed;     ///< held or driven now; only where something can be fixed
  Column<std::uint8_t> in_file;   ///< it was fixed in its file; only where a group asks for that
  Column<std::int16_t> group;     ///< only with groups
  Column<std::int32_t> body;      ///< only with bodies: index of the body that a row belongs to, or -1
  Bodies bodies;
  bool velocity_at_old_step = false;  ///< v2 holds v(n-3/2) of the same rows (for |a| in the skin)
  bool resized = false;               ///< a part changes sizes: a free row's mass is that of its velocity row
  Columns columns;                    ///< those above, and those of other owners

  explicit Rows(const Rules& rules);
  bool is_alive(Row i) const { return p[4L * i] < k_far; }
  std::int32_t body_of(Row i) const { return bodies.in ? body[static_cast<std::size_t>(i)] : -1; }
  /// Row {x, y, z, r} of its grain: of the sphere, or of the body that it belongs to.
  const double* grain_at(Row i) const {
    const std::int32_t b = body_of(i);
    return b < 0 ? p.data() + 4L * i : bodies.x.data() + 4L * b;
  }
  /// A row that stands for its grain: a sphere, or the first of a body.
  bool leads(Row i) const {
    const std::int32_t b = body_of(i);
    return b < 0 || bodies.first[static_cast<std::size_t>(b)] == i;
  }
  Row grains() const { return alive - of_bodies + bodies_alive; }  ///< a body is one
  Row of_bodies = 0, bodies_alive = 0;                             ///< rows of present bodies, and these
};

/// [kg] from material and radius, or as it was given; of a body where its first row is asked for.
double mass_of(const Rules& rules, const Rows& rows, Row i);
/// The same of the step that v2 belongs to.
double old_mass_of(const Rules& rules, const Rows& rows, Row i);
Vec3 position_of(const Rules& rules, const Rows& rows, Row i);  ///< absolute [m]
Vec3 centre_of(const Rules& rules, const Rows& rows, Row i);    ///< of its grain, absolute [m]
/// Velocity {v, ...} of the grain that a row leads, its inverse mass last; second: of the second buffer.
struct GrainVelocity {
  const double* v;
  double inverse_mass;
};
GrainVelocity velocity_of(const Rows& rows, Row i, bool second = false);
/// Components of gravity along the periodic axes, or along the others [m/s2].
Vec3 gravity_along(const Rules& rules, const Clock& clock, bool periodic);
/// At n: kinetic, and potential where the row is free [J].
double row_energy(const Rules& rules, const Rows& rows, const Clock& clock, Row i);
/// True if coordinates and velocity of a present row are finite.
bool finite_row(const Rows& rows, Row i);

/// One copy of all rows takes at most 6 MiB: they stay in nearer caches, where prefetching costs 7 % and chunks may be
/// larger.
inline bool rows_stay_near(const Rows& rows) {
  return static_cast<std::size_t>(rows.n) * static_cast<std::size_t>(rows.stride + 4) * sizeof(double) <= std::size_t{6}
                                                                                                              << 20;
}

void set_particle_capacity(Rows& rows, Row n);  ///< resizes all columns to n rows (+ dead row), keeps content
/// Appends new particles as rows. `energy` [J], or null: what comes in with them is added to it.
void append_particles(const Rules& rules, const Clock& clock, Rows& rows, const NewParticles& a, double* energy);

}  // namespace talus
