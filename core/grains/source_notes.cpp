// Notes about sources. Who calls it: see the header. Invariants: see the header.
#include "core/grains/source_notes.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/det_math.hpp"
#include "core/base/error.hpp"
#include "core/base/rng.hpp"
#include "core/grains/insertion.hpp"
#include "core/grains/region.hpp"
#include "core/grains/source_walls.hpp"
#include "core/walls/shapes/shape.hpp"
#include "core/walls/wall_motion.hpp"

namespace talus {
namespace {

constexpr std::uint64_t k_samples = 4000;

/// Points all over a region.
std::vector<Vec3> points_of(const Region& g) {
  std::vector<Vec3> points;
  const CounterRng rng(1, 2);
  for (std::uint64_t n = 0; n < k_samples; ++n) {
    Vec3 x;
    for (int k = 0; k < 3; ++k) x[k] = rng.uniform(3 * n + static_cast<std::uint64_t>(k), g.lower[k], g.upper[k]);
    if (inside(g, x)) points.push_back(x);
  }
  return points;
}

/// Some of the surface lies well within the region: a body too small for the samples.
bool reaches_into(const Domain& domain, const Region& g, const std::vector<Vec3>& surface, double margin) {
  return std::any_of(surface.begin(), surface.end(), [&](Vec3 x) {
    if (!inside(domain, g, x)) return false;
    for (int k = 0; k < 3; ++k)
      if (!(x[k] > g.lower[k] + margin && x[k] < g.upper[k] - margin)) return false;
    return holds(domain, g, x, margin);
  });
}

std::string side_note(const Scene& scene, const Source& s, const ClosedWalls& closed, const WallSet& walls, int wall,
                      const std::vector<Vec3>& points) {
  const auto in = static_cast<std::size_t>(
      std::count_if(points.begin(), points.end(), [&](Vec3 x) { return closed.inside(walls, wall, x); }));
  const double share = points.empty() ? 0 : 100 * static_cast<double>(in) / static_cast<double>(points.size());
  std::string part = fmt::format("about {:.2g} %", share);
  if (in == 0 || in == points.size()) {
    if (!reaches_into(scene.domain, s.region, closed.points(walls, wall), 0.01 * s.size.smallest())) return {};
    part = in == 0 ? "a small part" : "nearly all";
  }
  return fmt::format(
      "source '{}': {} of its region lies inside the closed wall \"{}\", the rest outside; particles are placed on "
      "both "
      "sides (source.closed_walls = \"outside\" or \"inside\" keeps them to one)",
      s.name, part, walls.name(wall));
}

/// A grain of radius r at x lies in the region as a whole.
bool has_room(const Domain& domain, const Region& g, Vec3 x, double r) {
  for (int k = 0; k < 3; ++k)
    if (!spans(domain, g, k) && !(x[k] >= g.lower[k] + r && x[k] <= g.upper[k] - r)) return false;
  return holds(domain, g, x, r);
}

/// Where a wall has its sides: behind it or within it a grain of the source finds room, and on the other side too.
std::string open_side_note(const Scene& scene, const Source& s, const WallSet& walls, std::size_t wall,
                           const std::vector<Vec3>& points) {
  const WallSpec& spec = scene.walls[wall];
  const int w = static_cast<int>(wall);
  const double r = 0.5 * s.size.smallest();
  std::size_t within = 0, beyond = 0;
  for (int k = 0; k < walls.image_count(w); ++k)
    for (const Vec3 x : points) {
      if (!has_room(scene.domain, s.region, x, r)) continue;
      const Vec3 body = to_body(walls.pose(w), (x - scene.domain.lower) - walls.image_shift(w, k));
      const double side = shape_kind(spec.shape).sides.of(spec, body + scene.domain.lower);
      within += side < -r ? 1 : 0;
      beyond += side > r ? 1 : 0;
    }
  if (within == 0 || beyond == 0) return {};
  const ShapeSides& sides = shape_kind(spec.shape).sides;
  return fmt::format(
      "source '{}': about {:.2g} % of its region near wall \"{}\" lies {}, the rest {}; particles are placed on both "
      "sides (a region that ends at the wall keeps them to one)",
      s.name, 100 * static_cast<double>(within) / static_cast<double>(within + beyond), walls.name(w), sides.negative,
      sides.positive);
}

}  // namespace

std::vector<std::string> sides_of_closed_walls(const Scene& scene, WallSet& walls) {
  std::vector<std::string> notes;
  const auto undecided = [](const Source& s) {
    return s.kind != Source::Kind::file && s.closed_walls == Source::ClosedWalls::both;
  };
  const auto encloses = [](const WallSpec& w) { return shape_kind(w.shape).enclosing != nullptr; };
  if (std::none_of(scene.sources.begin(), scene.sources.end(), undecided) ||
      std::none_of(scene.walls.begin(), scene.walls.end(), encloses))
    return notes;
  const ClosedWalls closed(scene);
  for (const Source& s : scene.sources) {
    if (!undecided(s)) continue;
    walls.set_step(s.start > 0 ? det::nearest(s.start / scene.dt) : 0, scene.dt);
    const std::vector<Vec3> points = points_of(s.region);
    for (int w = 0; w < static_cast<int>(scene.walls.size()); ++w) {
      if (!closed.closed(w) || !walls.pose(w).active) continue;
      std::string note = side_note(scene, s, closed, walls, w, points);
      if (!note.empty()) notes.push_back(std::move(note));
    }
  }
  return notes;
}

std::vector<std::string> sides_of_open_walls(const Scene& scene, WallSet& walls) {
  std::vector<std::string> notes;
  for (const Source& s : scene.sources) {
    if (s.kind == Source::Kind::file) continue;
    walls.set_step(s.start > 0 ? det::nearest(s.start / scene.dt) : 0, scene.dt);
    std::vector<Vec3> points;
    for (std::size_t w = 0; w < scene.walls.size(); ++w) {
      if (shape_kind(scene.walls[w].shape).sides.of == nullptr || !walls.pose(static_cast<int>(w)).active) continue;
      if (points.empty()) points = points_of(s.region);
      std::string note = open_side_note(scene, s, walls, w, points);
      if (!note.empty()) notes.push_back(std::move(note));
    }
  }
  return notes;
}

std::vector<std::string> later_shortfalls(const Scene& scene, WallSet& walls) {
  std::vector<std::string> notes;
  for (const Source& s : scene.sources) {
    if (s.kind == Source::Kind::file || (s.kind != Source::Kind::stream && !(s.start > 0))) continue;
    Scene alone = scene;
    alone.sources = {s};
    Insertion source(alone);
    const std::int64_t n = source.next_step(0);
    if (n >= scene.steps) continue;
    walls.set_step(n, scene.dt);
    try {
      source.batch(n, {}, &walls);
      for (const Shortfall& f : source.shortfalls())
        notes.push_back(shortfall_text(alone, 0, f.placed, f.wanted) + " with no other particles there");
    } catch (const Error& e) {
      notes.push_back(fmt::format("step {}: the run would end: {}", n, e.what()));
    }
  }
  return notes;
}

std::string shortfall_text(const Scene& scene, std::size_t source, std::int64_t placed, std::int64_t wanted) {
  return fmt::format("source '{}': {} of {} particles due were placed, the others found no room",
                     scene.sources[source].name, placed, wanted);
}

}  // namespace talus
