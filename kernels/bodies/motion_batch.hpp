// Motion of many bodies at once, a body per lane. Who calls it: the integration of bodies, tests. Invariant (I4): each
// body gets the bits that the scalar motion of scheduler/nodes/body_motion.cpp gives it alone.
#pragma once

#include <cstdint>
#include <string_view>

namespace talus {

/// In and out: what the kernel takes of k_bodies bodies and their spheres, and what it leaves. The caller fills the
/// lanes; those without a body repeat what lies there.
struct MotionBatch {
  static constexpr int k_bodies = 16;   ///< two batches of the widest set: a lane is written well before it is read
  static constexpr int k_spheres = 32;  ///< of a body, at most; larger bodies are moved one by one
  using Lane = double[k_bodies];

  /// One sphere of each body.
  struct Sphere {
    Lane place[3];     ///< in the principal axes, at scale 1 [m]
    Lane radius;       ///< at scale 1 [m]
    Lane force[3];     ///< [N]
    Lane stiffness;    ///< sum over the contacts [N/m]
    Lane torque[3];    ///< torque over its radius [N]
    Lane at[3];        ///< out: centre at n+1, not wrapped [m]
    Lane velocity[3];  ///< out: chord of its way over the step [m/s]
  };

  alignas(64) Lane x[3];     ///< in: at n; out: at n+1, not wrapped [m]
  Lane v[3];                 ///< in: at n-1/2; out: at n+1/2 [m/s]
  Lane turn[4];              ///< quaternion w, x, y, z at n; out: at n+1
  Lane spin[3];              ///< angular momentum in the principal axes at n-1/2; out: at n+1/2 [kg m2/s]
  Lane scale, mass;          ///< [-], [kg]
  Lane inverse_mass;         ///< 1/m [1/kg]; positive
  Lane inverse[3];           ///< 1 / principal moments per mass at scale 1 [1/m2]
  Lane reference;            ///< as shapes::Rotor, like the next four
  Lane extra_p, extra_q;     ///<
  Lane axis_p, axis_q;       ///< 0, 1 or 2
  Lane angular_velocity[3];  ///< out: mean of both ends, in space [rad/s]
  Lane row;                  ///< out: summed stiffness over the mass [1/s2]
  Lane wide;                 ///< out: 1 where the body turns too far in a step for the kernel: its results mean nothing
  Sphere sphere[k_spheres];
  std::int32_t bodies = 0;                ///< that are in
  std::int32_t spheres = 0;               ///< of the largest of them; smaller ones bring zero forces behind their own
  std::int32_t rotation = 0;              ///< forces have torques
  double dt = 0, kick = 0, per_step = 0;  ///< step, time over which forces act [s], 1/dt [1/s]
  double gravity[3] = {};                 ///< [m/s2]
};

/// Kick, drift and free rotation of the bodies that are in.
using BodyMover = void (*)(MotionBatch& batch);

/// The mover of an instruction set: scalar, sse2, avx2, avx512. nullptr for another name. The caller has seen to it
/// that the processor has it (available_isas()).
BodyMover body_mover(std::string_view isa) noexcept;

}  // namespace talus
