// Placing of particles: lattice, random pack, stream. Who calls it: core/grains/insertion.cpp. Every draw is addressed
// by counters that are part of the saved state: sizes by the number of sizes drawn so far, positions by (batch,
// attempt), velocities by the number of particles delivered.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/count.hpp"
#include "core/base/det_math.hpp"
#include "core/base/error.hpp"
#include "core/base/rng.hpp"
#include "core/grains/body.hpp"
#include "core/grains/insertion.hpp"
#include "core/grains/occupied.hpp"
#include "core/grains/region.hpp"
#include "core/grains/source_walls.hpp"

namespace talus {
namespace {

constexpr int k_random_attempts = 5000;  ///< random sequential packing stalls near a solid fraction of 0.36
constexpr int k_stream_attempts = 200;
constexpr int k_misses = 200;        ///< tries outside the region or in a wall for each that counts
constexpr int k_stream_misses = 20;  ///< the same for streams: a blocked one must not slow down a run
enum Purpose : std::uint64_t { k_size, k_position, k_velocity, k_purposes };

}  // namespace

/// Where a particle of a source may go. What refuses it is looked at in the order of what it costs.
struct Insertion::Site {
  const Scene& scene;
  const Source& source;
  SourceWalls walls;
  const ClosedWalls* closed;
  Occupied occupied;
  std::int64_t in_wall = 0;  ///< tries that a wall refused

