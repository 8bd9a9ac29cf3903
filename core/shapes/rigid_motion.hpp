// Motion of a rigid body: the free rotation as a symplectic, time-reversible map, and kicks. Who calls it: integration
// of clumps and superquadrics. Invariants: I4; the angular momentum in space changes by kicks only, to rounding.
//
// The energy of rotation is split as L^2 / (2 I_r) + (1/I_p - 1/I_r) L_p^2 / 2 + (1/I_q - 1/I_r) L_q^2 / 2, r the axis
// of the middle moment. The first part turns the body about its fixed angular momentum and commutes with the others;
// they turn it about one axis of its own. Each is solved exactly, their composition (half p, q, half p) has an error of
// order two (Dullweber, Leimkuhler, McLachlan 1997), and none at all where two moments are equal.
#pragma once

#include "core/base/types.hpp"
#include "core/shapes/quaternion.hpp"

namespace talus::shapes {

/// Moments of inertia, prepared.
struct Rotor {
  Vec3 inverse;          ///< 1 / principal moments [1/(kg m2)]
  int p = 0, q = 2;      ///< axes of the corrections
  double reference = 1;  ///< 1 / middle moment
  double extra_p = 0, extra_q = 0;
};
/// Positive principal moments that satisfy the triangle inequality are the caller's to check.
Rotor make_rotor(Vec3 moments) noexcept;

struct RigidState {
  Vec3 x, v;        ///< centre of mass [m], [m/s]
  Quaternion turn;  ///< from the principal axes to space
  Vec3 l;           ///< angular momentum in the principal axes [kg m2/s]
};

/// Free rotation over dt [s]. The quaternion is normalised.
void rotate(Quaternion& turn, Vec3& l, const Rotor& rotor, double dt) noexcept;
/// Free flight and rotation over dt.
void drift(RigidState& s, const Rotor& rotor, double dt) noexcept;
/// Force [N] and torque about the centre [N m], both in space, act over dt.
void kick(RigidState& s, double inverse_mass, Vec3 force, Vec3 torque, double dt) noexcept;

/// [rad/s] in space.
Vec3 angular_velocity(const RigidState& s, const Rotor& rotor) noexcept;
/// Angular momentum about the centre in space [kg m2/s].
Vec3 angular_momentum(const RigidState& s) noexcept;
/// [J]
double rotation_energy(const RigidState& s, const Rotor& rotor) noexcept;
/// Velocity of the body at a point of space [m/s].
Vec3 velocity_at(const RigidState& s, const Rotor& rotor, Vec3 point) noexcept;

}  // namespace talus::shapes
