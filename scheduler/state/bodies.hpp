// Bodies: rigid bodies of several spheres. Their spheres are ordinary rows, one after another, whose positions and
// velocities follow from the body; pair and wall contacts know nothing of bodies. Who writes them: insert (append),
// integrate (the second buffers), sort epochs (order), events; removal takes the rows, a sort epoch then the body.
// Invariants: I3 (forces are summed in row order; bodies lie in the order of their rows after an epoch, new ones
// behind), I4, I6. Positions are relative to the domain's lower corner; on periodic axes the centre and every sphere
// are wrapped for themselves.
#pragma once

#include "core/base/columns.hpp"
#include "core/base/types.hpp"
#include "core/grains/body_shape.hpp"
#include "core/grains/insertion.hpp"
#include "scheduler/state/clock.hpp"
#include "scheduler/state/rules.hpp"

namespace talus {

struct Rows;

struct Bodies {
  std::int32_t n = 0;
  Column<Row> first;           ///< row of its first sphere
  Column<std::int32_t> shape;  ///< index into scene.shapes
  Column<double> size, size2;  ///< {scale, mass [kg]}; the second buffer only where sizes change
  Column<double> x, x2;        ///< {centre of mass, radius of the sphere about it that holds all}
  Column<double> v, v2;        ///< {velocity at n-1/2, 1/m; 0: held}
  Column<double> turn, turn2;  ///< quaternion w, x, y, z from the principal axes to space
  /// {angular momentum in the principal axes at n-1/2 as they lie at n, 0}; of a held body its angular velocity in
  /// space
  Column<double> spin, spin2;
  Columns columns;       ///< those above but `first`
  bool in = false;       ///< the scene has bodies
  bool resized = false;  ///< their scales and masses change

  explicit Bodies(const Rules& rules);
  void swap() noexcept;  ///< second buffers change places
  double scale(std::int32_t b, bool second = false) const { return (second && resized ? size2 : size)[2L * b]; }
  double mass(std::int32_t b, bool second = false) const { return (second && resized ? size2 : size)[2L * b + 1]; }
  Vec3 centre(std::int32_t b) const { return {x[4L * b], x[4L * b + 1], x[4L * b + 2]}; }
};

void set_body_capacity(Bodies& bodies, std::int32_t n);  ///< resizes all columns, keeps content
const BodyShape& shape_of(const Rules& rules, const Bodies& bodies, std::int32_t b);
/// Moments of inertia are this times shape.moments [kg].
double inertia_scale(const Bodies& bodies, std::int32_t b, bool second = false);

/// Motion of a body as numbers.
struct BodyState {
  Vec3 x, v;
  shapes::Quaternion turn;
  Vec3 spin;
};
BodyState state_of(const Bodies& bodies, std::int32_t b, bool second = false);
/// Angular velocity in space of the angular momentum l in the principal axes [rad/s].
Vec3 spin_of(const BodyShape& shape, double inverse_inertia, const shapes::Rotation& r, Vec3 l);
Vec3 angular_velocity(const Rules& rules, const Bodies& bodies, std::int32_t b);
void set_angular_velocity(const Rules& rules, Bodies& bodies, std::int32_t b, Vec3 w);
Vec3 wrapped(const Rules& rules, Vec3 x);  ///< into the domain through periodic sides; at most one period off

/// Rows from `first` on are those of the new particles; bodies among them take theirs. `energy` [J], or null: what
/// comes in with them is added to it.
void append_bodies(const Rules& rules, const Clock& clock, Rows& rows, Row first, const NewParticles& a,
                   double* energy);
/// Rows follow a body whose motion has been set, positions and velocities.
void place_rows(const Rules& rules, Rows& rows, std::int32_t b);
/// After a sort epoch has ordered the rows: bodies in the order of their rows, those without rows are gone.
void sort_bodies(Rows& rows);
/// What is saved of the bodies of other rows, which these are a copy of.
void copy_bodies(const Rows& from, Rows& to);
/// Bodies learn their rows from rows.body.
void find_rows(Rows& rows);

/// Of the angular momentum l in the principal axes, and of the present motion [J].
double rotation_energy(const Rules& rules, const Bodies& bodies, std::int32_t b, Vec3 l, bool second = false);
double rotation_energy(const Rules& rules, const Bodies& bodies, std::int32_t b);
/// Angular momentum in space [kg m2/s].
Vec3 momentum_in_space(const Rules& rules, const Bodies& bodies, std::int32_t b, bool second = false);

}  // namespace talus
