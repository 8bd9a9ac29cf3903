// The top of a scene file and the short sections: time, damping, checks, relax; and what several sections need.
#include "core/base/count.hpp"
#include "core/scene/sections/sections.hpp"

namespace talus {
namespace {

const Keys<Scene> k_top(
    {"", false, "keys at the top of the file, before the first section"}, k_acts,
    {
        key("title", &Scene::title, "a line for reports", "\"Hopper, 20k spheres\"").free(),
        key("seed", &Scene::seed, "-", {0, 9.2e18}, "seed of all random numbers", "42")
            .fixed("the sources draw from it")
            .also({"random_seed"}),
        key("gravity", &Scene::gravity, "m/s2", k_finite, "acceleration of gravity", "[0, 0, -9.81]")
            .fixed("it is part of the state; add an [[event]] with action = \"gravity\"")
            .also({"g", "gravity_vector"}),
        key("integrator", &Scene::integrator, "time integration", "\"leapfrog\"")
            .meaning({{"vv", "velocity_verlet"}, {"verlet", "velocity_verlet"}, {"leap_frog", "leapfrog"}})
            .fixed("it decides at which time the stored velocities hold"),
        key("precision", &Scene::precision,
            "exact: same bits on every processor; fast: fused and estimated operations, bits depend on the instruction "
            "set",
            "\"fast\"")
            .meaning({{"double", "exact"}, {"single", "fast"}, {"float", "fast"}, {"mixed", "fast"}}),
        key("sort_every", &Scene::sort_every, "steps", {1, k_count},
            "steps between two sorts of the storage order (part of the trajectory's definition)", "500"),
    });

const Keys<Scene> k_time({"time", false, "time step and length of the run (steps or duration)"}, k_free,
                         {
                             key("step", &Scene::dt, "s", k_positive, "time step", "1e-5")
                                 .required()
                                 .fixed("the stored velocities are half a step behind, and times count in steps")
                                 .also({"dt", "timestep", "time_step", "delta_t"}),
                             key("steps", &Scene::steps, "steps", k_counted,
                                 "length of the run in steps; either this or duration", "20000")
                                 .absent("(from duration)")
                                 .usual("", "duration")
                                 .also({"nsteps", "num_steps", "number_of_steps"}),
                             other_key<Scene>("duration", KeyType::number, "s", k_not_negative,
                                              "length of the run, rounded to whole steps; either this or steps", "0.5")
                                 .absent("(from steps)")
                                 .also({"end_time", "t_end", "total_time", "simulation_time"}),
                         });

const Keys<Scene> k_damping(
    {"damping", false, "background damping of all particles"}, k_acts,
    {
        key("viscous", &Scene::viscous_damping, "1/s", k_not_negative, "background drag c in a = -c v", "0.1"),
        key("local", &Scene::local_damping, "-", {0, 1},
            "non-viscous damping: share of the force taken off where it speeds a particle up, added where it slows it "
            "down",
            "0.3"),
    });

const Keys<Scene> k_checks(
    {"checks", false, "limits that warn or stop a run, and permissions to ignore them"}, k_free,
    {
        key("max_overlap", &Scene::max_overlap, "-", {0, 1, true}, "overlap / smaller radius that stops the run", "0.2")
            .also({{"overlap", "checks"}}),
        key("allow_initial_overlap", &Scene::allow_initial_overlap,
            "accept initial overlaps up to max_overlap (otherwise 0.05)", "true"),
        key("allow_unstable_step", &Scene::allow_unstable_step,
            "accept a time step above the packing limit, up to which the densest packing of such contacts is stable",
            "true"),
    });

const Keys<MonitorSettings> k_monitor(
    k_checks.section(), k_free,
    {
        key("warn_overlap", &MonitorSettings::warn_overlap, "-", k_positive, "overlap / smaller radius that warns",
            "0.05"),
        key("warn_travel", &MonitorSettings::warn_travel, "-", k_positive,
            "travel of a particle or wall in one step / radius that warns", "0.05"),
        key("max_travel", &MonitorSettings::max_travel, "-", k_positive,
            "travel in one step / radius that stops the run: beyond 1 a wall can be crossed unseen", "0.5"),
        key("warn_stiffness", &MonitorSettings::warn_stiffness, "-", k_positive,
            "step^2 times (sum of the stiffnesses of a particle's contacts / its mass) that warns, with what dashpots "
            "and tangential springs add. Surely stable up to 2; a full packing at the largest step that is accepted "
            "has 6. Normal springs alone are surely unstable from 12 on, which stops",
            "1"),
        key("warn_energy", &MonitorSettings::warn_energy, "-", k_positive,
            "energy balance residual / energy turned over that warns (with output.energies)", "0.01")
            .with("[output]\nenergies = true\n"),
        key("max_energy", &MonitorSettings::max_energy, "-", k_positive,
            "energy balance residual / energy turned over that stops the run (with output.energies)", "0.5")
            .absent("(never)")
            .with("[output]\nenergies = true\n"),
    });

const Keys<RelaxSettings> k_relax(
    {"relax", false, "limited-velocity relaxation of initial overlaps; off unless steps is given"},
    fixed_by("the run has begun under it"),
    {
        key("steps", &RelaxSettings::steps, "steps", k_counted,
            "first steps in which particles only leave their overlaps: no gravity, friction or inertia; initial "
            "velocities are dropped, and overlaps of any depth are accepted",
            "2000"),
        key("displacement", &RelaxSettings::displacement, "-", {0, 0.5, true},
            "largest displacement of a particle per relaxing step / its radius", "0.01")
            .beside("steps = 2000"),
    });

}  // namespace

const SectionKeys& top_keys() { return k_top; }
const SectionKeys& time_keys() { return k_time; }
const SectionKeys& damping_keys() { return k_damping; }
const SectionKeys& checks_keys() { return k_checks; }
const SectionKeys& monitor_keys() { return k_monitor; }
const SectionKeys& relax_keys() { return k_relax; }

void read_top(const SceneTable& r, Scene& scene) { k_top.read(r, scene); }

void read_time(const SceneTable& r, Scene& scene) {
  k_time.read(r, scene);
  r.exclusive("steps", "duration");
  if (r.has("steps")) return;
  if (!r.has("duration")) r.missing("steps", "(or time.duration)");
  const double steps = r.number("duration") / scene.dt;
  if (!(steps < 1e15)) r.fail("duration", "is more than 1e15 steps");
  scene.steps = count_nearest(steps);
}

void read_damping(const SceneTable& r, Scene& scene) { k_damping.read(r, scene); }

void read_checks(const SceneTable& r, Scene& scene) {
  k_checks.read(r, scene);
  k_monitor.read(r, scene.monitor);
  for (const char* name : {"warn_energy", "max_energy"})
    if (r.has(name) && !scene.output.energies) r.fail(name, "has no effect without output.energies = true");
}

void read_relax(const SceneTable& r, Scene& scene) {
  k_relax.read(r, scene.relax);
  if (r.has("displacement") && !r.has("steps")) r.fail("displacement", "has no effect without 'steps'");
}

void check_box(const SceneTable& r, Vec3 lower, Vec3 upper) {
  for (int k = 0; k < 3; ++k) {
    if (!(lower[k] < upper[k])) r.fail("upper", "must be above 'lower' on every axis");
  }
}

std::string unique_name(const SceneTable& r, const std::string& fallback, std::vector<std::string>& names) {
  const std::string name = r.has("name") ? r.text("name") : fallback;
  for (const std::string& other : names) {
    if (other != name) continue;
    if (r.has("name")) r.fail("name", "this name is taken; names must be unique");
    return unique_name(r, fallback + "_", names);
  }
  if (r.has("name") && name.empty()) r.fail("name", "must not be empty");
  names.push_back(name);
  return name;
}

}  // namespace talus
