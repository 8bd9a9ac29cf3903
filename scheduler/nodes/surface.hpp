// A row as its true surface: a superquadric, or a sphere. Who makes it: contacts of superquadrics with grains and
// walls. Invariants: I4; a function of the row and its body alone.
#pragma once

#include "core/shapes/pair_contact.hpp"
#include "scheduler/state/rows.hpp"
#include "scheduler/state/rules.hpp"

namespace talus {

struct Surface {
  const BodyShape* shape = nullptr;  ///< of a superquadric that is no ball; null: a sphere
  shapes::DualForm<shapes::Plain> form;
  double size = 0, roundness = 0;         ///< largest semi-axis, smallest radius of curvature [m]
  double inner = 0, middle = 0;           ///< radius of the sphere within, and of that of equal volume [m]
  const QuadricShape* quadric = nullptr;  ///< of the shape, at scale 1
  double scale = 1;
  shapes::Rotation turn{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  Vec3 v, w;                ///< [m/s], [rad/s] at n-1/2
  double inverse_mass = 0;  ///< 0: held
  Vec3 inverse_inertia;     ///< principal [1/(kg m2)]; of spheres 0: no normal force turns them

  shapes::Body body(Vec3 centre) const { return {form, size, roundness, centre, turn}; }
};

/// The shape of the row's body where that is a superquadric and no ball, else null.
const BodyShape* superquadric_of(const Rules& rules, const Rows& rows, Row i);
Surface surface_of(const Rules& rules, const Rows& rows, Row i);
/// The same in place: copies of what was just written in narrow stores would wait for them.
void set_surface(const Rules& rules, const Rows& rows, Row i, Surface& s);

/// What a force along the unit vector n at `arm` from the centre sets in motion there, 1/m + (r x n) I^-1 (r x n)
/// [1/kg].
double answer_of(const Surface& s, Vec3 arm, Vec3 n);
/// The same over 1/m; 1 of what is held.
double weight_of(const Surface& s, double answer);
/// Radius for Hertz where the outer normal is n [m].
double hertz_radius_of(const Surface& s, Vec3 n);

/// The law sees x = n 2^200 and 1/d = 2^-200: the normal exactly, and no tilt of it by half a step's way, since the
/// velocity that it is given belongs to the middle of the step already.
inline constexpr double k_far_away = 0x1p200, k_far_inverse = 0x1p-200;

}  // namespace talus
