// Sources of particles. Every draw is addressed by counters that are part of the saved state: sizes by the number of
// sizes drawn so far, positions by (batch, attempt), velocities by the number of particles delivered.
#include "core/insertion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>

#include "core/det_math.hpp"
#include "core/error.hpp"
#include "core/io/particle_file.hpp"
#include "core/overlap_grid.hpp"
#include "core/rng.hpp"

namespace talus {
namespace {

constexpr std::int64_t k_no_step = std::numeric_limits<std::int64_t>::max();
constexpr int k_random_attempts = 5000;  ///< random sequential packing stalls near a solid fraction of 0.36
constexpr int k_stream_attempts = 200;
enum Purpose : std::uint64_t { k_size, k_position, k_velocity, k_purposes };

std::string source_path(const Scene& scene, const Source& s) {
  if (s.file.starts_with('/') || scene.directory.empty()) return s.file;
  return scene.directory.ends_with('/') ? scene.directory + s.file : scene.directory + "/" + s.file;
}

/// A region covers a periodic axis as a whole: spheres may stick out through its ends.
bool spans(const Domain& d, const Region& g, int axis) {
  return d.periodic(axis) && g.lower[axis] <= d.lower[axis] && g.upper[axis] >= d.upper[axis];
}

std::size_t tiles_of(const Source& s) {
  std::size_t n = 1;
  for (int k : s.tile) n *= static_cast<std::size_t>(k);
  return n;
}

bool inside_cylinder(const Region& g, Vec3 x, double r) {
  if (!(g.radius > 0)) return true;
  const double dx = x.x - 0.5 * (g.lower.x + g.upper.x), dy = x.y - 0.5 * (g.lower.y + g.upper.y);
  const double free = g.radius - r;
  return free >= 0 && dx * dx + dy * dy <= free * free;
}

double solid_fraction(const Region& g, double volume) {
  const Vec3 e = g.upper - g.lower;
  return volume / (g.radius > 0 ? det::k_pi * (g.radius * g.radius) * e.z : e.x * e.y * e.z);
}

}  // namespace

/// Spheres near a region, periodic images included.
class Occupied {
 public:
  /// `largest` [m]: radius of the largest sphere that will be asked for.
  Occupied(const Domain& domain, Vec3 lower, Vec3 upper, double largest)
      : domain_(domain), lower_(lower), upper_(upper), largest_(largest), grid_(largest) {}

  void add(Vec3 x, double r, std::int32_t index = 0) {
    const double margin = r + largest_;
    Vec3 shifts[3];  // per axis: 0, -L, +L; only periodic axes use the last two
    int count[3];
    for (int k = 0; k < 3; ++k) {
      const double length = domain_.upper[k] - domain_.lower[k];
      count[k] = 0;
      for (double s : {0.0, -length, length}) {
        if (s != 0 && !domain_.periodic(k)) continue;
        const double y = x[k] + s;
        if (y >= lower_[k] - margin && y <= upper_[k] + margin) shifts[count[k]++][k] = y;
      }
    }
    for (int a = 0; a < count[0]; ++a)
      for (int b = 0; b < count[1]; ++b)
        for (int c = 0; c < count[2]; ++c) grid_.add({shifts[a].x, shifts[b].y, shifts[c].z}, r, index);
  }
  /// True if a sphere at x touches nothing; `scale` < 1 forgives rounding where sites touch by construction.
  bool free(Vec3 x, double r, double scale = 1 + 1e-12) const {
    return !grid_.any(x, r, [&](const OverlapGrid::Sphere& s, double d2) {
      const double sum = (r + s.r) * scale;
      return d2 < sum * sum;
    });
  }
  const OverlapGrid& grid() const { return grid_; }
  void reserve(std::size_t n) { grid_.reserve(n); }

