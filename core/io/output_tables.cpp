// See output_tables.hpp.
#include "core/io/output_tables.hpp"

#include <algorithm>

namespace talus {
namespace {

constexpr OutputFile k_files[] = {
    {"scene.toml", "", "copy of the scene; comments at its end say how it was run"},
    {"summary.json", "", "figures of the run: status, sizes, rate, warnings, meshes, state_hash"},
    {"checkpoint-<N>.tcp", "output.checkpoint_wall",
     "state after step N, for --resume; the newest two are kept, and a run ends with one"},
    {"series.csv", "output.csv_every", "the time series, a row per interval"},
    {"particles.pvd", "output.particles_every", "list of the particle frames: open this one in ParaView"},
    {"walls.pvd", "output.particles_every", "the same for walls; cell column wall: number of the wall, from 0"},
    {"contacts.pvd", "output.contacts", "the same for contacts, a point each"},
    {"grid.pvd", "output.grid", "the same for averages on a grid"},
    {"vtp/{particles,walls,contacts}-<N>.vtp", "output.vtp", "frame of step N"},
    {"vtp/grid-<N>.vti", "output.grid", "averages on a grid at step N"},
    {"{particles,walls,contacts}.vtkhdf", "output.vtkhdf", "all frames in one file, for ParaView 5.12 or newer"},
    {"report.html", "", "what `talus report` makes of the folder"},
    {"trace.json", "", "where --trace names it: steps for ui.perfetto.dev"},
    {"failed.tcp", "", "the last state of a run that the physics ended (exit code 4)"},
    {"failed.vtp", "", "its particles"},
    {"failed_near.csv", "", "those near the ones that the failure names, with what each touches"},
    {"run.lock", "", "marks the folder while a run writes into it, and as one of a run"},
    {"{scene,series,particles,walls,contacts,grid}-until-<N>.{toml,csv,vtkhdf,pvd}", "",
     "what was written before a resume at step N with another scene"},
};

constexpr std::string_view k_sum = "sum", k_mean = "mean", k_moment = "moment";

constexpr OutputColumn k_series[] = {
    {"step", "-", k_moment, "number of executed steps"},
    {"time", "s", k_moment, "simulated time, step * time.step"},
    {"particles", "-", k_moment, "grains in the domain"},
    {"kinetic_energy", "J", k_moment, "of translation, in the frame of the domain"},
    {"contacts", "-", k_moment, "touching pairs of grains in the last executed step"},
    {"wall_contacts", "-", k_moment, "contacts of grains with walls in the last executed step"},
    {"coordination_number", "-", k_moment, "2 contacts / particles; walls do not count"},
    {"inserted", "-", k_sum, "grains that sources have brought"},
    {"removed", "-", k_sum, "grains that left through open sides or were removed by events"},
    {"removed_mass", "kg", k_sum, "their mass"},
    {"mass_flow", "kg/s", k_mean, "of removed_mass since the row before"},
    {"kinetic_translation", "J", k_moment, "half the sum of m v^2"},
    {"kinetic_rotation", "J", k_moment, "half the sum of I w^2"},
    {"potential", "J", k_moment,
     "of gravity, by height above the coordinate origin; along periodic axes minus its work since the start"},
    {"elastic", "J", k_moment, "in the springs of all contacts"},
    {"dissipated_damping", "J", k_sum, "by the dashpots of contacts; positive is lost"},
    {"dissipated_friction", "J", k_sum, "by sliding; positive is lost"},
    {"dissipated_background", "J", k_sum, "by [damping]; positive is lost"},
    {"wall_work", "J", k_sum, "done by moving walls and driven grains on the others; positive is put in"},
    {"inserted_energy", "J", k_sum, "kinetic and potential energy that sources, events and open sides brought in"},
    {"balance_residual", "J", k_sum,
     "kinetic + potential + elastic + dissipated - wall_work - inserted_energy, less its value at the start"},
    {"wall.<wall>.force_{x,y,z}", "N", k_moment, "of all grains on the wall"},
    {"wall.<wall>.torque_{x,y,z}", "N m", k_moment,
     "of all grains on the wall where the scene has it, about the coordinate origin"},
    {"plane.<plane>.particles", "-", k_sum, "passages of centres along the normal less those against it"},
    {"plane.<plane>.mass", "kg", k_sum, "the same of their masses"},
    {"plane.<plane>.particle_flow", "1/s", k_mean, "of plane.<plane>.particles since the row before"},
    {"plane.<plane>.mass_flow", "kg/s", k_mean, "of plane.<plane>.mass since the row before"},
    {"region.<region>.particles", "-", k_moment,
     "grains, those partly inside by their share of volume inside; the same weight in all averages"},
    {"region.<region>.solid_fraction", "-", k_moment, "volume of grains inside / volume of the region"},
    {"region.<region>.velocity_{x,y,z}", "m/s", k_moment, "mean velocity of the grains, weighted by mass"},
    {"region.<region>.granular_temperature", "m2/s2", k_moment,
     "a third of the mean square of velocities about their mean, weighted by mass"},
    {"region.<region>.coordination", "-", k_moment, "mean over grains of the column coordination of frames"},
    {"region.<region>.stress_{xx,yy,zz,xy,xz,yz}", "Pa", k_moment,
     "sum of the stress of grains times their volume inside / volume of the region"},
};

constexpr OutputColumn k_particles[] = {
    {"id", "-", "", "number of the grain, in the order of its creation; never used again"},
    {"velocity", "m/s", "", "half a step before the frame's time"},
    {"radius", "m", "", "of the grain"},
    {"diameter", "m", "", "twice the radius, for glyphs that want it"},
    {"omega", "rad/s", "", "angular velocity; with friction only"},
    {"material", "-", "", "number of the material, from 0; with several only"},
    {"fixed", "-", "", "1 where the grain is held or driven; where groups or events can do so"},
    {"coordination", "-", "", "contacts of the grain (output.coordination)"},
    {"stress", "Pa", "", "XX YY ZZ XY YZ XZ, sum over contacts of force times branch / volume (output.stress)"},
};

constexpr OutputColumn k_contacts[] = {
    {"particle_a", "-", "", "id of the grain on which the forces act"},
    {"particle_b", "-", "", "id of the other grain; -1 - n for wall number n"},
    {"normal_force", "N", "", "on particle_a, along the normal"},
    {"tangential_force", "N", "", "on particle_a, across the normal"},
    {"overlap", "m", "", "depth of the contact"},
};

bool is_digits(std::string_view s) {
  return !s.empty() && std::all_of(s.begin(), s.end(), [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

std::span<const OutputFile> output_files() noexcept { return k_files; }
std::span<const OutputColumn> series_columns() noexcept { return k_series; }
std::span<const OutputColumn> frame_columns() noexcept { return k_particles; }
std::span<const OutputColumn> contact_columns() noexcept { return k_contacts; }

bool fits(std::string_view pattern, std::string_view name) {
  if (pattern.empty()) return name.empty();
  if (pattern.front() == '<') {
    const std::size_t close = pattern.find('>');
    const std::string_view rest = pattern.substr(close + 1);
    const bool number = pattern.substr(0, close + 1) == "<N>";
    for (std::size_t n = name.size(); n > 0; --n)  // names of users may hold anything
      if ((!number || is_digits(name.substr(0, n))) && fits(rest, name.substr(n))) return true;
    return false;
  }
  if (pattern.front() == '{') {
    const std::size_t close = pattern.find('}');
    const std::string_view rest = pattern.substr(close + 1);
    for (std::string_view words = pattern.substr(1, close - 1);;) {
      const std::size_t comma = words.find(',');
      const std::string_view word = words.substr(0, comma);
      if (name.starts_with(word) && fits(rest, name.substr(word.size()))) return true;
      if (comma == std::string_view::npos) return false;
      words.remove_prefix(comma + 1);
    }
  }
  return !name.empty() && name.front() == pattern.front() && fits(pattern.substr(1), name.substr(1));
}

}  // namespace talus
