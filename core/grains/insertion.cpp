// Sources of particles: what is due when, how much of it is left, and the saved state. Placing is in
// insertion_fill.cpp, initial files in insertion_file.cpp, what can never fit in insertion_limits.cpp.
#include "core/grains/insertion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <limits>

#include "core/base/count.hpp"
#include "core/base/det_math.hpp"
#include "core/base/error.hpp"
#include "core/grains/region.hpp"
#include "core/grains/source_walls.hpp"

namespace talus {
namespace {

constexpr std::int64_t k_no_step = std::numeric_limits<std::int64_t>::max();

}  // namespace

Insertion::Insertion(const Scene& scene) : scene_(scene) {
  state_.resize(scene_.sources.size());
  files_.resize(scene_.sources.size());
  rows_.resize(scene_.sources.size());
  require_loaded(scene_);
  set_natural_sizes(scene_);
  for (std::size_t s = 0; s < scene_.sources.size(); ++s) {
    const Source& source = scene_.sources[s];
    samplers_.emplace_back(source.size);
    if (source.kind == Source::Kind::file) {
      read_file(s);
      continue;
    }
    check_region(s);
    if (source.kind == Source::Kind::random && source.number <= 0 && !(source.mass > 0))
      throw Error(ErrorCode::scene, "neither number nor mass is given", fmt::format("source '{}'", source.name),
                  "a random pack needs one of them");
    if (source.kind == Source::Kind::stream && !(source.interval >= scene_.dt))
      throw Error(ErrorCode::scene, "the interval is shorter than a time step", fmt::format("source '{}'", source.name),
                  "at most one batch per step is possible");
  }
  check_memory();
  const auto one_sided = [](const Source& s) { return s.closed_walls != Source::ClosedWalls::both; };
  if (std::none_of(scene_.sources.begin(), scene_.sources.end(), one_sided)) return;
  closed_ = std::make_unique<const ClosedWalls>(scene_);
  for (const Source& s : scene_.sources)
    if (s.closed_walls == Source::ClosedWalls::inside && !closed_->any())
      throw Error(ErrorCode::scene, "closed_walls = \"inside\", but no wall is closed",
                  fmt::format("source '{}'", s.name), "a box or a watertight mesh encloses a volume");
}

Insertion::~Insertion() = default;

NewParticles Insertion::initial(const WallSet* walls) {
  NewParticles out;
  std::size_t total = 0;
  for (std::size_t s = 0; s < scene_.sources.size(); ++s) total += files_[s].size() * tiles(s);
  out.x.reserve(total);
  out.v.reserve(total);
  out.w.reserve(total);
  out.r.reserve(total);
  out.material.reserve(total);
  out.fixed.reserve(total);
  out.group.reserve(total);
  out.source.reserve(total);
  for (std::size_t s = 0; s < scene_.sources.size(); ++s) {
    append_tiles(s, out);
    state_[s].number += files_[s].grains() * static_cast<std::int64_t>(tiles(s));
  }
  if (out.size() > 0) check_overlaps(out, SourceWalls(scene_.domain, walls));
  for (std::size_t s = 0; s < scene_.sources.size(); ++s) {
    const Source& source = scene_.sources[s];
    if ((source.kind == Source::Kind::lattice || source.kind == Source::Kind::random) && source.start <= 0)
      fill(s, out, {}, walls, out);
  }
  inserted_ += out.grains();
  return out;
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

NewParticles Insertion::batch(std::int64_t n, const PresentParticles& present, const WallSet* walls) {
  NewParticles out;
  shortfalls_.clear();
  const std::vector<SourceState> before = state_;
  try {
    for (std::size_t s = 0; s < scene_.sources.size(); ++s) {
      if (due_step(s, n) == n) fill(s, out, present, walls, out);
    }
  } catch (...) {  // nothing of this batch is delivered: whoever goes on from here finds it still to come
    state_ = before;
    throw;
  }
  inserted_ += out.grains();
  return out;
}

const BodyShape* Insertion::shape_of(std::size_t s) const {
  const int shape = scene_.sources[s].shape;
  return shape < 0 || scene_.sources[s].kind == Source::Kind::file
             ? nullptr
             : scene_.shapes[static_cast<std::size_t>(shape)].body.get();
}

const BodyShape& Insertion::shape_of(const NewBody& b) const {
  return *scene_.shapes[static_cast<std::size_t>(b.shape)].body;
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
      smallest = fmin2(smallest, 0.5 * scene_.sources[s].size.smallest() * smallest_share(scene_, s));
    for (double r : files_[s].r) smallest = fmin2(smallest, r);
    for (const NewBody& b : files_[s].bodies) smallest = fmin2(smallest, b.scale * shape_of(b).smallest);
  }
  return smallest == k_never ? 0 : smallest;
}

double Insertion::largest_radius() const {
  double largest = 0;
  for (std::size_t s = 0; s < scene_.sources.size(); ++s) {
    if (scene_.sources[s].kind != Source::Kind::file)
      largest = fmax2(largest, 0.5 * scene_.sources[s].size.largest() * largest_share(scene_, s));
    for (double r : files_[s].r) largest = fmax2(largest, r);
  }
  return largest;
}

double Insertion::largest_reach() const {
  double largest = largest_radius();
  for (std::size_t s = 0; s < scene_.sources.size(); ++s)
    if (const BodyShape* c = shape_of(s))
      largest = fmax2(largest, 0.5 * scene_.sources[s].size.largest() * (c->bound / c->equal_radius));
  for (const NewParticles& p : files_)
    for (const NewBody& b : p.bodies) largest = fmax2(largest, b.scale * shape_of(b).bound);
  return largest;
}

bool Insertion::any_fixed() const {
  for (const NewParticles& p : files_)
    if (std::any_of(p.fixed.begin(), p.fixed.end(), [](std::uint8_t f) { return f != 0; })) return true;
  return false;
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

void Insertion::check_state() const {
  bool good = inserted_ >= 0 && inserted_ <= k_most_count;
  for (const SourceState& s : state_) {
    for (const std::int64_t count : {s.drawn, s.number, s.batches}) good = good && count >= 0 && count <= k_most_count;
    // what is owed may grow without limit where there is no room, and falls below zero by rounding
    good = good && s.mass >= 0 && s.mass < k_never && s.carry > -1 && s.carry < k_never;
  }
  if (!good)
    throw Error(ErrorCode::io, "no run can have left such numbers of its sources", "section 'insertion'",
                "resume from another checkpoint of this scene");
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
  check_state();
}

}  // namespace talus
