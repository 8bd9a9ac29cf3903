// Contact of two superquadrics: normal, overlap and point, whatever it takes. Who calls it: contacts of grains, walls
// made of segments and points. Invariants: I4; no pair is given up: what Newton's method does not solve from the
// history is solved along the path from the line of centres, then by a search over all directions; each way is counted.
#pragma once

#include <cstdint>

#include "core/base/types.hpp"
#include "core/shapes/pair_newton.hpp"
#include "core/shapes/quaternion.hpp"
#include "core/shapes/superquadric.hpp"

namespace talus::shapes {

/// A body in contact: what is known before the step, and where it is.
struct Body {
  DualForm<Plain> form;
  double size = 0;       ///< largest semi-axis [m]
  double roundness = 0;  ///< smallest radius of curvature [m]
  Vec3 centre;           ///< [m]
  Rotation turn;
};
Body make_body(const Superquadric& s, double roundness, Vec3 centre, Quaternion q) noexcept;

/// The normal of the last step in the frame of body i; part of the state of a contact.
struct PairMemory {
  Vec3 normal;
  bool known = false;
};

/// From i to j; overlap < 0: apart by at least so much [m]. The point lies midway between the two surfaces.
struct PairContact {
  Vec3 normal;
  double overlap = 0;
  Vec3 point;         ///< in space [m]
  bool deep = false;  ///< deeper than the bodies are round: the least overlap was searched over all directions
};

/// How pairs were solved, and the largest number of iterations.
struct PairCount {
  std::int64_t pairs = 0, from_memory = 0, along_path = 0, with_care = 0, searched = 0, bracketed = 0, deep = 0;
  std::int64_t evaluations = 0, most_evaluations = 0;
};

/// The pair in the frame of i.
PairForm<Plain> pair_form(const Body& i, const Body& j) noexcept;

/// delta = min over unit n of h_i(n) + h_j(-n) - n . (x_j - x_i), its n and the point. Pairs farther apart than `range`
/// [m] are left as soon as that is seen. Overlap within 1e-12 and normal within 1e-8 of the bodies rounded by k_eta,
/// lengths relative to the larger body.
PairContact solve_pair(const Body& i, const Body& j, PairMemory& memory, PairCount& count, double range = 0) noexcept;

}  // namespace talus::shapes
