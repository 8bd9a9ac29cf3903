// Storage of particles and contacts: capacity, insertion, removal, chunks, and the order-free view of the state that
// sort epochs, checkpoints and hashes share. Invariants: I2 (removal), I5, I6.
#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <cstring>
#include <tuple>

#include "core/base/det_math.hpp"
#include "core/base/error.hpp"
#include "core/base/memory.hpp"
#include "scheduler/step/world.hpp"

namespace talus {

double World::mass(Row i) const {
  const double r = p[4L * i + 3];
  const double rho = scene.materials[has.materials ? material[i] : 0].density;
  return rho * (4.0 / 3.0 * det::k_pi) * (r * r * r);
}

Vec3 World::gravity_along(bool periodic) const {
  Vec3 g = gravity;
  for (int k = 0; k < 3; ++k)
    if (scene.domain.periodic(k) != periodic) g[k] = 0;
  return g;
}

double World::row_energy(Row i) const {
  const double* u = v.data() + static_cast<long>(stride) * i;
  const double m = mass(i);
  // the row holds v(n-1/2); what gravity adds on the way to n is known, what contacts do is not. At the start v(0).
  const bool exact = (step == 0 && scene.integrator == Integrator::velocity_verlet) || !(u[stride - 1] > 0);
  const Vec3 now = Vec3{u[0], u[1], u[2]} + (exact ? 0.0 : 0.5 * scene.dt) * gravity;
  double e = 0.5 * m * norm2(now);
  if (has.rotation) e += 0.2 * m * ((u[4] * u[4] + u[5] * u[5]) + u[6] * u[6]);
  return u[stride - 1] > 0 ? e - m * dot(gravity_along(false), position(i)) : e;
}

Vec3 World::position(Row i) const {
  const double* x = p.data() + 4L * i;
  return Vec3{x[0], x[1], x[2]} + scene.domain.lower;
}

void set_particle_capacity(World& w, Row n) {
  const Row old = w.n;
  const auto rows = static_cast<std::size_t>(n) + k_pad;
  w.p.resize(4 * rows);
  w.p2.resize(4 * rows);
  w.x0.resize(4 * rows);
  w.v.resize(w.stride * rows);
  w.v2.resize(w.stride * rows);
  w.id.resize(rows);
  if (w.has.materials) w.material.resize(rows);
  if (w.has.fixed) w.fixed.resize(rows);
  if (w.has.groups) w.group.resize(rows);
  if (w.has.energies) w.energy.resize(4 * rows);
  if (w.skin.policy == ListPolicy::velocity_profile) w.drift.resize(4 * rows);
  if (w.skin.policy == ListPolicy::displacement_history) w.next_skin.resize(rows);
  if (w.skin.cuts()) w.outer.resize(4 * rows), w.near.resize(4 * rows);
  for (Row i = std::min(old, n); i < static_cast<Row>(rows); ++i) {  // new and padding rows: dead
    for (auto* p : {&w.p, &w.p2, &w.x0})
      for (int k = 0; k < 4; ++k) (*p)[4L * i + k] = k < 3 ? k_gone : 0.0;
    w.x0[4L * i + 3] = 1e300;
    for (auto* p : {&w.outer, &w.near})
      for (int k = 0; k < 4 && w.skin.cuts(); ++k) (*p)[4L * i + k] = k < 3 ? k_gone : 0.0;
    for (auto* v : {&w.v, &w.v2}) {
      for (int k = 0; k < w.stride; ++k) (*v)[static_cast<long>(w.stride) * i + k] = 0.0;
      (*v)[static_cast<long>(w.stride) * i + w.stride - 1] = 1.0;  // padding lanes divide by it
    }
    w.id[i] = -1;
    if (w.has.materials) w.material[i] = 0;
    if (w.has.fixed) w.fixed[i] = 0;
    if (w.has.groups) w.group[i] = -1;
    if (w.has.energies)
      for (int k = 0; k < 4; ++k) w.energy[4L * i + k] = 0;
  }
  w.n = n;
}

/// Judges the memory that the columns take when they must grow: vectors double.
void require_room(const World& w, std::size_t rows) {
  constexpr double row = 250;  // [B] of all columns
  const std::size_t room = w.p.capacity() / 4;
  if (rows <= room) return;
  const double more = static_cast<double>(std::max(rows, 2 * room)) - 0.5 * static_cast<double>(room);
  require_memory(row * more, fmt::format("room for {} particles", rows), fmt::format("step {}", w.step),
                 "let the sources deliver fewer", ErrorCode::physics);
}

void append_particles(World& w, const NewParticles& a, bool initial) {
  const Row first = w.n;
  if (static_cast<std::int64_t>(first) + static_cast<std::int64_t>(a.size()) > (std::int64_t{1} << 30))
    throw Error(ErrorCode::physics, "more than 2^30 particles", "step " + std::to_string(w.step));
  require_room(w, static_cast<std::size_t>(first) + a.size());
  set_particle_capacity(w, first + static_cast<Row>(a.size()));
  // a grain born at step n carries v(n-1/2) = v - g dt/2
  const double half = w.step == 0 ? 0.0 : 0.5 * w.scene.dt;
  for (std::size_t q = 0; q < a.size(); ++q) {
    const Row i = first + static_cast<Row>(q);
    const Vec3 x = a.x[q] - w.scene.domain.lower;
    for (auto* p : {&w.p, &w.p2}) {
      double* r = p->data() + 4L * i;
      r[0] = x.x;
      r[1] = x.y;
      r[2] = x.z;
      r[3] = a.r[q];
    }
    w.id[i] = w.next_id++;
    if (w.has.materials) w.material[i] = a.material[q];
    const bool fixed = a.fixed[q] != 0;
    if (w.has.fixed) w.fixed[i] = fixed ? 1 : 0;
    if (w.has.groups) w.group[i] = a.group[q];
    const double m = w.mass(i);
    const Vec3 v = fixed ? a.v[q] : a.v[q] - half * w.gravity;
    for (auto* column : {&w.v, &w.v2}) {
      double* r = column->data() + static_cast<long>(w.stride) * i;
      r[0] = v.x;
      r[1] = v.y;
      r[2] = v.z;
      if (w.has.rotation) {
        r[3] = 0;
        r[4] = a.r[q] * a.w[q].x;
        r[5] = a.r[q] * a.w[q].y;
        r[6] = a.r[q] * a.w[q].z;
      }
      r[w.stride - 1] = fixed ? 0.0 : 1.0 / m;
    }
    if (w.has.energies && !initial)  // at n; the row holds the velocity of half a step before
      w.inserted_energy += 0.5 * m * norm2(a.v[q]) + 0.2 * m * a.r[q] * a.r[q] * norm2(a.w[q]) -
                           (fixed ? 0 : m * dot(w.gravity_along(false), a.x[q]));
  }
  w.alive += static_cast<Row>(a.size());
}

void need_chunks(World& w, int count) {
  while (static_cast<int>(w.chunks.size()) < count) {
    w.chunks.push_back(std::make_unique<Chunk>());
    w.chunks.back()->index = static_cast<int>(w.chunks.size()) - 1;
  }
}

void make_chunks(World& w) {
  const int count = w.chunk_of.count(w.n);
  need_chunks(w, count);
  w.chunks.resize(static_cast<std::size_t>(count));
  // chunks of a chosen size are not smaller than what pays a thread; who asks for a size asks for the threads, too
  if (w.options.chunk == 0) w.lane_choice.limit(count);
  for (int k = 0; k < count; ++k) {
    Chunk& c = *w.chunks[static_cast<std::size_t>(k)];
    c.lo = w.chunk_of.lo(k);
    c.hi = w.chunk_of.hi(k, w.n);
  }
}

void remove_row(World& w, Row i) {
  if (!w.is_alive(i)) return;
  const double m = w.mass(i);
  ++w.counters.removed;
  w.counters.removed_mass += m;
  --w.alive;
  double* v = w.v.data() + static_cast<long>(w.stride) * i;
  if (w.has.energies) w.inserted_energy -= w.row_energy(i);
  for (auto* p : {&w.p, &w.x0})
    for (int k = 0; k < 3; ++k) (*p)[4L * i + k] = k_gone;
  w.p[4L * i + 3] = 0;
  w.x0[4L * i + 3] = 1e300;
  for (int k = 0; k < w.stride; ++k) v[k] = 0;
}

std::vector<ContactEntry> contacts_of(const World& w, const Chunk& c) {
  std::vector<ContactEntry> out;
  std::size_t n = 0;
  // a step that failed half way may have new masks and old columns
  const auto known = [&](int k) { return !w.failed.load(std::memory_order_relaxed) || n < c.h[k].size(); };
  for (std::int64_t s = 0; s < c.end[2]; ++s) {
    if (((c.mask[static_cast<std::size_t>(s >> 3)] >> (s & 7)) & 1U) == 0) continue;
    if (c.pi[static_cast<std::size_t>(s)] < c.pj[static_cast<std::size_t>(s)]) {
      ContactEntry e;
      e.a = c.pi[static_cast<std::size_t>(s)];
      e.b = c.pj[static_cast<std::size_t>(s)];
      for (int k = 0; k < w.has.history_columns; ++k) e.h[k] = known(k) ? c.h[k][n] : 0;
      out.push_back(e);
    }
    ++n;
  }
  // in every chunk a is one of its own rows: chunk after chunk the pairs ascend, whatever the chunks
  std::sort(out.begin(), out.end(),
            [](const ContactEntry& l, const ContactEntry& r) { return std::tie(l.a, l.b) < std::tie(r.a, r.b); });
  return out;
}

std::vector<WallEntry> collect_wall_states(const World& w) {
  std::vector<WallEntry> out;
  for (const auto& c : w.chunks) {
    const auto columns = static_cast<std::size_t>(w.has.moment_columns);
    for (std::size_t k = 0; k < c->wall_state.size(); ++k) {
      WallEntry e;
      static_cast<WallState&>(e) = c->wall_state[k];
      for (std::size_t q = 0; q < columns; ++q) e.m[q] = c->wall_moment[k * columns + q];
      out.push_back(e);
    }
  }
  return out;
}

std::uint64_t state_hash(const World& w) {
  std::uint64_t sum = 0;
  for (Row i = 0; i < w.n; ++i) {
    if (!w.is_alive(i)) continue;
    struct {
      ParticleId id;
      double x[4], v[8];
    } t{};
    t.id = w.id[i];
    std::memcpy(t.x, w.p.data() + 4L * i, sizeof t.x);
    std::memcpy(t.v, w.v.data() + static_cast<long>(w.stride) * i, sizeof(double) * static_cast<std::size_t>(w.stride));
    sum += XXH3_64bits(&t, sizeof t);
  }
  if (w.has.history_columns > 0 || w.has.adhesion) {  // a neck beyond touch is state, with or without history
    const std::size_t unused =
        static_cast<std::size_t>(k_max_history - std::max(w.has.law_columns, k_usual_history)) * sizeof(double);
    const auto add_contact = [&](const ContactEntry& e) {
      if (!w.is_alive(e.a) || !w.is_alive(e.b)) return;
      struct {
        ParticleId a, b;
        double h[k_max_history];
      } t{};
      const bool flip = w.id[e.a] > w.id[e.b];
      t.a = w.id[flip ? e.b : e.a];
      t.b = w.id[flip ? e.a : e.b];
      for (int k = 0; k < w.has.law_columns; ++k) t.h[k] = flip && w.flips(k) ? -e.h[k] : e.h[k];
      sum += XXH3_64bits(&t, sizeof t - unused);
      if (w.has.moments) {
        double m[k_max_moment + 2] = {};
        std::memcpy(m, &t.a, sizeof t.a);
        std::memcpy(m + 1, &t.b, sizeof t.b);
        for (int k = 0; k < w.has.moment_columns; ++k) {
          const int q = w.has.law_columns + k;
          m[k + 2] = flip && w.flips(q) ? -e.h[q] : e.h[q];
        }
        sum += XXH3_64bits_withSeed(m, sizeof m, 4);
      }
    };
    for (const auto& c : w.chunks)
      for (const ContactEntry& e : contacts_of(w, *c)) add_contact(e);
    for (const WallEntry& s : collect_wall_states(w)) {
      if (!w.is_alive(s.row)) continue;
      struct {
        ParticleId id;
        std::int64_t wall;
        double h[k_max_history];
      } t{};
      t.id = w.id[s.row];
      t.wall = -1 - s.contact.wall;
      for (int k = 0; k < w.has.law_columns; ++k) t.h[k] = s.h[k];
      sum += XXH3_64bits(&t, sizeof t - unused);
      if (w.has.moments) {
        double m[k_max_moment + 2] = {};
        std::memcpy(m, &t.id, sizeof t.id);
        std::memcpy(m + 1, &t.wall, sizeof t.wall);
        for (int k = 0; k < w.has.moment_columns; ++k) m[k + 2] = s.m[k];
        sum += XXH3_64bits_withSeed(m, sizeof m, 5);
      }
    }
  }
  sum += XXH3_64bits_withSeed(&w.step, sizeof w.step, 1) + XXH3_64bits_withSeed(&w.next_id, sizeof w.next_id, 2);
  if (w.insertion != nullptr) {
    const std::vector<std::uint8_t> bytes = w.insertion->save();
    sum += XXH3_64bits_withSeed(bytes.data(), bytes.size(), 3);
  }
  return sum;
}

}  // namespace talus
