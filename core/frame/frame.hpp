// Frame: one snapshot of a run, in id order, as every writer, report and comparison sees it.
// Who fills it: scheduler/simulation.cpp. Who reads it: core/io writers, cases/. Columns that the scene does not have
// are empty (DESIGN 4d).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/types.hpp"
#include "core/walls/walls.hpp"

namespace talus {

/// One touching pair or particle-wall contact.
struct ContactRecord {
  ParticleId a = 0;
  ParticleId b = 0;       ///< partner id; for walls -1 - wall index
  Vec3 point;             ///< [m]
  Vec3 normal_force;      ///< on a [N]
  Vec3 tangential_force;  ///< on a [N]
  double overlap = 0;     ///< [m]
};

struct WallLoad {
  Vec3 force;   ///< on the wall [N]
  Vec3 torque;  ///< on the wall where the scene has it, about the coordinate origin [N m]
};

/// Energies at step n [J]; the balance residual is (kinetic + potential + elastic + dissipated - work - inserted -
/// sizes) - its value at the start.
struct Energies {
  /// Potential: along periodic axes minus the work of gravity since the start, elsewhere by height.
  double kinetic_translation = 0, kinetic_rotation = 0, potential = 0, elastic = 0;
  double dissipated_damping = 0, dissipated_friction = 0, dissipated_background = 0;
  double wall_work = 0;  ///< done by moving walls, driven particles and gas on the grains
  double inserted = 0;   ///< kinetic + potential energy brought in minus taken out by sources, removals, events
  double residual = 0;
  double sizes = 0;  ///< what changing radii and masses of grains have brought in: elastic, kinetic, potential
};

/// A body of several spheres.
struct BodyRecord {
  ParticleId id = 0;                              ///< that of its first sphere
  std::int32_t shape = 0;                         ///< index into scene.shapes
  double scale = 1, mass = 0;                     ///< mass [kg]
  Vec3 x, v, w;                                   ///< of the centre of mass [m], [m/s] (at n-1/2), [rad/s]
  std::array<double, 4> orientation{1, 0, 0, 0};  ///< quaternion w, x, y, z from the axes of the [[shape]] to space
  Vec3 semi_axes;                                 ///< of a superquadric [m]; 0: a clump
  std::array<double, 2> exponents{0, 0};          ///< n1, n2
};

/// A per-grain column of an optional part.
struct ExtraColumn {
  std::string name, unit;
  std::vector<double> values;
};

struct Frame {
  std::int64_t step = 0;
  double time = 0;  ///< [s]
  std::vector<ParticleId> id;
  std::vector<Vec3> x, v;                     ///< [m], [m/s] (velocity at n-1/2)
  std::vector<Vec3> w;                        ///< [rad/s]; empty without rotation
  std::vector<double> r;                      ///< [m]
  std::vector<double> mass;                   ///< [kg]; empty where it follows from radius and density
  std::vector<std::uint8_t> material;         ///< empty with one material
  std::vector<std::uint8_t> fixed;            ///< empty where nothing is fixed
  std::vector<std::int32_t> coordination;     ///< on request
  std::vector<std::array<double, 6>> stress;  ///< on request: xx yy zz xy xz yz [Pa], sum over contacts of f l / volume
  std::vector<ExtraColumn> extra;             ///< of optional parts, in the order of their list
  std::vector<BodyRecord> bodies;             ///< in id order; particles are their spheres
  bool bodies_missing = false;                ///< of a file beside which theirs is not there
  std::vector<ContactRecord> contacts;        ///< on request
  std::vector<ExtraColumn> contact_extra;     ///< the same of contacts; a value per entry of `contacts`
  std::vector<WallSurface> walls;             ///< current pose; empty without walls
  std::vector<WallLoad> wall_loads;
};

}  // namespace talus
