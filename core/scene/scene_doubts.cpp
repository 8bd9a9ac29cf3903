// See scene_doubts.hpp.
#include "core/scene/scene_doubts.hpp"

#include <fmt/format.h>

#include "core/base/det_math.hpp"
#include "core/grains/region.hpp"
#include "core/scene/duration.hpp"
#include "core/walls/shapes/shape.hpp"

namespace talus {
namespace {

using Notes = std::vector<std::string>;

/// A step acts at its beginning: what is due at the last one waits for a longer run.
void note_late(const Scene& scene, Notes& notes) {
  const double end = end_of(scene);
  if (!(end > 0) || !(end < k_never)) return;
  const auto late = [&](double time) { return time > 0 && time > end - 0.5 * scene.dt; };
  const auto say = [&](const std::string& what, double time) {
    notes.push_back(fmt::format("{} at {:g} s, and the run ends at {:g} s before it", what, time, end));
  };
  for (std::size_t k = 0; k < scene.events.size(); ++k)
    if (const Event& e = scene.events[k]; late(e.time))
      say(fmt::format("event {} ({}) is due", k, enum_word(e.action)), e.time);
  for (const Source& s : scene.sources)
    if (s.kind != Source::Kind::file && late(s.start)) say(fmt::format("source '{}' begins", s.name), s.start);
  for (const WallSpec& w : scene.walls) {
    if (late(w.appear))
      say(fmt::format("wall \"{}\" appears", w.name), w.appear);
    else if (w.motion.any() && late(w.motion.start))
      say(fmt::format("wall \"{}\" begins to move", w.name), w.motion.start);
  }
}

/// Radius that no grain exceeds [m]; of files, which are not read here, half of the shortest side.
double largest_radius(const Scene& scene) {
  const Vec3 size = scene.domain.upper - scene.domain.lower;
  double r = 0;
  for (const Source& s : scene.sources)
    r = fmax2(r, s.kind == Source::Kind::file || s.shape >= 0 ? 0.5 * fmin2(size.x, fmin2(size.y, size.z))
                                                              : 0.5 * s.size.largest());
  return r;
}

void note_unreached(const Scene& scene, Notes& notes) {
  const double r = largest_radius(scene);
  for (const WallSpec& w : scene.walls) {
    const auto away = shape_kind(w.shape).away;
    if (w.motion.any() || away == nullptr) continue;
    const double gap = away(scene.domain, w);
    if (!(gap > r)) continue;
    notes.push_back(fmt::format("no grain can touch wall \"{}\": it lies {:g} m outside the domain", w.name, gap));
  }
}

constexpr double k_celsius = 150;  // -123 degrees: below it hardly a bed is, and a room in degrees is far below

void note_celsius(const Scene& scene, Notes& notes) {
  const HeatScene& h = scene.heat;
  if (!h.on) return;
  double least = k_never;
  std::string where;
  const auto look = [&](const std::string& name, double T) {
    if (!(T < k_celsius) || !(T < least)) return;
    least = T;
    where = name;
  };
  look("heat.temperature", h.temperature);
  for (std::size_t k = 0; k < h.sources.size() && k < scene.sources.size(); ++k)
    look("the temperature of source '" + scene.sources[k].name + "'", h.sources[k].temperature);
  for (const WallHeat& w : h.walls)
    if (w.temperature.given()) look("the temperature of wall '" + w.wall + "'", w.temperature.least());
  if (h.gas.on) look("heat.gas.temperature", h.gas.temperature.least());
  if (h.radiation.enclosure.given()) look("heat.radiation.enclosure", h.radiation.enclosure.least());
  if (where.empty()) return;
  notes.push_back(fmt::format("{} is {:g} K, that is {:g} degrees Celsius: temperatures are in kelvin", where, least,
                              least - 273.15));
}

void note_degrees(const Scene& scene, Notes& notes) {
  double most = 0;
  for (const PairCoefficients& p : scene.pairs) most = fmax2(most, scene.contact.friction ? p.friction : 0.0);
  if (!(most >= 5 && most < 90)) return;
  const auto [s, c] = det::sincos_turns(most / 360);
  notes.push_back(
      fmt::format("friction is a coefficient: {:g} is that of a slope of {:.0f} degrees, and an angle of "
                  "{:g} degrees would be {:.3g}",
                  most, det::atan(most) * 180 / det::k_pi, most, s / c));
}

/// What no gas is like, and other units of the same quantity would be.
void note_units(const Scene& scene, Notes& notes) {
  const HeatScene& h = scene.heat;
  if (!h.on) return;
  const auto gas = [&](const char* key, double k) {
    if (k > 2) notes.push_back(fmt::format("{} is {:g} W/m/K, and no gas conducts so well (air: 0.026)", key, k));
  };
  if (h.gas.on && !(h.gas.film >= 0)) gas("heat.gas.conductivity", h.gas.conductivity);
  gas("heat.gap.conductivity", h.gap.conductivity);
}

void note_empty_space(const Scene& scene, Notes& notes) {
  const Domain& d = scene.domain;
  for (const auto& a : scene.output.regions) {
    double out = 0;
    for (int k = 0; k < 3; ++k) {
      const double tiny = 1e-9 * (d.upper[k] - d.lower[k]);
      const double beyond = fmax2(a.region.upper[k] - d.upper[k], d.lower[k] - a.region.lower[k]);
      if (!d.periodic(k) && beyond > tiny) out = fmax2(out, beyond);
    }
    if (out > 0)
      notes.push_back(
          fmt::format("output region '{}' reaches {:g} m out of the domain: its averages count that space "
                      "as empty",
                      a.name, out));
  }
}

/// Shares of bodies that are no spheres are summed over rays within each (core/frame/body_shares.hpp): few of these
/// meet a region much smaller than the body.
void note_small_regions(const Scene& scene, Notes& notes) {
  double body = 0;  // [m]
  for (const Source& s : scene.sources)
    if (s.shape >= 0 && s.kind != Source::Kind::file) body = fmax2(body, s.size.largest());
  const auto look = [&](const std::string& what, double volume) {
    const double edge = det::cbrt(volume);
    if (edge < body)
      notes.push_back(fmt::format(
          "{} a cube of {:.3g} m, and bodies are as large as spheres of {:.3g} m: their shares in it are rough", what,
          edge, body));
  };
  for (const auto& a : scene.output.regions)
    look(fmt::format("output region '{}' is as large as", a.name), volume(a.region));
  if (!scene.output.grid.on) return;
  const Vec3 size = scene.domain.upper - scene.domain.lower;
  const auto& n = scene.output.grid.cells;
  look("each cell of output.grid is as large as", size.x / n[0] * (size.y / n[1]) * (size.z / n[2]));
}

}  // namespace

std::vector<std::string> doubts_of(const Scene& scene, bool cut) {
  Notes notes;
  if (!cut) note_late(scene, notes);
  note_unreached(scene, notes);
  note_celsius(scene, notes);
  note_degrees(scene, notes);
  note_units(scene, notes);
  note_empty_space(scene, notes);
  note_small_regions(scene, notes);
  return notes;
}

}  // namespace talus
