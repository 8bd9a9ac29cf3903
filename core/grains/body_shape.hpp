// A shape of a scene as bodies are made of it: spheres about the centre of mass in the principal axes, at scale 1. A
// superquadric is one sphere, that which holds it: broad phase, sources and motion need no more of it. Who makes it:
// load_shape(), when a scene is read. Who reads it: sources, the engine's bodies. Invariant (I4): a function of what
// the scene says of the shape alone.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/types.hpp"
#include "core/scene/scene.hpp"
#include "core/shapes/clump.hpp"
#include "core/shapes/rigid_motion.hpp"
#include "core/shapes/superquadric.hpp"

namespace talus {

/// What contacts need of a superquadric at scale 1.
struct QuadricShape {
  shapes::Superquadric surface;
  shapes::DualForm<shapes::Plain> form;
  double size = 0;       ///< largest semi-axis [m]
  double roundness = 0;  ///< smallest radius of curvature [m]
  double flat = 0;       ///< see shapes::hertz_radius() [m]
  bool ball = false;     ///< a sphere: its contacts are those of spheres, without a solver
};

struct BodyShape {
  std::vector<shapes::SubSphere> spheres;  ///< in the principal axes, from the centre of mass [m]
  int hidden = 0;                          ///< spheres of the scene that lie within others: left out
  double volume = 0;                       ///< of the union [m3]
  double density = 0;                      ///< [kg/m3]; 0: that of the material
  double equal_radius = 0;                 ///< of the sphere of equal volume [m]
  double bound = 0;                        ///< radius of the sphere about the centre that holds all [m]
  double smallest = 0, largest = 0;        ///< radii of its spheres; smallest: of a superquadric that within it [m]
  double roundest = 0;                     ///< largest radius with which it meets others [m]
  shapes::Rotor rotor;                     ///< of the moments of inertia per mass [m2]
  Vec3 moments;                            ///< principal, per mass [m2]
  shapes::Quaternion turn;                 ///< from the principal axes to the axes that it is given in
  double lightness = 1;                    ///< m times the largest 1/m + (r x n) I^-1 (r x n) of a force on it
  std::optional<QuadricShape> quadric;     ///< else a clump

  double density_of(const Material& m) const noexcept { return density > 0 ? density : m.density; }
  double mass(const Material& m, double scale) const noexcept {
    return density_of(m) * volume * (scale * scale * scale);
  }
};

/// Sets spec.body. `directory`: base of a relative file. Error{scene} naming file or shape: a table that cannot be
/// read, a sphere that is none, an inertia that no body can have.
void load_shape(ShapeSpec& spec, const std::string& directory);

/// Sources of bodies that name no size get that of scale 1, where their shape has been read.
void set_natural_sizes(Scene& scene);
/// Radius of the smallest and largest sphere of a source's bodies over that of the sphere of equal volume; 1 for
/// spheres. The smallest of superquadrics is the sphere within them.
double smallest_share(const Scene& scene, std::size_t source);
double largest_share(const Scene& scene, std::size_t source);

/// Some source makes bodies, or superquadrics. A file may hold any of the scene's shapes.
bool makes_bodies(const Scene& scene);
bool makes_superquadrics(const Scene& scene);

/// Turn of body `number` of a source from the principal axes to space: a function of the seed and these numbers.
shapes::Quaternion first_turn(const Scene& scene, std::size_t source, std::int64_t number);

}  // namespace talus