 private:
  const Domain& domain_;
  Vec3 lower_, upper_;
  double largest_;
  OverlapGrid grid_;
};

Insertion::Insertion(const Scene& scene) : scene_(scene) {
  state_.resize(scene_.sources.size());
  files_.resize(scene_.sources.size());
  rows_.resize(scene_.sources.size());
  for (std::size_t s = 0; s < scene_.sources.size(); ++s) {
    const Source& source = scene_.sources[s];
    samplers_.emplace_back(source.size);
    if (source.kind == Source::Kind::file) {
      read_file(s);
      continue;
    }
    const auto refuse = [&](const std::string& what, const std::string& cure) {
      throw Error(ErrorCode::scene, what, fmt::format("source '{}'", source.name), cure);
    };
    if (!(source.size.smallest() > 0)) refuse("the smallest diameter is not positive", "diameters must be > 0");
    for (int k = 0; k < 3; ++k) {
      if (source.region.lower[k] < scene_.domain.lower[k] || source.region.upper[k] > scene_.domain.upper[k])
        refuse("the region reaches beyond the domain", "regions lie within the domain");
      const double room = source.region.upper[k] - source.region.lower[k];
      if (!spans(scene_.domain, source.region, k) && room < source.size.largest())
        refuse(fmt::format("the region is {:g} m wide, the largest particle {:g} m", room, source.size.largest()),
               "spheres must fit into the region as a whole");
    }
    if (source.region.radius > 0 && 2 * source.region.radius < source.size.largest())
      refuse("the cylinder is narrower than the largest particle", "spheres must fit into the region as a whole");
    if (source.kind == Source::Kind::random && source.number <= 0 && !(source.mass > 0))
      refuse("neither number nor mass is given", "a random pack needs one of them");
    if (source.kind == Source::Kind::stream && !(source.interval >= scene_.dt))
      refuse("the interval is shorter than a time step", "at most one batch per step is possible");
  }
}

void Insertion::read_file(std::size_t s) {
  const Source& source = scene_.sources[s];
  const std::string path = source_path(scene_, source);
  ParticleFile file = read_particle_file(path, scene_.materials);
  NewParticles& p = files_[s];
  const std::size_t n = file.size();
  constexpr std::size_t most = std::numeric_limits<std::int32_t>::max();
  if (tiles_of(source) > most / n)
    throw Error(ErrorCode::scene, fmt::format("{} tiles of {} particles are too many", tiles_of(source), n),
                fmt::format("source '{}': tile", source.name), fmt::format("allowed: {} particles in all", most));
  const bool tiled = tiles_of(source) > 1;
  const Vec3 size = tile_size(s);
  std::int16_t fixed_group = static_cast<std::int16_t>(source.group);
  for (std::size_t g = scene_.groups.size(); g-- > 0;) {
    if (scene_.groups[g].fixed_in_file) fixed_group = static_cast<std::int16_t>(g);
  }
  p.fixed = file.fixed.empty() ? std::vector<std::uint8_t>(n) : std::move(file.fixed);
  p.material = file.material.empty() ? std::vector<std::uint8_t>(n, static_cast<std::uint8_t>(source.material))
                                     : std::move(file.material);
  p.group.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    p.group[i] = p.fixed[i] ? fixed_group : static_cast<std::int16_t>(source.group);
    for (int k = 0; k < 3; ++k) {
      const double low = scene_.domain.lower[k];
      const double high = source.tile[static_cast<std::size_t>(k)] > 1 ? low + size[k] : scene_.domain.upper[k];
      double& x = file.x[i][k];
      if (x == high && scene_.domain.periodic(k)) x = low;
      if (x >= low && x <= high) continue;
      throw Error(ErrorCode::scene,
                  fmt::format("{} = {} lies outside the {}", "xyz"[k], x, tiled ? "first tile" : "domain"),
                  fmt::format("{}:{}", path, file.row[i]), fmt::format("allowed: {} to {}", low, high));
    }
  }
  p.x = std::move(file.x);
  p.v = std::move(file.v);
  p.w = std::move(file.w);
  p.r = std::move(file.r);
  rows_[s] = std::move(file.row);
}

Vec3 Insertion::tile_size(std::size_t s) const {
  Vec3 size;
  for (int k = 0; k < 3; ++k)
    size[k] = (scene_.domain.upper[k] - scene_.domain.lower[k]) / scene_.sources[s].tile[static_cast<std::size_t>(k)];
  return size;
}

