// The tables; see series_columns.hpp.
#include "core/io/series_columns.hpp"

namespace talus {
namespace {

using Row = SeriesAt<SeriesRow>;
using Wall = SeriesAt<WallLoad>;
using Plane = SeriesAt<PlaneTotal>;
constexpr std::string_view k_sum = "sum", k_mean = "mean", k_moment = "moment";

template <auto Member>
SeriesValue of(const Row& at) {
  return at.now.*Member;
}
template <double Energies::*Member>
SeriesValue energy(const Row& at) {
  return at.now.energies.*Member;
}
template <Vec3 WallLoad::*Member>
SeriesValue load(const Wall& at) {
  return at.now.*Member;
}

bool has_sources(const SeriesLayout& l) { return l.inserted; }
bool has_walls(const SeriesLayout& l) { return l.wall_contacts; }
bool has_superquadrics(const SeriesLayout& l) { return l.superquadrics; }
bool has_energies(const SeriesLayout& l) { return l.energies; }
bool has_sizes(const SeriesLayout& l) { return l.energies && l.sizes; }
bool has_rotation(const SeriesLayout& l) { return l.energies && l.rotation; }
bool has_friction(const SeriesLayout& l) { return l.energies && l.friction; }

// clang-format off
constexpr SeriesQuantity<SeriesRow> k_run[] = {
    {"step", "-", k_moment, "number of executed steps", of<&SeriesRow::step>},
    {"time", "s", k_moment, "simulated time, step * time.step", of<&SeriesRow::time>},
    {"particles", "-", k_moment, "grains in the domain", of<&SeriesRow::particles>},
    {"kinetic_energy", "J", k_moment, "of translation, in the frame of the domain", of<&SeriesRow::kinetic_energy>},
    {"contacts", "-", k_moment, "touching pairs of grains in the last executed step", of<&SeriesRow::contacts>},
    {"wall_contacts", "-", k_moment, "contacts of grains with walls in the last executed step",
     of<&SeriesRow::wall_contacts>, has_walls},
    {"safe_pairs", "-", k_moment,
     "pairs of superquadrics in the last executed step that the fast solver left to the safe method",
     of<&SeriesRow::safe_pairs>, has_superquadrics},
    {"coordination_number", "-", k_moment, "2 contacts / particles; walls do not count",
     [](const Row& at) -> SeriesValue {
       const auto grains = static_cast<double>(at.now.particles);
       return grains > 0 ? 2.0 * static_cast<double>(at.now.contacts) / grains : 0.0;
     }},
    {"inserted", "-", k_sum, "grains that sources have brought since the start, without those of step 0",
     of<&SeriesRow::inserted>, has_sources},
    {"removed", "-", k_sum, "grains that left through open sides or were removed by events", of<&SeriesRow::removed>},
    {"removed_mass", "kg", k_sum, "their mass", of<&SeriesRow::removed_mass>},
    {"mass_flow", "kg/s", k_mean, "of removed_mass since the row before",
     [](const Row& at) -> SeriesValue { return at.rate(at.now.removed_mass, at.before.removed_mass); }},
    {"kinetic_translation", "J", k_moment, "half the sum of m v^2", energy<&Energies::kinetic_translation>, has_energies},
    {"kinetic_rotation", "J", k_moment, "half the sum of I w^2", energy<&Energies::kinetic_rotation>, has_rotation},
    {"potential", "J", k_moment,
     "of gravity, by height above the coordinate origin; along periodic axes minus its work since the start",
     energy<&Energies::potential>, has_energies},
    {"elastic", "J", k_moment, "in the springs of all contacts", energy<&Energies::elastic>, has_energies},
    {"dissipated_damping", "J", k_sum, "by the dashpots of contacts; positive is lost",
     energy<&Energies::dissipated_damping>, has_energies},
    {"dissipated_friction", "J", k_sum, "by sliding; positive is lost", energy<&Energies::dissipated_friction>, has_friction},
    {"dissipated_background", "J", k_sum, "by [damping]; positive is lost",
     energy<&Energies::dissipated_background>, has_energies},
    {"wall_work", "J", k_sum, "done by moving walls, driven grains and gas on the others; positive is put in",
     energy<&Energies::wall_work>, has_energies},
    {"inserted_energy", "J", k_sum,
     "kinetic and potential energy that sources, events and open sides brought in, and the springs of contacts that "
     "events, walls that appear and those that vanish begin; less what they and grains that leave end",
     energy<&Energies::inserted>, has_energies},
    {"resized_energy", "J", k_sum,
     "brought in by changing sizes: elastic of overlaps, kinetic and potential of the mass that comes",
     energy<&Energies::sizes>, has_sizes},
    {"balance_residual", "J", k_sum,
     "kinetic + potential + elastic + dissipated - wall_work - inserted_energy - resized_energy, less its value at the "
     "start",
     energy<&Energies::residual>, has_energies},
};

constexpr SeriesQuantity<WallLoad> k_walls[] = {
    {"wall.<wall>.force_{x,y,z}", "N", k_moment, "of all grains on the wall that can move; beside [heat] of held ones, too", load<&WallLoad::force>},
    {"wall.<wall>.torque_{x,y,z}", "N m", k_moment,
     "of the same grains, on the wall where the scene has it, about the coordinate origin", load<&WallLoad::torque>},
};

constexpr SeriesQuantity<PlaneTotal> k_planes[] = {
    {"plane.<plane>.particles", "-", k_sum, "passages of centres along the normal less those against it",
     [](const Plane& at) -> SeriesValue { return at.now.particles(); }},
    {"plane.<plane>.mass", "kg", k_sum, "the same of their masses",
     [](const Plane& at) -> SeriesValue { return at.now.mass; }},
    {"plane.<plane>.particle_flow", "1/s", k_mean, "of plane.<plane>.particles since the row before",
     [](const Plane& at) -> SeriesValue {
       return at.rate(static_cast<double>(at.now.particles()), static_cast<double>(at.before.particles()));
     }},
    {"plane.<plane>.mass_flow", "kg/s", k_mean, "of plane.<plane>.mass since the row before",
     [](const Plane& at) -> SeriesValue { return at.rate(at.now.mass, at.before.mass); }},
};
// clang-format on

}  // namespace

std::span<const SeriesQuantity<SeriesRow>> run_quantities() noexcept { return k_run; }
std::span<const SeriesQuantity<WallLoad>> wall_quantities() noexcept { return k_walls; }
std::span<const SeriesQuantity<PlaneTotal>> plane_quantities() noexcept { return k_planes; }

std::vector<std::string> column_names(std::string_view pattern, std::string_view name) {
  std::string text(pattern);
  if (const std::size_t open = text.find('<'); open != std::string::npos)
    text = text.substr(0, open) + std::string(name) + text.substr(text.find('>', open) + 1);
  const std::size_t brace = pattern.empty() || pattern.back() != '}' ? std::string::npos : text.rfind('{');
  if (brace == std::string::npos) return {text};
  std::vector<std::string> names;
  std::string_view words = std::string_view(text).substr(brace + 1, text.size() - brace - 2);
  for (;;) {
    const std::size_t comma = words.find(',');
    names.push_back(text.substr(0, brace) + std::string(words.substr(0, comma)));
    if (comma == std::string_view::npos) return names;
    words.remove_prefix(comma + 1);
  }
}

std::string pattern_of(const AverageQuantity& average) {
  const std::string_view parts = average.components == 3   ? "_{x,y,z}"
                                 : average.components == 6 ? "_{xx,yy,zz,xy,xz,yz}"
                                                           : "";
  return "region.<region>." + std::string(average.name) + std::string(parts);
}

}  // namespace talus