  enum class Answer : std::uint8_t { free, taken, outside, wall };
  /// `scale` < 1 forgives rounding where lattice sites touch by construction.
  Answer ask(Vec3 x, double r, double scale = 1 + 1e-12) {
    if (!holds(scene.domain, source.region, x, r)) return Answer::outside;
    if (!occupied.free(x, r, scale)) return Answer::taken;
    if (walls.walls() == nullptr) return Answer::free;
    const Vec3 y = wrapped(scene.domain, x);
    if ((source.allow_wall_overlap || walls.clear(y, r)) && on_side(y)) return Answer::free;
    ++in_wall;
    return Answer::wall;
  }
  /// The same of a grain of volume-equal radius r; `shape`: of a body, or null.
  Answer ask(const BodyShape* shape, const shapes::Quaternion& turn, Vec3 x, double r, double scale = 1 + 1e-12) {
    if (shape == nullptr) return ask(x, r, scale);
    const shapes::Rotation to = shapes::rotation(turn);
    const double size = r / shape->equal_radius;
    for (const shapes::SubSphere& s : shape->spheres)
      if (const Answer a = ask(x + shapes::to_space(to, size * s.x), size * s.r, scale); a != Answer::free) return a;
    return Answer::free;
  }
  void occupy(const BodyShape* shape, const shapes::Quaternion& turn, Vec3 x, double r) {
    if (shape == nullptr) return occupied.add(x, r);
    const shapes::Rotation to = shapes::rotation(turn);
    const double size = r / shape->equal_radius;
    for (const shapes::SubSphere& s : shape->spheres) occupied.add(x + shapes::to_space(to, size * s.x), size * s.r);
  }
  bool on_side(Vec3 x) const {
    return closed == nullptr || source.closed_walls == Source::ClosedWalls::both ||
           closed->inside_any(*walls.walls(), x) == (source.closed_walls == Source::ClosedWalls::inside);
  }
  /// A uniform point at which a sphere lies within the bounds of the region.
  Vec3 draw(const CounterRng& rng, std::uint64_t& counter, double r) const {
    const Region& g = source.region;
    Vec3 x;
    for (int k = 0; k < 3; ++k) {
      const bool whole = spans(scene.domain, g, k);
      const double low = whole ? g.lower[k] : g.lower[k] + r, high = whole ? g.upper[k] : g.upper[k] - r;
      x[k] = rng.uniform(counter++, low, high);
      if (whole && x[k] >= high) x[k] = low;
    }
    return x;
  }
  std::string walls_text() const {
    return in_wall > 0 ? fmt::format("; {} tries met a wall{}", in_wall,
                                     source.closed_walls == Source::ClosedWalls::both
                                         ? ""
                                         : " or lay on the wrong side of closed walls")
                       : "";
  }
};

double Insertion::next_radius(std::size_t s) const {
  const CounterRng rng(scene_.seed, s * k_purposes + k_size);
  return 0.5 * samplers_[s].diameter(rng.uniform(static_cast<std::uint64_t>(state_[s].drawn)));
}

double Insertion::mass_of(std::size_t s, double r) const {
  const Material& material = scene_.materials[static_cast<std::size_t>(scene_.sources[s].material)];
  if (const BodyShape* shape = shape_of(s)) return shape->mass(material, r / shape->equal_radius);
  return Body{r, material.density}.mass();
}

shapes::Quaternion Insertion::turn_of(std::size_t s, std::int64_t number) const {
  return shape_of(s) == nullptr ? shapes::Quaternion{} : first_turn(scene_, s, number);
}

void Insertion::append(std::size_t s, Vec3 x, double r, Vec3 v, NewParticles& out) const {
  const Source& source = scene_.sources[s];
  out.x.push_back(wrapped(scene_.domain, x));
  out.v.push_back(v);
  out.w.push_back({});
  out.r.push_back(r);
  out.material.push_back(static_cast<std::uint8_t>(source.material));
  out.fixed.push_back(0);
  out.group.push_back(static_cast<std::int16_t>(source.group));
  out.source.push_back(static_cast<std::int32_t>(s));
}

void Insertion::append_body(std::size_t s, Vec3 x, double r, Vec3 v, NewParticles& out) const {
  const BodyShape& shape = *shape_of(s);
  NewBody b;
  b.first = static_cast<std::int32_t>(out.size());
  b.count = static_cast<std::int32_t>(shape.spheres.size());
  b.shape = scene_.sources[s].shape;
  b.scale = r / shape.equal_radius;
  b.mass = mass_of(s, r);
  b.x = wrapped(scene_.domain, x);
  b.v = v;
  b.turn = turn_of(s, state_[s].number);
  const shapes::Rotation to = shapes::rotation(b.turn);
  for (const shapes::SubSphere& part : shape.spheres)
    append(s, b.x + shapes::to_space(to, b.scale * part.x), b.scale * part.r, v, out);
  out.bodies.push_back(b);
}

void Insertion::deliver(std::size_t s, Vec3 x, double r, NewParticles& out) {
  const Source& source = scene_.sources[s];
  SourceState& state = state_[s];
  const CounterRng rng(scene_.seed, s * k_purposes + k_velocity);
  Vec3 v = source.velocity;
  if (source.velocity_jitter > 0) {
    for (int k = 0; k < 3; ++k) {
      const auto draw = static_cast<std::uint64_t>(3 * state.number + k);
      v[k] = v[k] + rng.uniform(draw, -source.velocity_jitter, source.velocity_jitter);
    }
  }
  if (source.shape < 0)
    append(s, x, r, v, out);
  else
    append_body(s, x, r, v, out);
  ++state.number;
  state.mass += mass_of(s, r);
}

void Insertion::fill(std::size_t s, const NewParticles& before, const PresentParticles& present, const WallSet* walls,
                     NewParticles& out) {
  const Source& source = scene_.sources[s];
  // Grains already there may be far larger than the source's: in its finest cells one of them widens every search.
  double largest = 0.5 * source.size.largest();
  if (const BodyShape* shape = shape_of(s))  // its spheres lie on either side of a face of the domain
    largest = 2 * largest * (shape->bound / shape->equal_radius);
  for (std::size_t i = 0; i < present.size(); ++i)
    if (present.rows[4 * i] <= 1e100) largest = fmax2(largest, present.rows[4 * i + 3]);
  for (const double r : before.r) largest = fmax2(largest, r);
  Site site{scene_, source, SourceWalls(scene_.domain, walls), closed_.get(),
            Occupied(scene_.domain, source.region.lower, source.region.upper, largest)};
  for (std::size_t i = 0; i < present.size(); ++i) {
    const double* row = &present.rows[4 * i];
    if (row[0] > 1e100) continue;
    site.occupied.add(Vec3{row[0], row[1], row[2]} + scene_.domain.lower, row[3]);
  }
  for (std::size_t i = 0; i < before.size(); ++i) site.occupied.add(before.x[i], before.r[i]);
  if (source.kind == Source::Kind::lattice) fill_lattice(s, site, out);
  if (source.kind == Source::Kind::random) fill_random(s, site, out);
  if (source.kind == Source::Kind::stream) fill_stream(s, site, out);
  ++state_[s].batches;
}

void Insertion::fill_lattice(std::size_t s, Site& site, NewParticles& out) {
  const Source& source = scene_.sources[s];
  const Region& g = source.region;
  const BodyShape* shape = shape_of(s);
  const double largest = source.size.largest() * (shape != nullptr ? shape->bound / shape->equal_radius : 1);
  const double pitch = source.spacing * largest;
  const bool hexagonal = source.lattice == Source::Lattice::hexagonal;
  // Close-packed layers: rows sqrt(3)/2, layers sqrt(2/3) apart, each second row and layer shifted into the gaps.
  const double row = hexagonal ? 0.5 * std::sqrt(3.0) * pitch : pitch;
  const double layer = hexagonal ? std::sqrt(2.0 / 3.0) * pitch : pitch;
  Vec3 first, last;
  for (int k = 0; k < 3; ++k) {
    first[k] = g.lower[k] + 0.5 * largest;
    last[k] = g.upper[k] - 0.5 * largest;
    // On an axis that closes on itself the sphere beyond the end is the first one.
    if (spans(scene_.domain, g, k)) last[k] = g.upper[k];
  }
  const std::int64_t before = state_[s].number;
  std::int64_t sites = 0;
  for (std::int64_t k = 0;; ++k) {
    const double z = first.z + layer * static_cast<double>(k);
    if (z > last.z) break;
    for (std::int64_t j = 0;; ++j) {
      const double y = first.y + row * (static_cast<double>(j) + (hexagonal && k % 2 == 1 ? 1.0 / 3.0 : 0.0));
      if (y > last.y) break;
      for (std::int64_t i = 0;; ++i) {
        Vec3 x{first.x + pitch * (static_cast<double>(i) + (hexagonal && (j + k) % 2 == 1 ? 0.5 : 0.0)), y, z};
        if (x.x > last.x) break;
        if (exhausted(s)) return;
        for (int a = 0; a < 3; ++a) {
          if (spans(scene_.domain, g, a) && x[a] >= g.upper[a]) x[a] = g.lower[a];
        }
        const double r = next_radius(s);
        ++sites;
        const shapes::Quaternion turn = turn_of(s, state_[s].number);
        if (site.ask(shape, turn, x, r, 1 - 1e-9) != Site::Answer::free) continue;
        ++state_[s].drawn;
        site.occupy(shape, turn, x, r);
        deliver(s, x, r, out);
      }
    }
  }
  const std::int64_t placed = state_[s].number - before;
  const std::string wanted = source.number > 0 ? fmt::format(", {} were asked for", source.number)
                             : source.mass > 0 ? fmt::format(", {:g} kg were asked for", source.mass)
                                               : "";
  if (wanted.empty() ? placed > 0 : exhausted(s)) return;
  throw Error(
      ErrorCode::scene,
      fmt::format("only {} particles fitted on the lattice{} ({} sites{})", placed, wanted, sites, site.walls_text()),
      fmt::format("source '{}'", source.name), "enlarge the region or leave out number and mass to fill it");
}

void Insertion::fill_random(std::size_t s, Site& site, NewParticles& out) {
  const Source& source = scene_.sources[s];
  SourceState& state = state_[s];
  // All sizes first; the largest are placed first, since they find no room later. The ids keep the order of the draws.
  std::vector<double> r;
  SourceState planned = state;
  while (!exhausted(s)) {
    r.push_back(next_radius(s));
    ++state.drawn;
    ++state.number;
    state.mass += mass_of(s, r.back());
  }
  planned.drawn = state.drawn;
  state = planned;
  std::vector<std::size_t> order(r.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return r[a] > r[b]; });

