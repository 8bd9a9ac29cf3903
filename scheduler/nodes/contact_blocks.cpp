// See contact_blocks.hpp.
#include "scheduler/nodes/contact_blocks.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "scheduler/nodes/add_ons.hpp"
#include "scheduler/nodes/late_contacts.hpp"
#include "scheduler/nodes/shaped_contacts.hpp"

namespace talus {

namespace {

/// Records the first of n contacts from k0 on whose overlap exceeds the scene's bound.
void find_deep(const Rules& rules, const Rows& rows, Chunk& c, std::int64_t k0, int n) {
  const Scratch& s = *c.scratch;
  for (std::int64_t k = k0; k < k0 + n && c.result.deep_slot < 0; ++k) {
    const double *p = rows.p.data() + 4L * s.ci[static_cast<std::size_t>(k)],
                 *o = rows.p.data() + 4L * s.cj[static_cast<std::size_t>(k)];
    const double d = norm(rules.scene.domain.box().nearest({p[0] - o[0], p[1] - o[1], p[2] - o[2]}));
    if (p[3] + o[3] - d <= rules.scene.max_overlap * fmin2(p[3], o[3])) continue;
    c.result.deep_slot = k;
    c.result.deep_rows[0] = s.ci[static_cast<std::size_t>(k)];
    c.result.deep_rows[1] = s.cj[static_cast<std::size_t>(k)];
  }
}

}  // namespace

ContactBlocks::ContactBlocks(const Rules& rules, const Clock& clock, const Rows& rows, Chunk& c)
    : rules_(rules), rows_(rows), c_(c), law_(rules.law_args(clock.step)), moment_(rules.law.moment_args), args_{} {
  GatherArgs& g = args_;
  g.v = rows.v.data();
  g.p = rows.p.data();
  g.material = rules.has.materials ? rows.material.data() : nullptr;
  g.materials = static_cast<int>(rules.scene.materials.size());
  // d < w (1 - max_overlap r_small / (r_small + r_large)) for the most unequal pair; confirmed exactly by find_deep
  const bool relaxing = clock.step < rules.scene.relax.steps;
  g.deep = relaxing ? 0.0 : fmax2(0.0, 1.0 - rules.scene.max_overlap * rules.r_min / (rules.r_min + rules.r_max));
  g.periodic = rules.has.periodic ? 1 : 0;
  const Box box = rules.scene.domain.box();
  for (int k = 0; k < 3; ++k) g.half[k] = box.half(k), g.period[k] = box.period(k);
  if (c.contacts.run_count > 0)
    for (int k = 0; k < rules.has.law_columns; ++k)
      grow(c.scratch->h[k], static_cast<std::size_t>(c.contacts.end[2]) + 2 * k_pad);
  if (rules.has.superquadrics) shaped_ = std::make_unique<ShapedContacts>(rules, clock, rows, c);
}

ContactBlocks::~ContactBlocks() = default;

std::int64_t ContactBlocks::run_end(std::int32_t run) const {
  return run + 1 < c_.contacts.run_count ? c_.scratch->runs[static_cast<std::size_t>(run) + 1].to : c_.contacts.end[2];
}

/// Old and new columns of contacts [k0, k0 + n): a view where they lie in one run, else a copy in L1.
void ContactBlocks::find_history(std::int64_t k0, int n, BlockBuffers& buffers, Block& b) {
  const int columns = rules_.has.law_columns;
  Scratch& s = *c_.scratch;
  if (columns == 0) return;
  // contacts before the first run keep their place
  const bool kept = c_.contacts.run_count == 0 || k0 + n <= s.runs[0].to;
  for (int q = 0; q < columns; ++q) {
    b.h[q] = (c_.contacts.run_count == 0 ? c_.contacts.h[q] : s.h[q]).data() + k0;
    b.h_in[q] = c_.contacts.h[q].data() + k0;
  }
  if (kept) return;
  const auto source = [&](std::int32_t run, std::int64_t k) {
    const HistoryRun& r = s.runs[static_cast<std::size_t>(run)];
    return r.from + (k - r.to);
  };
  if (k0 >= s.runs[0].to) {
    while (run_end(run_) <= k0) ++run_;
    if (s.runs[static_cast<std::size_t>(run_)].from >= 0 && run_end(run_) >= k0 + n) {
      for (int q = 0; q < columns; ++q) b.h_in[q] = c_.contacts.h[q].data() + source(run_, k0);
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
        const double* from = c_.contacts.h[q].data() + (run < 0 ? k : source(run, k));
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
  if (c_.contacts.run_count == 0) return;
  BlockBuffers buffers;
  for (std::int64_t k0 = 0; k0 < c_.contacts.end[2]; k0 += k_block) {
    Block b{};
    const int n = static_cast<int>(std::min<std::int64_t>(k_block, c_.contacts.end[2] - k0));
    find_history(k0, n, buffers, b);
    for (int q = 0; q < rules_.has.law_columns; ++q) std::copy_n(b.h_in[q], n, b.h[q]);
  }
  keep_history();
}

void ContactBlocks::put_history(const LateContacts& late) {
  for (int q = 0; q < rules_.has.law_columns; ++q) {
    double* to = (c_.contacts.run_count == 0 ? c_.contacts.h[q] : c_.scratch->h[q]).data();
    for (int k = 0; k < late.n; ++k) to[late.at[k]] = late.h[q][k];
  }
}

void ContactBlocks::keep_history() {
  if (c_.contacts.run_count == 0) return;
  for (int q = 0; q < rules_.has.law_columns; ++q) std::swap(c_.contacts.h[q], c_.scratch->h[q]);
  c_.contacts.run_count = 0;
}

void prefetch_next(const Rules& rules, const Rows& rows, const Chunk& c, std::int64_t k0, GatherArgs& g) {
  const bool far = !rows_stay_near(rows);
  g.next_i = far ? g.i + k_block : nullptr;
  g.next_j = g.j + k_block;
  g.next_n = static_cast<int>(std::clamp<std::int64_t>(c.contacts.end[2] - k0 - k_block, 0, g.n));
  g.next_columns = far ? rules.has.law_columns : 0;
  // old entries are near there even where runs have moved them: only the prefetch depends on it
  for (int q = 0; q < g.next_columns; ++q) g.next_h[q] = c.contacts.h[q].data() + k0 + k_block;
}

Block ContactBlocks::gather(std::int64_t k0, BlockBuffers& buffers) {
  const Scratch& s = *c_.scratch;
  const std::int64_t left = c_.contacts.end[2] - k0;
  Block b{};
  b.n = static_cast<int>(std::min<std::int64_t>(k_block, left));
  GatherArgs& g = args_;
  g.i = s.ci.data() + k0;
  g.j = s.cj.data() + k0;
  g.n = b.n;
  g.x = buffers.x;
  g.r = buffers.r;
  g.g = buffers.g;
  prefetch_next(rules_, rows_, c_, k0, g);
  g.reff = rules_.has.reff ? buffers.reff : nullptr;
  g.pair = rules_.has.materials ? buffers.pair : nullptr;
  g.deep_found = 0;
  rules_.kernels->gather[rules_.has.rotation ? 1 : 0](g);
  if (g.deep_found != 0 && shaped_ == nullptr) find_deep(rules_, rows_, c_, k0, b.n);
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
  b.slid = rules_.has.moments ? buffers.slid : nullptr;
  if (shaped_ != nullptr) shaped_->prepare(k0, b, buffers);
  return b;
}

Block ContactBlocks::evaluate(std::int64_t k0, BlockBuffers& buffers, LateList* late) {
  Block b = gather(k0, buffers);
  if (late != nullptr) late->offer(b, k0);
  rules_.kernels->law[rules_.law.variant](b, law_);
  if (shaped_ != nullptr) shaped_->settle(b);
  if (rules_.has.moments || rules_.has.cohesion) evaluate_add_ons(rules_, rows_, moment_, c_, k0, b, buffers);
  return b;
}

}  // namespace talus
