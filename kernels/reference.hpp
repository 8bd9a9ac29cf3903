// Scalar oracle of the contact laws, written to be read: vectors, one pair at a time, the formulae in the order of the
// papers. Who calls it: tests only. It shares no code with the kernels, so agreement means something.
#pragma once

#include "core/base/types.hpp"
#include "kernels/views.hpp"

namespace talus::reference {

/// Motion and geometry of one contact, oriented from j to i.
struct Pair {
  Vec3 xi, xj;            ///< centres [m]
  Vec3 vi, vj;            ///< velocities at n-1/2 [m/s]
  Vec3 wi, wj;            ///< spins at n-1/2 [rad/s]
  double ri = 0, rj = 0;  ///< radii [m]
  double mi = 0, mj = 0;  ///< masses [kg]; infinity for a fixed partner
};

struct Result {
  Vec3 force;               ///< on i [N]
  Vec3 torque_i, torque_j;  ///< [N m]
};

/// Linear spring-dashpot with friction (kernels/models/linear.hpp); `xi` is the tangential spring [m], `predicted` the
/// velocity that the last step predicts for the pair alone [m/s] where a.recall is set; both are updated.
Result linear(const Pair& p, const PairParameters& c, const LawArgs& a, bool friction, Vec3& xi, double& predicted);

/// Hertz-Mindlin (kernels/models/hertz_mindlin.hpp); `ft` is the elastic tangential force [N], `radius` the last
/// contact radius [m], both updated; `predicted` as above. `second`: the second part of the state of partial slip [N]
/// (kernels/models/partial_slip.hpp), updated; null: one spring for the whole contact.
Result hertz_mindlin(const Pair& p, const PairParameters& c, const LawArgs& a, bool friction, Vec3& ft, double& radius,
                     double& predicted, Vec3* second = nullptr);

/// History of rolling and twisting (kernels/models/moments.hpp), oriented from j to i.
struct MomentHistory {
  Vec3 rolling;                        ///< [N m]
  double twisting = 0, stiffness = 0;  ///< [N m], [N/m] of the last step
};

/// Moment on i (minus it on j) of a contact whose law gave the pressing force and `stiffness`; `h` is updated.
/// `slid`: how long the contact has moved in this step [s].
Vec3 moments(const Pair& p, double press, double stiffness, double slid, const AddOnParameters& c, const MomentArgs& a,
             MomentHistory& h);

/// JKR: normal force without dashpot [N] and contact radius [m] by bisection of the two equations of the paper.
struct JkrState {
  double force, radius;
};
JkrState jkr(double delta, double reff, double e_star, double w);

/// Attraction of SJKR [N]: energy density times the area of the disc in which two spheres (or a sphere and a plane)
/// intersect, from the height of the cap.
double sjkr(double distance, double ri, double rj, bool wall, double density);

}  // namespace talus::reference