  const CounterRng rng(scene_.seed, s * k_purposes + k_position, static_cast<std::uint64_t>(state.batches));
  std::vector<Vec3> x(r.size());
  std::uint64_t draw = 0;
  double volume = 0;
  const BodyShape* shape = shape_of(s);
  for (std::size_t placed = 0; placed < order.size(); ++placed) {
    const std::size_t i = order[placed];
    const shapes::Quaternion turn = turn_of(s, state.number + static_cast<std::int64_t>(i));
    Site::Answer answer = Site::Answer::taken;
    site.in_wall = 0;
    // Only tries that other particles refuse tell that a pack is full.
    std::int64_t misses = std::int64_t{k_misses} * k_random_attempts;
    for (int attempt = 0; attempt < k_random_attempts && misses > 0 && answer != Site::Answer::free;) {
      x[i] = site.draw(rng, draw, r[i]);
      answer = site.ask(shape, turn, x[i], r[i]);
      if (answer == Site::Answer::taken)
        ++attempt;
      else
        --misses;
    }
    if (answer != Site::Answer::free)
      throw Error(ErrorCode::scene,
                  fmt::format("only {} of {} particles fitted at random (solid fraction {:.3f} of the region{})",
                              placed, order.size(), volume / talus::volume(source.region), site.walls_text()),
                  fmt::format("source '{}'", source.name),
                  "enlarge the region, ask for fewer particles, or use a lattice or a stream");
    volume += Body{r[i]}.volume();
    site.occupy(shape, turn, x[i], r[i]);
  }
  for (std::size_t i = 0; i < r.size(); ++i) deliver(s, x[i], r[i], out);
}

