// Walls: rigid surfaces made of elements (plane, lateral surface of revolution, triangle), their motion and the
// geometry of particle-wall contacts. A contact is reduced to point, distance and wall velocity; the contact law
// treats it as a partner of radius 0 and infinite mass. Who calls it: scheduler/ (rebuild and wall_contact nodes).
// Invariants: I1 (candidates complete), I2 (travel against the stored wall skin), I3 (contacts ordered by wall id,
// element id), I4 (pose is a function of the step number; + - * / sqrt only, sin/cos from core/det_math.hpp).
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/scene.hpp"
#include "core/types.hpp"

namespace talus {

/// Pose of one wall at one step: x_world = rotation * (x_body - origin) + origin + translation.
struct WallPose {
  Vec3 translation, origin;
  std::array<double, 9> rotation{1, 0, 0, 0, 1, 0, 0, 0, 1};
  Vec3 velocity;         ///< of the point `origin + translation` [m/s]
  Vec3 omega;            ///< [rad/s]
  bool rotated = false;  ///< rotation differs from identity
  bool moving = false;   ///< velocity or omega non-zero at this step
  bool active = true;    ///< within [appear, vanish)
};

/// One reduced particle-wall contact (or near-contact).
struct WallContact {
  std::int32_t wall = 0;
  std::int32_t element = 0;  ///< global element id (ascending with the wall id)
  Vec3 normal;               ///< unit, from the wall to the particle centre
  double distance = 0;       ///< centre to contact point [m]
  Vec3 velocity;             ///< wall velocity at the contact point at the mid-step n-1/2 [m/s]
};

/// Triangulated surface for output and reports; primitives are tessellated, infinite planes are clipped to the domain.
struct WallSurface {
  std::string name;
  std::vector<Vec3> points;
  std::vector<std::array<std::int32_t, 3>> triangles;
};

class WallSet {
 public:
  static constexpr int k_max_contacts = 16;  ///< simultaneous wall contacts of one particle; more is Error{physics}

  WallSet();
  /// Builds all elements; loads meshes relative to scene.directory. Sides of the domain with Boundary::wall become
  /// plane walls named "domain_x_lower" ... after the scene's own walls. `max_reach` [m]: the largest R_NL (radius +
  /// capped skin + wall skin) that candidates() will ever be asked for (sizes the facet grid). `usual_reach` [m]: what
  /// most calls stay below, 0: no grid of its own for it. Errors: Error{scene} for a broken mesh or impossible
  /// geometry, with file and facet.
  WallSet(const Scene& scene, double max_reach, double usual_reach = 0);
  ~WallSet();
  WallSet(WallSet&&) noexcept;
  WallSet& operator=(WallSet&&) noexcept;
  WallSet(const WallSet&);
  WallSet& operator=(const WallSet& o) { return *this = WallSet(o); }

  int size() const noexcept;         ///< number of walls (0: scene needs no wall arrays or nodes)
  bool any_moving() const noexcept;  ///< some wall moves, appears or vanishes at some time
  const std::string& name(int wall) const;
  int material(int wall) const;
  std::int64_t element_count() const noexcept;
  std::size_t bytes() const noexcept;

  /// Sets the pose of every wall to step n: positions at t_n = n*dt, velocities such that the displacement over the
  /// step [n-1, n] equals velocity*dt (mid-step velocity, consistent with leapfrog particle velocities).
  void set_step(std::int64_t n, double dt);
  const WallPose& pose(int wall) const;

  /// Remembers the present poses as those of a rebuild and stores each wall's skin [m] =
  /// min(max(K * fastest vertex speed * dt, floor), cap); a wall that never moves has skin 0.
  void mark(double k, double dt, double floor, double cap);
  double skin(int wall) const;
  /// True if some wall's fastest vertex travel since mark() exceeds its stored skin, or its activity changed.
  bool expired() const;

  /// Appends, ascending, the ids of all elements of active walls within radius + skin_particle + skin(wall) of centre
  /// c. `reach` = radius + skin_particle. `distance`: also appends a lower bound of the distance of each [m].
  /// Thread-safe (const).
  void candidates(Vec3 c, double reach, std::vector<std::int32_t>& out, std::vector<float>* distance = nullptr) const;
  /// How much nearer a wall can have come since mark() to a point at rest [m]: the largest of all walls.
  double largest_travel() const noexcept;

  /// Exact closest points of the candidate elements at the present pose, kept where distance < radius, reduced
  /// (face > edge > vertex; a feature at or behind the tangent plane of a nearer contact belongs to the same surface),
  /// ordered by (wall, element). Returns the count (<= k_max_contacts). Thread-safe.
  int contacts(Vec3 c, double radius, std::span<const std::int32_t> elements, WallContact* out) const;

  /// For each of `now` the index of its predecessor in `before`, or -1: same element first, then within the same wall
  /// the unmatched one with the closest normal (cosine > 0.9): history passes to the adjoining facet.
  static void match(std::span<const WallContact> before, std::span<const WallContact> now, std::int32_t* from);

  /// Surfaces at the present pose, for output.
  std::vector<WallSurface> surfaces() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The scene with its domain and walls moved so that the domain's lower corner is the origin. The engine's walls live
/// in this frame, that of the stored positions: a scene keeps its bits wherever its domain lies (DESIGN 2).
Scene in_stored_frame(const Scene& scene);

}  // namespace talus