/// The file's particles, then its copies: x varies slowest.
void Insertion::append_tiles(std::size_t s, NewParticles& out) const {
  const NewParticles& f = files_[s];
  const std::array<int, 3>& tile = scene_.sources[s].tile;
  const Vec3 size = tile_size(s);
  const auto append = [](auto& to, const auto& more) { to.insert(to.end(), more.begin(), more.end()); };
  for (int a = 0; a < tile[0]; ++a) {
    for (int b = 0; b < tile[1]; ++b) {
      for (int c = 0; c < tile[2]; ++c) {
        const Vec3 shift{a * size.x, b * size.y, c * size.z};
        for (const Vec3& x : f.x) {
          Vec3 y = x + shift;
          // rounding must not carry the last tile through the domain's end
          for (int k = 0; k < 3; ++k) y[k] = fmin2(y[k], scene_.domain.upper[k]);
          out.x.push_back(y);
        }
        append(out.v, f.v);
        append(out.w, f.w);
        append(out.r, f.r);
        append(out.material, f.material);
        append(out.fixed, f.fixed);
        append(out.group, f.group);
      }
    }
  }
}

/// "file:row" of a particle of the initial files, with its tile where there are several.
std::string Insertion::place_in_file(std::size_t particle) const {
  std::size_t s = 0;
  while (particle >= files_[s].size() * tiles_of(scene_.sources[s])) {
    particle -= files_[s].size() * tiles_of(scene_.sources[s]);
    ++s;
  }
  const Source& source = scene_.sources[s];
  const std::size_t n = files_[s].size(), copy = particle / n;
  std::string place = fmt::format("{}:{}", source.file, rows_[s][particle % n]);
  if (tiles_of(source) > 1) {
    const auto ny = static_cast<std::size_t>(source.tile[1]), nz = static_cast<std::size_t>(source.tile[2]);
    place += fmt::format(" (tile {}, {}, {})", copy / (ny * nz), copy / nz % ny, copy % nz);
  }
  return place;
}

void Insertion::check_overlaps(const NewParticles& p) const {
  // Beds at rest hold real static overlaps, so a share of the radius is always accepted.
  // A relaxing start takes any overlap except coincident centres, which have no direction to part in.
  const bool relaxes = scene_.relax.steps > 0;
  const double allowed =
      relaxes ? k_never : (scene_.allow_initial_overlap ? scene_.max_overlap : fmin2(0.05, scene_.max_overlap));
  struct Pair {
    std::int32_t a, b;
    double depth, share;
  };
  std::vector<Pair> pairs;
  double largest = 0;
  for (double r : p.r) largest = fmax2(largest, r);
  Occupied occupied(scene_.domain, scene_.domain.lower, scene_.domain.upper, largest);
  occupied.reserve(p.size() + p.size() / 8);
  // Files come in any order; walking through space in rows of cells keeps the neighbours in the cache.
  std::vector<std::pair<std::uint64_t, std::int32_t>> order(p.size());
  for (std::size_t i = 0; i < p.size(); ++i) {
    std::uint64_t key = 0;
    for (int k = 2; k >= 0; --k) {
      const double c = fmin2((p.x[i][k] - scene_.domain.lower[k]) / (2 * largest), 2097151);
      key = key << 21 | static_cast<std::uint64_t>(det::floor_int(c));
    }
    order[i] = {key, static_cast<std::int32_t>(i)};
  }
  std::sort(order.begin(), order.end());
  constexpr std::size_t enough = 1000;
  for (std::size_t n = 0; n < p.size() && pairs.size() < enough; ++n) {
    const std::int32_t index = order[n].second;
    const auto i = static_cast<std::size_t>(index);
    occupied.grid().any(p.x[i], p.r[i], [&](const OverlapGrid::Sphere& s, double d2) {
      const double sum = p.r[i] + s.r;
      if (d2 >= sum * sum) return false;
      const double depth = sum - std::sqrt(d2), share = depth / fmin2(p.r[i], s.r);
      if (share > allowed || (relaxes && d2 == 0))
        pairs.push_back({std::min(s.index, index), std::max(s.index, index), depth, share});
      return pairs.size() >= enough;
    });
    occupied.add(p.x[i], p.r[i], index);
  }
  if (pairs.empty()) return;
  const auto key = [](const Pair& q) { return std::pair(q.a, q.b); };
  std::sort(pairs.begin(), pairs.end(), [&](const Pair& q, const Pair& o) { return key(q) < key(o); });
  pairs.erase(std::unique(pairs.begin(), pairs.end(), [&](const Pair& q, const Pair& o) { return key(q) == key(o); }),
              pairs.end());
  const auto place = [&](std::int32_t i) { return place_in_file(static_cast<std::size_t>(i)); };
  std::string list;
  for (std::size_t k = 0; k < pairs.size() && k < 5; ++k)
    list += fmt::format("{}{} and {} by {:.4g} m ({:.3g} of the smaller radius)", k == 0 ? "" : "; ", place(pairs[k].a),
                        place(pairs[k].b), pairs[k].depth, pairs[k].share);
  if (relaxes)
    throw Error(ErrorCode::scene,
                fmt::format("{}{} pairs of coincident centres, which have no direction to part in: {}",
                            pairs.size() >= enough ? "at least " : "", pairs.size(), list),
                place(pairs[0].a), "move one particle of each pair by any amount; [relax] parts them from there");
  throw Error(ErrorCode::scene,
              fmt::format("{}{} initial overlaps deeper than {:g} of the smaller radius: {}",
                          pairs.size() >= enough ? "at least " : "", pairs.size(), allowed, list),
              place(pairs[0].a),
              "separate the particles, part them with relax.steps, or set checks.allow_initial_overlap and "
              "checks.max_overlap");
}