void Insertion::fill_stream(std::size_t s, Site& site, NewParticles& out) {
  const Source& source = scene_.sources[s];
  const Region& g = source.region;
  SourceState& state = state_[s];
  const bool by_mass = source.mass_rate > 0;
  // A batch brings what is due until the next one, the last one what is due until the end.
  const double left = source.end - (source.start + static_cast<double>(state.batches) * source.interval);
  const double time = left < source.interval * (1 - 1e-6) ? fmax2(left, 0.0) : source.interval;
  state.carry += (by_mass ? source.mass_rate : source.number_rate) * time;
  const CounterRng rng(scene_.seed, s * k_purposes + k_position, static_cast<std::uint64_t>(state.batches));
  std::uint64_t draw = 0;
  const std::int64_t before = state.number;
  const BodyShape* shape = shape_of(s);
  while (!exhausted(s)) {
    const double r = next_radius(s);
    const shapes::Quaternion turn = turn_of(s, state.number);
    const double price = by_mass ? mass_of(s, r) : 1;
    if (state.carry < price * (1 - 1e-9)) return;  // the rate does not owe it yet; rounding is forgiven
    Vec3 x;
    Site::Answer answer = Site::Answer::taken;
    int misses = k_stream_misses * k_stream_attempts;
    for (int attempt = 0; attempt < k_stream_attempts && misses > 0 && answer != Site::Answer::free;) {
      x = site.draw(rng, draw, r);
      answer = site.ask(shape, turn, x, r);
      // the rim of an upright cylinder always counted as a try: earlier runs keep their bits
      const bool counts =
          answer == Site::Answer::taken || (answer == Site::Answer::outside && g.shape == Region::Shape::box);
      if (counts)
        ++attempt;
      else
        --misses;
    }
    if (answer != Site::Answer::free) {  // the same size comes first next time: what is hard to place is not left out
      const std::int64_t placed = state.number - before;
      std::int64_t due = count_floor(state.carry / price * (1 + 1e-9));
      if (source.number > 0) due = std::min(due, source.number - state.number);
      shortfalls_.push_back({s, placed, placed + due});
      return;
    }
    ++state.drawn;
    state.carry -= price;
    site.occupy(shape, turn, x, r);
    deliver(s, x, r, out);
  }
}

}  // namespace talus
