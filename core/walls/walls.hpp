// Walls: rigid surfaces made of elements (plane, lateral surface of revolution, triangle), their motion and the
// geometry of particle-wall contacts. A contact is reduced to point, distance and wall velocity; the contact law
// treats it as a partner of radius 0 and infinite mass. Who calls it: scheduler/ (rebuild and wall_contact nodes).
// Invariants: I1 (candidates complete), I2 (travel against the stored wall skin), I3 (contacts ordered by wall id,
// element id), I4 (pose is a function of the step number; + - * / sqrt only, sin/cos from core/base/det_math.hpp).
// On a periodic axis every wall acts through the sides as in the middle: a contact is one with an element of one of its
// images (core/walls/wall_images.hpp). Planes must be their own image. Where images of a wall overlap they are one
// solid: surfaces that coincide count once.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/base/types.hpp"
#include "core/scene/scene.hpp"

namespace talus {

struct MeshReport;  // core/meshes/mesh_file.hpp

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
  Vec3 centre;               ///< the particle's centre as the wall itself has it, not the image that is touched [m]
};

/// An element as bodies that are no spheres meet it, at its present pose in the frame of the particles.
struct WallPiece {
  enum class Kind : std::uint8_t { none, plane, triangle, cylinder };
  std::int32_t wall = 0, element = 0;
  Kind kind = Kind::none;
  Vec3 corner[3];     ///< of a plane or an axis: [0] is a point of it [m]
  Vec3 normal;        ///< unit, either side; of a plane; of a cylinder its axis
  double radius = 0;  ///< of a cylinder, whose ends no body reaches [m]
  Vec3 shift;         ///< of the image [m]
  double slack = 0;   ///< corners are known this well [m]
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
  /// Facets, edges and corners that one particle touches before they are shared out to contacts; more is
  /// Error{physics}.
  static constexpr int k_max_touches = 64;
  /// By how many periods a particle was wrapped along each axis.
  using Wraps = std::array<int, 3>;

  WallSet();
  /// Builds all elements; loads meshes relative to scene.directory. Sides of the domain with Boundary::wall become
  /// plane walls named "domain_x_lower" ... after the scene's own walls. `max_reach` [m]: the largest R_NL (radius +
  /// capped skin + wall skin) that candidates() will ever be asked for (sizes the facet grid). `usual_reach` [m]: what
  /// most calls stay below, 0: no grid of its own for it. Errors: Error{scene} for a broken mesh or impossible
  /// geometry, with file and facet, and for a plane that a periodic axis crosses.
  WallSet(const Scene& scene, double max_reach, double usual_reach = 0);
  ~WallSet();
  WallSet(WallSet&&) noexcept;
  WallSet& operator=(WallSet&&) noexcept;
  WallSet(const WallSet&);
  WallSet& operator=(const WallSet& o) { return *this = WallSet(o); }

  int size() const noexcept;         ///< number of walls (0: scene needs no wall arrays or nodes)
  bool any_moving() const noexcept;  ///< some wall moves, appears or vanishes at some time
  bool has_images() const noexcept;  ///< some wall can be touched through a periodic side
  /// Images of a wall that can act in the domain, the wall itself among them, and how far each is from it [m].
  int image_count(int wall) const;
  Vec3 image_shift(int wall, int image) const;
  const std::string& name(int wall) const;
  int material(int wall) const;
  /// Walls of one material that move alike form one surface: the first of them.
  int surface(int wall) const;
  std::int64_t element_count() const noexcept;
  std::size_t bytes() const noexcept;
  /// Name and what was found of every mesh wall; bounds in the frame of the scene.
  std::vector<std::pair<std::string, MeshReport>> meshes() const;

  /// Sets the pose of every wall to step n: positions at t_n = n*dt, velocities such that the displacement over the
  /// step [n-1, n] equals velocity*dt (mid-step velocity, consistent with leapfrog particle velocities).
  /// Error{physics} for a wall that has gone a million periods.
  void set_step(std::int64_t n, double dt);
  const WallPose& pose(int wall) const;
  void act(int wall, bool active);  ///< whatever its schedule says, until the next set_step()

  /// Remembers the present poses as those of a rebuild and stores each wall's skin [m] =
  /// min(max(K * fastest vertex speed * dt, floor), cap); a wall that never moves has skin 0.
  void mark(double k, double dt, double floor, double cap);
  double skin(int wall) const;
  /// True if some wall's fastest vertex travel since mark() exceeds its stored skin, or its activity changed.
  bool expired() const;

  /// Appends the candidates of centre c: codes of all elements of active walls, images included, within radius +
  /// skin_particle + skin(wall) of it, wall after wall. Without periodic axes a code is the element's id, and they
  /// ascend. `reach` = radius + skin_particle, below max_reach on periodic axes. `distance`: also appends a lower bound
  /// of the distance of each [m]. Thread-safe (const).
  void candidates(Vec3 c, double reach, std::vector<std::int32_t>& out, std::vector<float>* distance = nullptr) const;
  /// The same by asking every image instead of those that can be near: for audits.
  void audit_candidates(Vec3 c, double reach, std::vector<std::int32_t>& out) const;
  /// Largest speed of a wall's points that particles can touch, over the scene's whole run: translation, rotation and
  /// the peak of its vibration within the schedule [m/s].
  double fastest_point(int wall) const;
  /// Largest distance that such a point has gone in the last step, and the wall [m].
  struct StepTravel {
    double distance = 0;
    int wall = -1;
  };
  StepTravel step_travel() const;
  /// How much nearer a wall can have come since mark() to a point at rest [m]: the largest of all walls.
  double largest_travel() const noexcept;

  /// Exact closest points of the candidates at the present pose, kept where distance < radius, reduced
  /// (face > edge > vertex; a feature at or behind the tangent plane of a nearer contact belongs to the same surface),
  /// ordered by (wall, element, distance of the image). `wraps`: by which c was wrapped since they were listed. Returns
  /// the count (<= k_max_contacts). Thread-safe.
  int contacts(Vec3 c, double radius, std::span<const std::int32_t> candidates, WallContact* out,
               const Wraps& wraps = {}) const;

  /// Error{physics}: more than `most` contacts or touches of a particle at c.
  [[noreturn]] void refuse_touches(double radius, Vec3 c, int most) const;

  /// The candidates of centre c as planes, triangles and cylinders; those of walls that do not act now, and of walls
  /// that are none of them, are left out.
  void pieces(Vec3 c, std::span<const std::int32_t> candidates, std::vector<WallPiece>& out,
              const Wraps& wraps = {}) const;
  /// Velocity of a point of a wall at the mid-step n-1/2 [m/s].
  Vec3 velocity(int wall, Vec3 point) const;

  /// For each of `now` the index of its predecessor in `before`, or -1: same element of the same image first, then
  /// within the same wall the unmatched one with the closest normal (cosine > 0.9): history passes to the adjoining
  /// facet, also through a periodic side.
  void match(std::span<const WallContact> before, std::span<const WallContact> now, std::int32_t* from) const;

  /// Surfaces at the present pose, for output: of all images that reach into the domain.
  std::vector<WallSurface> surfaces() const;
  /// Area of a wall at the present pose, whether it acts or not: of the wall itself, not of its images; of a plane what
  /// lies in the domain [m2].
  double area(int wall) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The scene with its domain and walls moved so that the domain's lower corner is the origin. The engine's walls live
/// in this frame, that of the stored positions: a scene keeps its bits wherever its domain lies (DESIGN 2).
Scene in_stored_frame(const Scene& scene);

}  // namespace talus