NewParticles Insertion::initial() {
  NewParticles out;
  std::size_t total = 0;
  for (std::size_t s = 0; s < scene_.sources.size(); ++s) total += files_[s].size() * tiles_of(scene_.sources[s]);
  out.x.reserve(total);
  out.v.reserve(total);
  out.w.reserve(total);
  out.r.reserve(total);
  out.material.reserve(total);
  out.fixed.reserve(total);
  out.group.reserve(total);
  for (std::size_t s = 0; s < scene_.sources.size(); ++s) {
    append_tiles(s, out);
    state_[s].number += static_cast<std::int64_t>(files_[s].size() * tiles_of(scene_.sources[s]));
  }
  if (out.size() > 0) check_overlaps(out);
  for (std::size_t s = 0; s < scene_.sources.size(); ++s) {
    const Source& source = scene_.sources[s];
    if ((source.kind == Source::Kind::lattice || source.kind == Source::Kind::random) && source.start <= 0)
      fill(s, out, {}, out);
  }
  inserted_ += static_cast<std::int64_t>(out.size());
  return out;
}

double Insertion::next_radius(std::size_t s) const {
  const CounterRng rng(scene_.seed, s * k_purposes + k_size);
  return 0.5 * samplers_[s].diameter(rng.uniform(static_cast<std::uint64_t>(state_[s].drawn)));
}

double Insertion::mass_of(std::size_t s, double r) const {
  const double density = scene_.materials[static_cast<std::size_t>(scene_.sources[s].material)].density;
  return density * (4.0 / 3.0 * det::k_pi) * (r * r * r);
}

/// The limits by number and mass are reached; the mass ends nearest to its target.
bool Insertion::exhausted(std::size_t s) const {
  const Source& source = scene_.sources[s];
  if (source.number > 0 && state_[s].number >= source.number) return true;
  return source.mass > 0 && state_[s].mass + 0.5 * mass_of(s, next_radius(s)) > source.mass;
}

std::int64_t Insertion::due_step(std::size_t s, std::int64_t n) const {
  const Source& source = scene_.sources[s];
  const double dt = scene_.dt;
  if (source.kind == Source::Kind::lattice || source.kind == Source::Kind::random) {
    const std::int64_t step = det::nearest(source.start / dt);
    return source.start > 0 && state_[s].batches == 0 && step >= n ? step : k_no_step;
  }
  if (source.kind != Source::Kind::stream || exhausted(s)) return k_no_step;
  // Batch k is due at round((start + k interval) / step); begin two batches early against rounding.
  std::int64_t k = det::floor_int((static_cast<double>(n) * dt - source.start) / source.interval) - 2;
  for (k = k < 0 ? 0 : k;; ++k) {
    const double time = source.start + static_cast<double>(k) * source.interval;
    // The last batch lies clearly before the end, whatever k * interval rounds to.
    if (!(time < source.end - 1e-6 * source.interval)) return k_no_step;
    const std::int64_t step = det::nearest(time / dt);
    if (step >= n) return step;
  }
}

std::int64_t Insertion::next_step(std::int64_t n) const {
  std::int64_t first = k_no_step;
  for (std::size_t s = 0; s < scene_.sources.size(); ++s) first = std::min(first, due_step(s, n));
  return first;
}

