// What the per-chunk nodes of the step graph do: narrow phase, contact forces, wall contacts, integration.
// Invariants: I3 and I8 (contacts of lower chunks, interior, higher chunks, then walls), I5, I7 (a chunk writes only
// its own lists, its scratch and its own rows of p2, v2).
#include <immintrin.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "core/base/error.hpp"
#include "scheduler/nodes/contact_blocks.hpp"
#include "scheduler/nodes/next_chunk.hpp"
#include "scheduler/step/world.hpp"

namespace talus {

namespace {

/// Fills the padding behind the last contact with the dead row, so that whole SIMD blocks can run.
void pad_contacts(const World& w, Scratch& s, std::int64_t n) {
  for (int k = 0; k < k_pad; ++k) {
    s.ci[n + k] = s.cj[n + k] = w.n;  // the dead row
  }
}

/// Adds a block's energy terms to the rows of the chunk: half to each partner, in list order (I3).
void scatter_energy(World& w, const std::int32_t* ci, const std::int32_t* cj, int n, int from, int to,
                    const double (*e)[k_block + k_pad]) {
  for (int k = 0; k < n; ++k) {
    double* a = w.energy.data() + 4L * ci[k];
    for (int q = 0; q < 3; ++q) a[q] = a[q] + 0.5 * e[q][k];
    if (k >= from && k < to) {
      double* b = w.energy.data() + 4L * cj[k];
      for (int q = 0; q < 3; ++q) b[q] = b[q] + 0.5 * e[q][k];
    }
  }
}

/// Tests only: the order of summation that RunOptions::seeded_fault asks for; empty without a fault. 1: pairs with
/// lower chunks after the interior, which depends on the chunk size. 2: interior pairs as they would arrive from the
/// far end.
std::vector<std::int64_t> faulty_order(const World& w, const Chunk& c) {
  std::vector<std::int64_t> order;
  if (w.options.seeded_fault != 1 && w.options.seeded_fault != 2) return order;
  const std::int64_t lower = c.contact_end[0], interior = c.contact_end[1], total = c.contact_end[2];
  if (w.options.seeded_fault == 1) {
    for (std::int64_t k = lower; k < total; ++k) order.push_back(k);
    for (std::int64_t k = 0; k < lower; ++k) order.push_back(k);
  } else {
    for (std::int64_t k = 0; k < lower; ++k) order.push_back(k);
    for (std::int64_t k = interior; k-- > lower;) order.push_back(k);
    for (std::int64_t k = interior; k < total; ++k) order.push_back(k);
  }
  return order;
}

/// Tests only: contact k becomes contact order[k], history included.
void permute_contacts(const World& w, Chunk& c, const std::vector<std::int64_t>& order) {
  Scratch& s = *c.scratch;
  const auto permute = [&](auto& column) {
    const auto old = column;
    for (std::size_t k = 0; k < order.size(); ++k) column[k] = old[static_cast<std::size_t>(order[k])];
  };
  permute(s.ci);
  permute(s.cj);
  for (int q = 0; q < w.has.history_columns; ++q) permute(c.h[q]);
}

/// Records the first of n contacts from k0 on whose overlap exceeds the scene's bound.
void find_deep(const World& w, Chunk& c, std::int64_t k0, int n) {
  const Scratch& s = *c.scratch;
  for (std::int64_t k = k0; k < k0 + n && c.deep_slot < 0; ++k) {
    const double *p = w.p.data() + 4L * s.ci[static_cast<std::size_t>(k)],
                 *o = w.p.data() + 4L * s.cj[static_cast<std::size_t>(k)];
    double d2 = 0;
    for (int q = 0; q < 3; ++q) {
      double x = p[q] - o[q];
      if (w.scene.domain.periodic(q))
        x = x > 0.5 * w.size[q] ? x - w.size[q] : (x < -0.5 * w.size[q] ? x + w.size[q] : x);
      d2 += x * x;
    }
    if (p[3] + o[3] - __builtin_sqrt(d2) <= w.scene.max_overlap * fmin2(p[3], o[3])) continue;
    c.deep_slot = k;
    c.row_buffer.resize(2);
    c.row_buffer[0] = s.ci[static_cast<std::size_t>(k)];
    c.row_buffer[1] = s.cj[static_cast<std::size_t>(k)];
  }
}

/// What the drive of rows without a free mass puts into the step: it holds their velocity against the contacts.
void driven_work(World& w, const Chunk& c) {
  const double* f = c.scratch->f.data();
  for (Row i = c.lo; i < c.hi; ++i, f += w.stride) {
    const double* v = w.v.data() + static_cast<long>(w.stride) * i;
    if (v[w.stride - 1] != 0 || !w.is_alive(i)) continue;
    double power = (f[0] * v[0] + f[1] * v[1]) + f[2] * v[2];
    if (w.has.rotation) power += (f[4] * v[4] + f[5] * v[5]) + f[6] * v[6];
    w.energy[4L * i + 3] = -w.scene.dt * power;
  }
}

inline constexpr std::size_t k_streamed_bytes = std::size_t{64} << 20;  ///< of both copies of all rows

}  // namespace

ContactBlocks::ContactBlocks(const World& w, Chunk& c) : w_(w), c_(c), args_{} {
  GatherArgs& g = args_;
  g.v = w.v.data();
  g.p = w.p.data();
  g.material = w.has.materials ? w.material.data() : nullptr;
  g.materials = static_cast<int>(w.scene.materials.size());
  // d < w (1 - max_overlap r_small / (r_small + r_large)) for the most unequal pair; confirmed exactly by find_deep
  const bool relaxing = w.step < w.scene.relax.steps;
  g.deep = relaxing ? 0.0 : fmax2(0.0, 1.0 - w.scene.max_overlap * w.r_min / (w.r_min + w.r_max));
  g.periodic = w.has.periodic ? 1 : 0;
  for (int k = 0; k < 3; ++k) {
    const bool periodic = w.scene.domain.periodic(k);
    g.half[k] = periodic ? 0.5 * w.size[k] : 1e300;
    g.period[k] = periodic ? w.size[k] : 0.0;
  }
  if (c.run_count > 0)
    for (int k = 0; k < w.has.law_columns; ++k)
      grow(c.scratch->h[k], static_cast<std::size_t>(c.contact_end[2]) + 2 * k_pad);
}

std::int64_t ContactBlocks::run_end(std::int32_t run) const {
  return run + 1 < c_.run_count ? c_.scratch->runs[static_cast<std::size_t>(run) + 1].to : c_.contact_end[2];
}

/// Old and new columns of contacts [k0, k0 + n): a view where they lie in one run, else a copy in L1.
void ContactBlocks::find_history(std::int64_t k0, int n, BlockBuffers& buffers, Block& b) {
  const int columns = w_.has.law_columns;
  Scratch& s = *c_.scratch;
  if (columns == 0) return;
  // contacts before the first run keep their place
  const bool kept = c_.run_count == 0 || k0 + n <= s.runs[0].to;
  for (int q = 0; q < columns; ++q) {
    b.h[q] = (c_.run_count == 0 ? c_.h[q] : s.h[q]).data() + k0;
    b.h_in[q] = c_.h[q].data() + k0;
  }
  if (kept) return;
  const auto source = [&](std::int32_t run, std::int64_t k) {
    const HistoryRun& r = s.runs[static_cast<std::size_t>(run)];
    return r.from + (k - r.to);
  };
  if (k0 >= s.runs[0].to) {
    while (run_end(run_) <= k0) ++run_;
    if (s.runs[static_cast<std::size_t>(run_)].from >= 0 && run_end(run_) >= k0 + n) {
      for (int q = 0; q < columns; ++q) b.h_in[q] = c_.h[q].data() + source(run_, k0);
      return;
    }
  }
  std::int64_t k = k0;
  for (std::int32_t run = k0 < s.runs[0].to ? -1 : run_; k < k0 + n; ++run) {
    const std::int64_t end = std::min<std::int64_t>(run < 0 ? s.runs[0].to : run_end(run), k0 + n);
    const bool fresh = run >= 0 && s.runs[static_cast<std::size_t>(run)].from < 0;
    for (int q = 0; q < columns; ++q) {
      double* to = buffers.h[q] + (k - k0);
      if (fresh) {
        std::fill_n(to, end - k, 0.0);
      } else {
        // whole vectors, beyond the end too: the next run overwrites that
        const double* from = c_.h[q].data() + (run < 0 ? k : source(run, k));
        for (std::int64_t m = 0; m < end - k; m += 8) std::memcpy(to + m, from + m, 8 * sizeof(double));
      }
    }
    k = end;
  }
  for (int q = 0; q < columns; ++q) {
    std::fill_n(buffers.h[q] + n, (8 - n % 8) % 8, 0.0);  // padding lanes
    b.h_in[q] = buffers.h[q];
  }
}

void ContactBlocks::settle_history() {
  if (c_.run_count == 0) return;
  BlockBuffers buffers;
  for (std::int64_t k0 = 0; k0 < c_.contact_end[2]; k0 += k_block) {
    Block b{};
    const int n = static_cast<int>(std::min<std::int64_t>(k_block, c_.contact_end[2] - k0));
    find_history(k0, n, buffers, b);
    for (int q = 0; q < w_.has.law_columns; ++q) std::copy_n(b.h_in[q], n, b.h[q]);
  }
  keep_history();
}

void ContactBlocks::keep_history() {
  if (c_.run_count == 0) return;
  for (int q = 0; q < w_.has.law_columns; ++q) std::swap(c_.h[q], c_.scratch->h[q]);
  c_.run_count = 0;
}

void prefetch_next(const World& w, const Chunk& c, std::int64_t k0, GatherArgs& g) {
  const bool far = !rows_stay_near(w);
  g.next_i = far ? g.i + k_block : nullptr;
  g.next_j = g.j + k_block;
  g.next_n = static_cast<int>(std::clamp<std::int64_t>(c.contact_end[2] - k0 - k_block, 0, g.n));
  g.next_columns = far ? w.has.law_columns : 0;
  // old entries are near there even where runs have moved them: only the prefetch depends on it
  for (int q = 0; q < g.next_columns; ++q) g.next_h[q] = c.h[q].data() + k0 + k_block;
}

Block ContactBlocks::gather(std::int64_t k0, BlockBuffers& buffers) {
  const Scratch& s = *c_.scratch;
  const std::int64_t left = c_.contact_end[2] - k0;
  Block b{};
  b.n = static_cast<int>(std::min<std::int64_t>(k_block, left));
  GatherArgs& g = args_;
  g.i = s.ci.data() + k0;
  g.j = s.cj.data() + k0;
  g.n = b.n;
  g.x = buffers.x;
  g.r = buffers.r;
  g.g = buffers.g;
  prefetch_next(w_, c_, k0, g);
  g.reff = w_.has.reff ? buffers.reff : nullptr;
  g.pair = w_.has.materials ? buffers.pair : nullptr;
  g.deep_found = 0;
  w_.kernels->gather[w_.has.rotation ? 1 : 0](g);
  if (g.deep_found != 0) find_deep(w_, c_, k0, b.n);
  b.x = buffers.x[0];
  b.y = buffers.x[1];
  b.z = buffers.x[2];
  b.w = buffers.x[3];
  b.g = buffers.g;
  b.r = buffers.r;
  find_history(k0, b.n, buffers, b);
  b.reff = buffers.reff;
  b.pair = buffers.pair;
  b.e = buffers.e;
  b.t = buffers.t;
  b.slid = w_.has.moments ? buffers.slid : nullptr;
  return b;
}

Block ContactBlocks::evaluate(std::int64_t k0, BlockBuffers& buffers) {
  Block b = gather(k0, buffers);
  w_.kernels->law[w_.law_variant](b, w_.law_args);
  if (w_.has.moments || w_.has.cohesion) evaluate_add_ons(w_, c_, k0, b, buffers);
  return b;
}

Scratch* ScratchPool::take(int slot) {
  if (slot >= 0 && static_cast<std::size_t>(slot) < home_.size())
    if (Scratch* s = std::exchange(home_[static_cast<std::size_t>(slot)].scratch, nullptr)) return s;
  const std::lock_guard<std::mutex> lock(mutex_);
  if (free_.empty()) {
    all_.push_back(std::make_unique<Scratch>());
    return all_.back().get();
  }
  Scratch* s = free_.back();
  free_.pop_back();
  return s;
}

void ScratchPool::give(Scratch* s, int slot) {
  if (slot >= 0 && static_cast<std::size_t>(slot) < home_.size() &&
      home_[static_cast<std::size_t>(slot)].scratch == nullptr) {
    home_[static_cast<std::size_t>(slot)].scratch = s;
    return;
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  free_.push_back(s);
}

std::size_t ScratchPool::bytes() const {
  std::size_t b = 0;
  for (const auto& s : all_) {
    b += (s->ci.capacity() + s->cj.capacity()) * 4 + (s->f.capacity() + s->m.capacity()) * 8 + s->before.capacity();
    for (const auto& h : s->h) b += h.capacity() * 8;
  }
  return b;
}

void narrow_chunk(World& w, Chunk& c) {
  NodeTimer timer(w, c, Node::narrow_phase);
  // FTZ, DAZ or another rounding mode would change bits silently (DESIGN I4); every worker passes here every step.
  if ((_mm_getcsr() & 0xe040U) != 0)
    throw Error(ErrorCode::physics,
                "flush-to-zero, denormals-are-zero or a changed rounding mode is active in a worker thread",
                "step " + std::to_string(w.step), "do not link with -ffast-math and leave MXCSR at its default");
  c.scratch = w.scratch.take(thread_slot(w));
  Scratch& s = *c.scratch;
  const std::size_t room = static_cast<std::size_t>(c.pairs[0] + c.pairs[1] + c.pairs[2]) + 2 * k_pad;
  grow(s.ci, room);
  grow(s.cj, room);
  NarrowArgs a{};
  a.p = w.p.data();
  a.pi = c.pi.data();
  a.pj = c.pj.data();
  a.mask = c.mask.data();
  for (int k = 0; k < 3; ++k) {
    a.end[k] = c.end[k];
    const bool periodic = w.scene.domain.periodic(k);
    a.half[k] = periodic ? 0.5 * w.size[k] : 1e300;
    a.period[k] = periodic ? w.size[k] : 0.0;
  }
  a.periodic = w.has.periodic ? 1 : 0;
  if (w.has.law_columns > 0 && !w.has.adhesion) {
    for (int k = 0; k < w.has.law_columns; ++k) grow(c.h[k], k_pad);
    grow(s.runs, room);
    a.runs = s.runs.data();
  }
  a.ci = s.ci.data();
  a.cj = s.cj.data();
  if (w.has.adhesion || w.has.moments)
    narrow_add_ons(w, c, a, room);
  else
    w.kernels->narrow(a);
  for (int k = 0; k < 3; ++k) c.contact_end[k] = a.contact_end[k];
  c.run_count = a.run_count;
  pad_contacts(w, s, c.contact_end[2]);
  c.deep_slot = -1;
}

void force_chunk(World& w, Chunk& c) {
  NodeTimer timer(w, c, Node::contact_force);
  Scratch& s = *c.scratch;
  const int rows = c.hi - c.lo;
  if (s.f.size() < static_cast<std::size_t>(rows) * w.stride) {
    grow(s.f, static_cast<std::size_t>(rows) * w.stride);
    s.clean = false;
  }
  if (!s.clean) std::memset(s.f.data(), 0, s.f.size() * sizeof(double));
  s.clean = false;
  if (w.has.energies) std::memset(w.energy.data() + 4L * c.lo, 0, static_cast<std::size_t>(rows) * 4 * sizeof(double));
  if (w.has.moments) clear_moments(w, c);
  BlockBuffers buffers;
  ContactBlocks blocks(w, c);
  const int rotation = w.has.rotation ? 1 : 0;
  const std::int64_t total = c.contact_end[2];
  std::int64_t both_from = c.contact_end[0], both_to = c.contact_end[1];
  double* f = s.f.data() - static_cast<std::ptrdiff_t>(w.stride) * c.lo;
  std::vector<std::int64_t> faulty = faulty_order(w, c);
  if (!faulty.empty()) {
    blocks.settle_history();
    permute_contacts(w, c, faulty);
    if (w.options.seeded_fault == 1) {
      both_to -= both_from;
      both_from = 0;
    }
  }
  NextChunk ahead(w, total);
  for (std::int64_t k0 = 0; k0 < total; k0 += k_block) {
    ahead.prefetch();
    const int n = static_cast<int>(std::min<std::int64_t>(k_block, total - k0));
    const int from = static_cast<int>(std::clamp<std::int64_t>(both_from - k0, 0, n));
    const int to = static_cast<int>(std::clamp<std::int64_t>(both_to - k0, 0, n));
    const ScatterArgs rows{f, s.ci.data() + k0, s.cj.data() + k0, n, from, to, buffers.r};
    if (w.trial) {
      Block b = blocks.gather(k0, buffers);
      const double back = w.kernels->trial(b, w.law_args);
      w.kernels->scatter_limited(LimitArgs{
          rows, buffers.t, w.law_args.contact_lever != 0 ? buffers.g[3] : nullptr, {b.h[0], b.h[1], b.h[2]}, back});
      continue;
    }
    blocks.evaluate(k0, buffers);
    w.kernels->scatter[rotation](rows);
    if (w.has.moments)
      w.kernels->scatter[0](ScatterArgs{s.m.data() - 4 * static_cast<std::ptrdiff_t>(c.lo), s.ci.data() + k0,
                                        s.cj.data() + k0, n, from, to, buffers.s});
    if (w.has.energies) scatter_energy(w, s.ci.data() + k0, s.cj.data() + k0, n, from, to, buffers.e);
  }
  blocks.keep_history();
  if (!faulty.empty()) {  // the history goes back into list order: only the order of the sums was wrong
    std::vector<std::int64_t> back(faulty.size());
    for (std::size_t k = 0; k < faulty.size(); ++k)
      back[static_cast<std::size_t>(faulty[k])] = static_cast<std::int64_t>(k);
    permute_contacts(w, c, back);
  }
}

void wall_chunk(World& w, Chunk& c) {
  NodeTimer timer(w, c, Node::wall_contact);
  Scratch& s = *c.scratch;
  c.wall_next.clear();
  c.wall_moment_next.clear();
  const auto moment_columns = static_cast<std::size_t>(w.has.moment_columns);
  const double wall_travel = w.walls.largest_travel();
  const bool images = w.walls.has_images();
  const double* listed_at = w.skin.cuts() ? w.outer.data() : w.x0.data();
  WallContact found[WallSet::k_max_contacts], before[WallSet::k_max_contacts];
  std::int32_t from[WallSet::k_max_contacts];
  std::size_t old = 0;
  for (std::size_t q = 0; q + 1 < c.wall_begin.size(); ++q) {
    const Row i = c.wall_row[q];
    const double* x = w.p.data() + 4L * i;
    if (!(x[0] < 1e100)) continue;
    const Vec3 centre{x[0], x[1], x[2]};
    const double radius = w.has.adhesion ? c.wall_radius[q] : x[3];
    const std::size_t first = c.wall_begin[q], count = c.wall_begin[q + 1] - first;
    if (s.wall_near.size() < count) s.wall_near.resize(2 * count);
    // elements that the way of the row and of the walls since the rebuild cannot have brought within its radius: most,
    // and mostly all of a row
    const double way2 = distance2(w, x, listed_at + 4L * i);
    const double gap = static_cast<double>(c.wall_nearest[q]) - (radius + wall_travel) * (1 + 1e-6);
    if (gap > 0 && gap * gap > way2 * (1 + 3e-6)) continue;
    const double way = __builtin_sqrt(way2) + wall_travel;
    const auto limit = static_cast<float>((radius + way) * (1 + 1e-6));
    std::size_t near = 0;
    for (std::size_t k = first; k < first + count; ++k) {
      s.wall_near[near] = c.wall_element[k];
      near += c.wall_distance[k] <= limit ? 1 : 0;
    }
    const WallSet::Wraps wraps = images ? wraps_of(w, x, listed_at + 4L * i) : WallSet::Wraps{};
    int n = w.walls.contacts(centre, radius, std::span<const std::int32_t>(s.wall_near.data(), near), found, wraps);
    if (n == 0) continue;
    while (old < c.wall_state.size() && c.wall_state[old].row < i) ++old;
    std::size_t end = old;
    int nb = 0;
    while (end < c.wall_state.size() && c.wall_state[end].row == i && nb < WallSet::k_max_contacts)
      before[nb++] = c.wall_state[end++].contact;
    w.walls.match(std::span(before, static_cast<std::size_t>(nb)), std::span(found, static_cast<std::size_t>(n)), from);
    if (w.has.adhesion) n = keep_wall_contacts(w, i, found, from, n);
    for (int k = 0; k < n; ++k) {
      WallState t;
      t.row = i;
      t.contact = found[k];
      if (from[k] >= 0)
        for (int h = 0; h < w.has.law_columns; ++h) t.h[h] = c.wall_state[old + from[k]].h[h];
      c.wall_next.push_back(t);
      for (std::size_t q = 0; q < moment_columns; ++q)
        c.wall_moment_next.push_back(from[k] >= 0 ? c.wall_moment[(old + from[k]) * moment_columns + q] : 0.0);
    }
  }
  // A wall is a partner of radius 0 and infinite mass at rest in its own spin: the same laws apply.
  alignas(64) double bx[k_block + k_pad], by[k_block + k_pad], bz[k_block + k_pad], bw[k_block + k_pad];
  alignas(64) double r[8][k_block + k_pad], e[3][k_block + k_pad], h[k_max_history][k_block + k_pad],
      g[4][k_block + k_pad], reff[k_block + k_pad], slid[k_block + k_pad];
  alignas(64) std::int32_t pair[k_block + k_pad];
  const auto law = w.kernels->law[w.law_variant];
  const int mass_lane = w.has.rotation ? 7 : 3;
  // where the centre of a grain gets this close to a wall it is about to come out on the other side
  const double deep = w.step < w.scene.relax.steps ? -1.0 : 1.0 - w.scene.max_overlap;
  c.deep_wall = -1;
  c.wall_force.resize(c.wall_next.size());
  c.wall_point.resize(c.wall_next.size());
  if (w.has.moments) c.wall_torque.resize(c.wall_next.size());
  if (w.has.energies) c.wall_power.resize(c.wall_next.size());
  for (std::size_t k0 = 0; k0 < c.wall_next.size(); k0 += k_block) {
    const int n = static_cast<int>(std::min<std::size_t>(k_block, c.wall_next.size() - k0));
    const int padded = (n + 7) / 8 * 8;
    for (int k = 0; k < padded; ++k) {
      const WallState& t = c.wall_next[k0 + static_cast<std::size_t>(std::min(k, n - 1))];
      const double* v = w.v.data() + static_cast<long>(w.stride) * t.row;
      bx[k] = t.contact.normal.x * t.contact.distance;
      by[k] = t.contact.normal.y * t.contact.distance;
      bz[k] = t.contact.normal.z * t.contact.distance;
      bw[k] = reff[k] = w.p[4L * t.row + 3];
      if (t.contact.distance < deep * bw[k]) c.deep_wall = static_cast<std::int64_t>(k0) + (k < n ? k : n - 1);
      r[0][k] = v[0] - t.contact.velocity.x;
      r[1][k] = v[1] - t.contact.velocity.y;
      r[2][k] = v[2] - t.contact.velocity.z;
      if (w.has.rotation)
        for (int q = 4; q < 7; ++q) r[q][k] = v[q];
      r[mass_lane][k] = v[mass_lane] > 0 ? v[mass_lane] : 1.0;  // a fixed grain feels nothing anyway
      for (int q = 0; q < w.has.law_columns; ++q) h[q][k] = t.h[q];
      if (w.has.materials) pair[k] = w.pair_index(w.material[t.row], w.walls.material(t.contact.wall));
    }
    Block b{};
    b.n = n;
    b.x = bx;
    b.y = by;
    b.z = bz;
    b.w = bw;
    b.g = g;
    b.r = r;
    w.kernels->geometry(GeometryArgs{n, bx, by, bz, bw, r[mass_lane], g});
    for (int q = 0; q < w.has.law_columns; ++q) b.h_in[q] = b.h[q] = h[q];
    b.reff = reff;
    b.pair = pair;
    b.e = e;
    b.slid = w.has.moments ? slid : nullptr;
    LawArgs args = w.law_args;
    if (!w.has.materials) args.one = w.parameters[0];
    // The mid-step normal of the synchronised form is that of two spheres, which turns with their chord. A wall's
    // contact point follows the grain: the normal at n holds at n-1/2 too (exactly on a plane), and tilting it back by
    // half the chord would press a sliding grain into the wall.
    args.synchronised = 0;
    law(b, args);
    if (w.has.moments || w.has.cohesion) wall_add_ons(w, c, k0, b);
    for (int k = 0; k < n; ++k) {
      WallState& t = c.wall_next[k0 + static_cast<std::size_t>(k)];
      for (int q = 0; q < w.has.law_columns; ++q) t.h[q] = h[q][k];
      double* f = s.f.data() + static_cast<std::ptrdiff_t>(w.stride) * (t.row - c.lo);
      for (int q = 0; q < w.stride; ++q) f[q] = f[q] + r[q][k];
      const Vec3 force{r[0][k], r[1][k], r[2][k]};
      c.wall_force[k0 + static_cast<std::size_t>(k)] = force;
      c.wall_point[k0 + static_cast<std::size_t>(k)] = w.position(t.row) - t.contact.distance * t.contact.normal;
      if (w.has.energies) {
        double* en = w.energy.data() + 4L * t.row;
        for (int q = 0; q < 3; ++q) en[q] = en[q] + e[q][k];
        double power = dot(force, t.contact.velocity);
        if (w.has.moments)
          power += dot(c.wall_torque[k0 + static_cast<std::size_t>(k)], w.walls.pose(t.contact.wall).omega);
        c.wall_power[k0 + static_cast<std::size_t>(k)] = w.scene.dt * power;
      }
    }
  }
  std::swap(c.wall_state, c.wall_next);
  std::swap(c.wall_moment, c.wall_moment_next);
}

namespace {

/// Tells the next check whether it has to look at this chunk.
void report_chunk(World& w, const Chunk& c) {
  if (c.expired != 0) w.any_expired.store(true, std::memory_order_relaxed);
  if (w.sampled || c.out_count != 0 || c.unstable_row >= 0 || c.deep_slot >= 0 || c.deep_wall >= 0)
    w.news.store(true, std::memory_order_relaxed);
}

}  // namespace

void integrate_chunk(World& w, Chunk& c) {
  NodeTimer timer(w, c, Node::integrate);
  Scratch& s = *c.scratch;
  grow(c.out, static_cast<std::size_t>(c.hi - c.lo));
  if (w.step < w.scene.relax.steps) {
    relax_chunk(w, c);
    if (w.skin.own_check()) travel_chunk(w, c);
    report_chunk(w, c);
    w.scratch.give(c.scratch, thread_slot(w));
    c.scratch = nullptr;
    return;
  }
  if (w.has.moments) fold_moments(w, c);
  if (w.has.energies && w.has.fixed) driven_work(w, c);
  IntegrateArgs a{};
  a.lo = c.lo;
  a.hi = c.hi;
  a.p = w.p.data();
  a.v = w.v.data();
  a.f = s.f.data() - static_cast<std::ptrdiff_t>(w.stride) * c.lo;
  a.p2 = w.p2.data();
  a.v2 = w.v2.data();
  a.x0 = w.x0.data();
  if (w.skin.drifts()) {
    a.drift = w.drift.empty() ? w.frame.drift : w.drift.data();
    a.drift_stride = w.drift.empty() ? 0 : 4;
    a.drift_time = static_cast<double>(w.step + 1 - w.frame.built) * w.scene.dt;
  }
  a.dt = w.scene.dt;
  // velocity Verlet starts with a half kick (initial velocities hold at step 0), leapfrog takes them as v(-1/2)
  a.kick = w.step == 0 && w.scene.integrator == Integrator::velocity_verlet ? 0.5 * w.scene.dt : w.scene.dt;
  for (int k = 0; k < 3; ++k) {
    const bool periodic = w.scene.domain.periodic(k);
    a.gravity[k] = w.gravity[k];
    a.upper[k] = w.size[k];
    a.wrap[k] = periodic ? w.size[k] : 0.0;
    a.half[k] = periodic ? 0.5 * w.size[k] : 1e300;
  }
  a.upper[3] = a.half[3] = 1e300;
  // -4 % at 512k grains; at 128k the rows would have stayed in the last-level cache: +10 %
  const std::size_t rows_bytes = static_cast<std::size_t>(w.n) * (w.stride + 4) * 2 * sizeof(double);
  a.stream = rows_bytes > k_streamed_bytes && !w.has.planes ? 1 : 0;  // plane_chunk reads p2
  a.viscous = w.scene.viscous_damping;
  a.local = w.scene.local_damping;
  a.loss = w.has.energies && a.local != 0 ? w.energy.data() : nullptr;
  a.unstable = w.unstable_limit;
  a.out = c.out.data();
  if (w.options.seeded_fault == 4 && w.step == 50 && c.index == 0)
    s.f[0] = __builtin_nan("");  // tests only: a force that is no number
  w.kernels->integrate[w.has.rotation ? 1 : 0](a);
  s.clean = true;  // it leaves zeros behind: a pass of its own over the rows would cost 1 ns per particle
  c.out_count = a.out_count;
  c.expired = a.expired;
  c.unstable_row = a.unstable_row;
  if (w.skin.own_check()) travel_chunk(w, c);
  if (w.sampled) observe_chunk(w, c);
  report_chunk(w, c);
  w.scratch.give(c.scratch, thread_slot(w));
  c.scratch = nullptr;
}

}  // namespace talus
