// See population.hpp.
#include "core/grains/population.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/det_math.hpp"
#include "core/grains/body.hpp"
#include "core/grains/body_shape.hpp"
#include "core/grains/insertion.hpp"
#include "core/scene/duration.hpp"

namespace talus {
namespace {

const double k_root_three = std::sqrt(3.0);

void keep_two_smallest(double* two, double r) {
  if (r < two[0])
    two[1] = two[0], two[0] = r;
  else
    two[1] = fmin2(two[1], r);
}

void keep_two_largest(double* two, double r) {
  if (r > two[0])
    two[1] = two[0], two[0] = r;
  else
    two[1] = fmax2(two[1], r);
}

/// Fixed grains count as free where something can release them.
bool releases(const Scene& scene) {
  return std::any_of(scene.events.begin(), scene.events.end(),
                     [](const Event& e) { return e.action == Event::Action::release; });
}

/// At most so many grains: lattices and streams without a number, and masses, may bring any.
std::int64_t most_of(const Source& s) { return s.number > 0 ? std::min(s.number, k_many_grains) : k_many_grains; }

std::size_t tiles_of(const Source& s) {
  std::size_t n = 1;
  for (const int k : s.tile) n *= static_cast<std::size_t>(k);
  return n;
}

}  // namespace

void Population::add(int material, bool fixed, double smallest, double largest, std::int64_t count, double weight,
                     double thinnest, double whole) {
  if (count <= 0) return;
  auto kind = std::find_if(kinds.begin(), kinds.end(), [&](const GrainKind& k) {
    return k.material == material && k.fixed == fixed && k.weight == weight && k.thinnest == thinnest &&
           k.whole == whole;
  });
  if (kind == kinds.end()) {
    kinds.emplace_back();
    kind = kinds.end() - 1;
    kind->material = material;
    kind->fixed = fixed;
    kind->weight = weight;
    kind->thinnest = thinnest;
    kind->whole = whole;
  }
  for (int k = 0; k < (count > 1 ? 2 : 1); ++k) {
    keep_two_smallest(kind->smallest, smallest);
    keep_two_largest(kind->largest, largest);
  }
  kind->count = std::min(kind->count + count, k_many_grains);
}

void Population::add_velocity(Vec3 low, Vec3 high, double surface) {
  for (int k = 0; k < 3; ++k) {
    low_[k] = fmin2(low_[k], low[k]);
    high_[k] = fmax2(high_[k], high[k]);
  }
  surface_ = fmax2(surface_, surface);
}

std::int64_t Population::free_grains() const {
  std::int64_t n = 0;
  for (const GrainKind& k : kinds) n += k.fixed ? 0 : k.count;
  return std::min(n, k_many_grains);
}

double Population::smallest_free() const {
  double r = k_never;
  for (const GrainKind& k : kinds)
    if (!k.fixed) r = fmin2(r, k.smallest[0] * k.thinnest);
  return r == k_never ? 0 : r;
}

double Population::largest_free() const {
  double r = 0;
  for (const GrainKind& k : kinds)
    if (!k.fixed) r = fmax2(r, k.largest[0]);
  return r;
}

double Population::fastest() const {
  double v = 0;
  for (const Mover& m : movers) v = fmax2(v, m.fastest);
  return v + surface_;
}

double Population::spread() const { return norm(high_ - low_) + surface_; }

Population population_of(const Scene& scene, double r_min, double r_max) {
  Population p;
  if (!(r_min > 0)) return p;
  std::vector<char> used(scene.materials.size(), scene.sources.empty() ? 1 : 0);
  for (const Source& s : scene.sources) {
    if (s.kind == Source::Kind::file)
      used.assign(used.size(), 1);
    else
      used[static_cast<std::size_t>(s.material)] = 1;
  }
  for (std::size_t m = 0; m < used.size(); ++m)
    if (used[m] != 0) p.add(static_cast<int>(m), false, r_min, r_max, k_many_grains);
  add_stated_velocities(scene, p);
  for (Mover& m : p.movers) m.smallest = r_min, m.largest = r_max;
  return p;
}

namespace {

const BodyShape* body_of(const Scene& scene, const Source& s) {
  return s.shape < 0 ? nullptr : scene.shapes[static_cast<std::size_t>(s.shape)].body.get();
}

/// What answers a force on a body over the mass of the sphere of its roundest contact.
double weight_of(const BodyShape& c, const Material& m) {
  return c.mass(m, 1) / (c.lightness * Body{c.roundest, m.density}.mass());
}
double whole_of(const BodyShape& c, const Material& m) { return c.mass(m, 1) / Body{c.roundest, m.density}.mass(); }

/// Farthest point of a grain from the axis that it spins about, where spins move anything [m].
double farthest(const Scene& scene, double largest, double of_files) {
  double reach = fmax2(scene.contact.friction ? largest : 0, of_files);
  for (const Source& s : scene.sources)
    if (const BodyShape* b = body_of(scene, s))
      reach = fmax2(reach, 0.5 * s.size.largest() * (b->bound / b->equal_radius));
  return reach;
}

}  // namespace

void add_stated_velocities(const Scene& scene, Population& p) {
  const double end = end_of(scene);
  for (const Source& s : scene.sources) {
    if (s.kind == Source::Kind::file || s.start >= end) continue;
    const Vec3 jitter{s.velocity_jitter, s.velocity_jitter, s.velocity_jitter};
    const double v = norm(s.velocity), most = k_root_three * s.velocity_jitter;
    p.add_velocity(s.velocity - jitter, s.velocity + jitter);
    // an initial state that relaxes starts at rest
    if (scene.relax.steps > 0 && s.kind != Source::Kind::stream && s.start <= 0) continue;
    const BodyShape* body = body_of(scene, s);
    const double share = body != nullptr ? body->smallest / body->equal_radius : 1;  // what is thinnest is passed first
    p.movers.push_back({fmt::format("source '{}'", s.name), "", fmax2(0, v - most), v + most,
                        0.5 * s.size.smallest() * share, 0.5 * s.size.largest() * share});
  }
  for (const Event& e : scene.events) {
    const bool sets = e.action == Event::Action::set_velocity || e.action == Event::Action::drive;
    if (!sets || e.time >= end) continue;
    double smallest = k_never, largest = 0;
    for (const GrainKind& k : p.kinds)
      smallest = fmin2(smallest, k.smallest[0] * k.thinnest), largest = fmax2(largest, k.largest[0]);
    const double v = norm(e.vector);
    p.add_velocity(e.vector, e.vector, farthest(scene, largest, p.reach) * norm(e.spin));
    p.movers.push_back({fmt::format("the event at {:g} s", e.time), "", v, v, smallest, largest});
  }
}

Population Insertion::population() const {
  Population p;
  const bool may_release = releases(scene_);
  const double end = end_of(scene_);
  std::int64_t first_id = 0;
  for (std::size_t s = 0; s < scene_.sources.size(); ++s) {
    const Source& source = scene_.sources[s];
    if (source.kind != Source::Kind::file) {
      if (source.start >= end) continue;
      const BodyShape* c = shape_of(s);
      const double share = c != nullptr ? c->roundest / c->equal_radius : 1,
                   smallest = 0.5 * source.size.smallest() * share, largest = 0.5 * source.size.largest() * share;
      if (c != nullptr) {
        const Material& m = scene_.materials[static_cast<std::size_t>(source.material)];
        p.add(source.material, false, smallest, largest, most_of(source), weight_of(*c, m), c->smallest / c->roundest,
              whole_of(*c, m));
      } else {
        p.add(source.material, false, smallest, largest, most_of(source));
      }
      continue;
    }
    const NewParticles& f = files_[s];
    const auto tiles = static_cast<std::int64_t>(tiles_of(source));
    Mover fastest;  // for its size
    const auto mover = [&](std::size_t i, Vec3 velocity, double r) {
      const double v = norm(velocity);
      if (!(v > 0) || (fastest.fastest > 0 && !(v * fastest.smallest > fastest.fastest * r))) return;
      const std::int64_t id = first_id + static_cast<std::int64_t>(i);
      fastest = {fmt::format("particle {}", id), place_in_file(static_cast<std::size_t>(id)), v, v, r, r};
    };
    auto body = f.bodies.begin();
    for (std::size_t i = 0; i < f.size(); ++i) {
      if (body != f.bodies.end() && static_cast<std::size_t>(body->first) == i) {
        const BodyShape& c = shape_of(*body);
        const double r = body->scale * c.roundest;
        p.add(f.material[i], f.fixed[i] != 0 && !may_release, r, r, tiles,
              weight_of(c, scene_.materials[f.material[i]]), c.smallest / c.roundest,
              whole_of(c, scene_.materials[f.material[i]]));
        p.reach = fmax2(p.reach, body->scale * c.bound);
        if (scene_.relax.steps == 0) {
          p.add_velocity(body->v, body->v, body->scale * c.bound * norm(body->w));
          mover(i, body->v, body->scale * c.smallest);
        }
        i += static_cast<std::size_t>(body->count) - 1;
        ++body;
        continue;
      }
      p.add(f.material[i], f.fixed[i] != 0 && !may_release, f.r[i], f.r[i], tiles);
      if (scene_.relax.steps > 0) continue;
      p.add_velocity(f.v[i], f.v[i], scene_.contact.friction ? f.r[i] * norm(f.w[i]) : 0);
      mover(i, f.v[i], f.r[i]);
    }
    if (fastest.fastest > 0) p.movers.push_back(fastest);
    first_id += static_cast<std::int64_t>(f.size() * tiles_of(source));
  }
  add_stated_velocities(scene_, p);
  return p;
}

}  // namespace talus