NewParticles Insertion::batch(std::int64_t n, const PresentParticles& present) {
  NewParticles out;
  for (std::size_t s = 0; s < scene_.sources.size(); ++s) {
    if (due_step(s, n) == n) fill(s, out, present, out);
  }
  inserted_ += static_cast<std::int64_t>(out.size());
  return out;
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
  out.x.push_back(x);
  out.v.push_back(v);
  out.w.push_back({});
  out.r.push_back(r);
  out.material.push_back(static_cast<std::uint8_t>(source.material));
  out.fixed.push_back(0);
  out.group.push_back(static_cast<std::int16_t>(source.group));
  ++state.number;
  state.mass += mass_of(s, r);
}

void Insertion::fill(std::size_t s, const NewParticles& before, const PresentParticles& present, NewParticles& out) {
  const Source& source = scene_.sources[s];
  // Grains already there may be far larger than the source's: in its finest cells one of them widens every search.
  double largest = 0.5 * source.size.largest();
  for (std::size_t i = 0; i < present.size(); ++i)
    if (present.rows[4 * i] <= 1e100) largest = fmax2(largest, present.rows[4 * i + 3]);
  for (const double r : before.r) largest = fmax2(largest, r);
  Occupied occupied(scene_.domain, source.region.lower, source.region.upper, largest);
  for (std::size_t i = 0; i < present.size(); ++i) {
    const double* row = &present.rows[4 * i];
    if (row[0] > 1e100) continue;
    occupied.add(Vec3{row[0], row[1], row[2]} + scene_.domain.lower, row[3]);
  }
  for (std::size_t i = 0; i < before.size(); ++i) occupied.add(before.x[i], before.r[i]);
  if (source.kind == Source::Kind::lattice) fill_lattice(s, occupied, out);
  if (source.kind == Source::Kind::random) fill_random(s, occupied, out);
  if (source.kind == Source::Kind::stream) fill_stream(s, occupied, out);
  ++state_[s].batches;
}

void Insertion::fill_lattice(std::size_t s, Occupied& occupied, NewParticles& out) {
  const Source& source = scene_.sources[s];
  const Region& g = source.region;
  const double largest = source.size.largest(), pitch = source.spacing * largest;
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
        if (!inside_cylinder(g, x, r) || !occupied.free(x, r, 1 - 1e-9)) continue;
        ++state_[s].drawn;
        occupied.add(x, r);
        deliver(s, x, r, out);
      }
    }
  }
  if ((source.number > 0 || source.mass > 0) && !exhausted(s))
    throw Error(ErrorCode::scene,
                fmt::format("only {} particles fitted on the lattice, {} were asked for", state_[s].number - before,
                            source.number > 0 ? std::to_string(source.number) : fmt::format("{:g} kg", source.mass)),
                fmt::format("source '{}'", source.name), "enlarge the region or leave out number and mass to fill it");
}

void Insertion::fill_random(std::size_t s, Occupied& occupied, NewParticles& out) {
  const Source& source = scene_.sources[s];
  const Region& g = source.region;
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
  for (std::size_t placed = 0; placed < order.size(); ++placed) {
    const std::size_t i = order[placed];
    bool fits = false;
    for (int attempt = 0; attempt < k_random_attempts && !fits; ++attempt) {
      for (int k = 0; k < 3; ++k) {
        const bool whole = spans(scene_.domain, g, k);
        const double low = whole ? g.lower[k] : g.lower[k] + r[i], high = whole ? g.upper[k] : g.upper[k] - r[i];
        x[i][k] = rng.uniform(draw++, low, high);
        if (whole && x[i][k] >= high) x[i][k] = low;
      }
      fits = inside_cylinder(g, x[i], r[i]) && occupied.free(x[i], r[i]);
    }
    if (!fits)
      throw Error(ErrorCode::scene,
                  fmt::format("only {} of {} particles fitted at random (solid fraction {:.3f} of the region)", placed,
                              order.size(), solid_fraction(g, volume)),
                  fmt::format("source '{}'", source.name),
                  "enlarge the region, ask for fewer particles, or use a lattice or a stream");
    volume += 4.0 / 3.0 * det::k_pi * (r[i] * r[i] * r[i]);
    occupied.add(x[i], r[i]);
  }
  for (std::size_t i = 0; i < r.size(); ++i) deliver(s, x[i], r[i], out);
}

