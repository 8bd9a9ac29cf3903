// Scenes for the physics tests, built in the program: particles given as vectors travel through a temporary CSV file,
// so that the tests run the same path as a user's initial state. Who calls it: tests/physics only. Invariants: numbers
// are written with 17 digits (bits survive the file); temporary files vanish with the process.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/scene/scene.hpp"
#include "scheduler/simulation.hpp"

namespace talus::physics {

inline constexpr double k_pi = 3.14159265358979323846;

struct Grain {
  Vec3 x, v;  ///< [m], [m/s]
  double r = 0.5;
  Vec3 w{0, 0, 0};  ///< [rad/s]
  int material = 0;
  bool fixed = false;
};

/// Scene with one material (density 2500) and open sides; no gravity, no contact law yet.
Scene open_scene(Vec3 lower, Vec3 upper, double dt);
/// Adds the grains as a file source.
void add_grains(Scene& scene, const std::vector<Grain>& grains);
/// Linear law given by rates [1/s].
void linear_law(Scene& scene, double kn, double gn, double kt = 0, double gt = 0, double mu = 0);
/// Linear law given by restitution; no tangential force unless kt > 0.
void linear_restitution(Scene& scene, double kn, double e, double kt = 0, double mu = 0);
/// Hertz-Mindlin for the materials of the scene, one restitution and friction for all pairs.
void hertz_law(Scene& scene, double e, double mu);
/// Plane through `point` with `normal` towards the particles.
WallSpec plane(const std::string& name, Vec3 point, Vec3 normal, int material = 0);

/// OBJ file of a flat floor z = 0 of nx by ny squares, two triangles each; returns its path.
std::string flat_mesh(double x0, double x1, double y0, double y1, int nx, int ny);

/// OBJ file of the given points and facets (from 0); returns its path.
std::string mesh_file(const std::vector<Vec3>& points, const std::vector<std::array<int, 3>>& facets);

double sphere_mass(double density, double r);
/// One thread and the default instruction set: these scenes are small.
RunOptions options();

/// Value at share q of the sorted sample, q in [0, 1].
double quantile(std::vector<double> values, double q);
/// Least-squares slope of ln y over ln x.
double log_slope(const std::vector<double>& x, const std::vector<double>& y);
/// Prints and records a measured figure; `ctest -V -R Physics` shows the lines.
void figure(const std::string& name, double value, const std::string& note = {});
/// Uniform number in [0, 1) of draw k; the same on every machine.
double uniform(std::uint64_t seed, std::uint64_t k);

}  // namespace talus::physics
