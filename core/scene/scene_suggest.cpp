// See scene_suggest.hpp.
#include "core/scene/scene_suggest.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <vector>

#include "core/base/suggest.hpp"

namespace talus {
namespace {

/// Words of other codes and of everyday language. `within`: counts only below this section ("" anywhere).
struct Alias {
  std::string_view word, within, section, name, remark;
};
constexpr std::string_view k_diameter = "sizes are diameters";

constexpr Alias k_aliases[] = {
    {"radius", "source", "source.size", "diameter", k_diameter},
    {"radius", "size", "source.size", "diameter", k_diameter},
    {"radius", "", "source.size", "diameter", k_diameter},
    {"particle_radius", "", "source.size", "diameter", k_diameter},
    {"min_radius", "", "source.size", "min", k_diameter},
    {"max_radius", "", "source.size", "max", k_diameter},
    {"d", "", "source.size", "diameter", ""},
    {"particle_diameter", "", "source.size", "diameter", ""},
    {"sigma", "size", "source.size", "stddev", ""},
    {"std", "size", "source.size", "stddev", ""},
    {"deviation", "size", "source.size", "stddev", ""},
    {"standard_deviation", "size", "source.size", "stddev", ""},
    {"mu", "", "contact", "friction", ""},
    {"coulomb", "", "contact", "friction", ""},
    {"cof", "", "contact", "friction", ""},
    {"friction_coefficient", "", "contact", "friction", ""},
    {"sliding_friction", "", "contact", "friction", ""},
    {"static_friction", "", "contact", "friction", ""},
    {"e", "", "contact", "restitution", ""},
    {"cor", "", "contact", "restitution", ""},
    {"coefficient_of_restitution", "", "contact", "restitution", ""},
    {"en", "", "contact", "restitution", ""},
    {"kn", "", "contact", "normal_stiffness", ""},
    {"k_n", "", "contact", "normal_stiffness", ""},
    {"stiffness", "", "contact", "normal_stiffness", ""},
    {"spring", "", "contact", "normal_stiffness", ""},
    {"kt", "", "contact", "tangential_stiffness", ""},
    {"k_t", "", "contact", "tangential_stiffness", ""},
    {"shear_stiffness", "", "contact", "tangential_stiffness", ""},
    {"gamma_n", "", "contact", "normal_damping", ""},
    {"gamman", "", "contact", "normal_damping", ""},
    {"damping", "contact", "contact", "normal_damping", ""},
    {"gamma_t", "", "contact", "tangential_damping", ""},
    {"gammat", "", "contact", "tangential_damping", ""},
    {"law", "", "contact", "model", ""},
    {"mu_r", "", "contact", "rolling_friction", ""},
    {"rolling_resistance", "", "contact", "rolling_friction", ""},
    {"mu_t", "", "contact", "twisting_friction", ""},
    {"g", "", "", "gravity", ""},
    {"gravity_vector", "", "", "gravity", ""},
    {"random_seed", "", "", "seed", ""},
    {"dt", "", "time", "step", ""},
    {"timestep", "", "time", "step", ""},
    {"time_step", "", "time", "step", ""},
    {"delta_t", "", "time", "step", ""},
    {"nsteps", "", "time", "steps", ""},
    {"num_steps", "", "time", "steps", ""},
    {"number_of_steps", "", "time", "steps", ""},
    {"end_time", "", "time", "duration", ""},
    {"t_end", "", "time", "duration", ""},
    {"total_time", "", "time", "duration", ""},
    {"simulation_time", "", "time", "duration", ""},
    {"rho", "", "material", "density", ""},
    {"e_modulus", "", "material", "young", ""},
    {"elastic_modulus", "", "material", "young", ""},
    {"youngs_modulus", "", "material", "young", ""},
    {"young_modulus", "", "material", "young", ""},
    {"modulus", "", "material", "young", ""},
    {"nu", "", "material", "poisson", ""},
    {"poisson_ratio", "", "material", "poisson", ""},
    {"poissons_ratio", "", "material", "poisson", ""},
    {"min", "domain", "domain", "lower", ""},
    {"max", "domain", "domain", "upper", ""},
    {"low", "domain", "domain", "lower", ""},
    {"high", "domain", "domain", "upper", ""},
    {"size", "domain", "domain", "upper", "the box lies between lower and upper"},
    {"periodic", "", "domain", "boundary", ""},
    {"boundaries", "", "domain", "boundary", ""},
    {"count", "source", "source", "number", ""},
    {"n", "source", "source", "number", ""},
    {"particles", "source", "source", "number", ""},
    {"rate", "source", "source", "number_rate", ""},
    {"mass_flow", "source", "source", "mass_rate", ""},
    {"every", "source", "source", "interval", ""},
    {"type", "source", "source", "kind", ""},
    {"type", "wall", "wall", "shape", ""},
    {"kind", "wall", "wall", "shape", ""},
    {"mesh", "wall", "wall", "file", ""},
    {"stl", "", "wall", "file", ""},
    {"position", "wall", "wall", "point", ""},
    {"offset", "wall", "wall", "shift", ""},
    {"translate", "wall", "wall", "shift", ""},
    {"height", "wall", "wall", "length", ""},
    {"omega", "", "wall.motion", "rotation_rate", "in rad/s"},
    {"angular_velocity", "", "wall.motion", "rotation_rate", "in rad/s about rotation_axis"},
    {"rpm", "", "wall.motion", "rotation_rate", "in rad/s"},
    {"rotation", "", "wall.motion", "rotation_rate", "in rad/s"},
    {"axis", "motion", "wall.motion", "rotation_axis", ""},
    {"origin", "motion", "wall.motion", "rotation_origin", ""},
    {"interval", "output", "output", "particles_every", ""},
    {"every", "output", "output", "particles_every", ""},
    {"dump_every", "", "output", "particles_every", ""},
    {"frames_every", "", "output", "particles_every", ""},
    {"vtk", "", "output", "vtp", ""},
    {"paraview", "", "output", "vtp", ""},
    {"hdf5", "", "output", "vtkhdf", ""},
    {"csv", "", "output", "csv_every", ""},
    {"series_every", "", "output", "csv_every", ""},
    {"energy", "output", "output", "energies", ""},
    {"checkpoint_every", "", "output", "checkpoint_wall", "seconds of wall time; steps: --checkpoint-every"},
    {"k", "list", "list", "verlet_k", ""},
    {"skin", "list", "list", "uniform_skin", ""},
    {"overlap", "checks", "checks", "max_overlap", ""},
};

struct Typed {
  std::string section, name;
};

/// Lower case, '-' as '_', indices of repeated sections left out.
Typed typed_of(std::string_view path) {
  Typed t;
  std::vector<std::string> parts{""};
  for (char c : path) {
    if (c == '.') {
      parts.emplace_back();
      continue;
    }
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    parts.back() += c == '-' || c == ' ' ? '_' : c;
  }
  const auto is_index = [](const std::string& s) {
    return !s.empty() && std::all_of(s.begin(), s.end(), [](char c) { return c >= '0' && c <= '9'; });
  };
  t.name = parts.back();
  parts.pop_back();
  for (const std::string& part : parts)
    if (!is_index(part)) t.section += (t.section.empty() ? "" : ".") + part;
  return t;
}

std::string_view last_part(std::string_view section) {
  const std::size_t dot = section.rfind('.');
  return dot == std::string_view::npos ? section : section.substr(dot + 1);
}

bool near(std::string_view a, std::string_view b) {
  return edit_distance(a, b) * 3 <= std::max<std::size_t>(a.size(), 3);
}

constexpr double k_no = 9;

/// How far the typed section is from a key's.
double section_cost(std::string_view typed, std::string_view section) {
  if (typed == section) return 0;
  if (typed.empty()) return 0.12 + 0.01 * static_cast<double>(std::count(section.begin(), section.end(), '.'));
  if (section.ends_with("." + std::string(typed))) return 0.05;
  if (section.starts_with(std::string(typed) + ".")) return 0.12;
  if (!section.empty() && near(typed, section)) return 0.1;
  if (!section.empty() && near(last_part(typed), last_part(section))) return 0.15;
  if (!section.empty() && typed.starts_with(std::string(section) + ".")) return 0.2;
  return 0.3;
}

/// How far the typed name is from a key's.
double name_cost(std::string_view typed, std::string_view name) {
  if (typed == name) return 0;
  const std::size_t distance = edit_distance(typed, name);
  double cost = k_no;
  if (distance * 2 <= typed.size() && distance < typed.size())
    cost = 0.15 + 0.6 * static_cast<double>(distance) / static_cast<double>(std::max(typed.size(), name.size()));
  constexpr std::size_t k_short = 3;
  if (typed.size() > k_short && (has_word(name, typed) || (name.size() > k_short && has_word(typed, name))))
    cost = std::min(cost, 0.3);
  return cost;
}

bool within(std::string_view section, std::string_view asked) {
  return asked.empty() || section == asked || section.starts_with(std::string(asked) + ".") ||
         last_part(section) == asked;
}

}  // namespace

KeySuggestion suggest_key(std::string_view path) {
  const Typed t = typed_of(path);
  constexpr double limit = 0.56;
  double best = limit;
  KeySuggestion found;
  const auto offer = [&](double cost, const SceneKey* key, std::string_view remark) {
    if (key == nullptr || !(cost < best)) return;
    best = cost;
    found = {key, remark};
  };
  // What a word means elsewhere goes before a key of the same spelling for something else.
  for (const Alias& a : k_aliases)
    if (a.word == t.name && within(t.section, a.within))
      offer(section_cost(t.section, a.section) - 0.05, find_scene_key(a.section, a.name), a.remark);
  for (const SceneKey& k : scene_keys()) offer(name_cost(t.name, k.name) + section_cost(t.section, k.section), &k, "");
  return found;
}

std::string settable_path(const SceneKey& key, std::string_view typed) {
  if (key.section.empty()) return std::string(key.name);
  const std::string_view top = key.section.substr(0, key.section.find('.'));
  std::string path, so_far;
  for (std::size_t at = 0; at <= key.section.size();) {
    const std::size_t dot = std::min(key.section.find('.', at), key.section.size());
    const std::string_view part = key.section.substr(at, dot - at);
    so_far += (so_far.empty() ? "" : ".") + std::string(part);
    path += (path.empty() ? "" : ".") + std::string(part);
    const SceneSection* section = find_scene_section(so_far);
    if (section != nullptr && section->repeated) {
      std::string_view index = "0";
      if (so_far == top && typed.starts_with(std::string(top) + ".")) {
        const std::string_view rest = typed.substr(top.size() + 1);
        const std::string_view word = rest.substr(0, rest.find('.'));
        if (!word.empty() && word.find_first_not_of("0123456789") == std::string_view::npos) index = word;
      }
      path += "." + std::string(index);
    }
    at = dot + 1;
  }
  return path + "." + std::string(key.name);
}

std::string key_hint(std::string_view path, bool settable) {
  const KeySuggestion s = suggest_key(path);
  if (s.key == nullptr) return "";
  const std::string name = settable ? settable_path(*s.key, path) : full_name(*s.key);
  return fmt::format(" (did you mean '{}'?{}{})", name, s.remark.empty() ? "" : " ", s.remark);
}

}  // namespace talus