void Insertion::fill_stream(std::size_t s, Occupied& occupied, NewParticles& out) {
  const Source& source = scene_.sources[s];
  const Region& g = source.region;
  SourceState& state = state_[s];
  const bool by_mass = source.mass_rate > 0;
  state.carry += (by_mass ? source.mass_rate : source.number_rate) * source.interval;
  const CounterRng rng(scene_.seed, s * k_purposes + k_position, static_cast<std::uint64_t>(state.batches));
  std::uint64_t draw = 0;
  while (!exhausted(s)) {
    const double r = next_radius(s);
    const double price = by_mass ? mass_of(s, r) : 1;
    if (state.carry < price * (1 - 1e-9)) return;  // the rate does not owe it yet; rounding is forgiven
    Vec3 x;
    bool fits = false;
    for (int attempt = 0; attempt < k_stream_attempts && !fits; ++attempt) {
      for (int k = 0; k < 3; ++k) {
        const bool whole = spans(scene_.domain, g, k);
        const double low = whole ? g.lower[k] : g.lower[k] + r, high = whole ? g.upper[k] : g.upper[k] - r;
        x[k] = rng.uniform(draw++, low, high);
        if (whole && x[k] >= high) x[k] = low;
      }
      fits = inside_cylinder(g, x, r) && occupied.free(x, r);
    }
    if (!fits) return;  // the same size comes first next time: what is hard to place is not left out
    ++state.drawn;
    state.carry -= price;
    occupied.add(x, r);
    deliver(s, x, r, out);
  }
}

std::vector<char> Insertion::materials() const {
  std::vector<char> used(scene_.materials.size(), 0);
  for (std::size_t s = 0; s < scene_.sources.size(); ++s) {
    if (scene_.sources[s].kind != Source::Kind::file) used[static_cast<std::size_t>(scene_.sources[s].material)] = 1;
    for (const std::uint8_t m : files_[s].material) used[m] = 1;
  }
  return used;
}

double Insertion::smallest_radius() const {
  double smallest = k_never;
  for (std::size_t s = 0; s < scene_.sources.size(); ++s) {
    if (scene_.sources[s].kind != Source::Kind::file)
      smallest = fmin2(smallest, 0.5 * scene_.sources[s].size.smallest());
    for (double r : files_[s].r) smallest = fmin2(smallest, r);
  }
  return smallest == k_never ? 0 : smallest;
}

double Insertion::largest_radius() const {
  double largest = 0;
  for (std::size_t s = 0; s < scene_.sources.size(); ++s) {
    if (scene_.sources[s].kind != Source::Kind::file) largest = fmax2(largest, 0.5 * scene_.sources[s].size.largest());
    for (double r : files_[s].r) largest = fmax2(largest, r);
  }
  return largest;
}

std::vector<std::uint8_t> Insertion::save() const {
  std::vector<std::uint8_t> bytes;
  const auto put = [&](const auto& value) {
    const auto* p = reinterpret_cast<const std::uint8_t*>(&value);
    bytes.insert(bytes.end(), p, p + sizeof(value));
  };
  put(static_cast<std::uint64_t>(state_.size()));
  put(inserted_);
  for (const SourceState& s : state_) {
    put(s.drawn);
    put(s.number);
    put(s.mass);
    put(s.batches);
    put(s.carry);
  }
  return bytes;
}

void Insertion::load(std::span<const std::uint8_t> bytes) {
  std::size_t at = 0;
  const auto get = [&](auto& value) {
    std::memcpy(&value, bytes.data() + at, sizeof(value));
    at += sizeof(value);
  };
  std::uint64_t count = 0;
  if (bytes.size() >= sizeof(count)) get(count);
  if (count != state_.size() || bytes.size() != 16 + 40 * state_.size())
    throw Error(ErrorCode::io,
                fmt::format("the saved state of the sources does not fit the scene's {} sources", state_.size()),
                "section 'insertion'", "resume with the scene that wrote the checkpoint");
  get(inserted_);
  for (SourceState& s : state_) {
    get(s.drawn);
    get(s.number);
    get(s.mass);
    get(s.batches);
    get(s.carry);
  }
}

}  // namespace talus
