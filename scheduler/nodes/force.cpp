// See force.hpp. Invariants: I3 and I8 (contacts of lower chunks, interior, higher chunks), I5.
#include "scheduler/nodes/force.hpp"

#include <algorithm>
#include <optional>

#include "scheduler/nodes/add_ons.hpp"
#include "scheduler/nodes/contact_blocks.hpp"
#include "scheduler/nodes/late_contacts.hpp"
#include "scheduler/nodes/shaped_contacts.hpp"

namespace talus {

namespace {

/// Adds a block's energy terms to the rows of the chunk: half to each partner, in list order (I3).
void scatter_energy(Column<double>& energy, const std::int32_t* ci, const std::int32_t* cj, int n, int from, int to,
                    const double (*e)[k_block + k_pad]) {
  for (int k = 0; k < n; ++k) {
    double* a = energy.data() + 4L * ci[k];
    for (int q = 0; q < 3; ++q) a[q] = a[q] + 0.5 * e[q][k];
    if (k >= from && k < to) {
      double* b = energy.data() + 4L * cj[k];
      for (int q = 0; q < 3; ++q) b[q] = b[q] + 0.5 * e[q][k];
    }
  }
}

}  // namespace

void force_chunk(const Rules& rules, const Clock& clock, const Rows& rows, Column<double>& energy, Chunk& c,
                 NextChunk ahead) {
  Scratch& s = *c.scratch;
  const int own = c.hi - c.lo;
  if (s.f.size() < static_cast<std::size_t>(own) * rules.stride) {
    grow(s.f, static_cast<std::size_t>(own) * rules.stride);
    s.clean = false;
  }
  if (!s.clean) std::fill(s.f.begin(), s.f.end(), 0.0);
  s.clean = false;
  if (rules.has.energies) std::fill_n(energy.data() + 4L * c.lo, 4L * own, 0.0);
  if (rules.has.moments) clear_moments(c);
  BlockBuffers buffers;
  ContactBlocks blocks(rules, clock, rows, c);
  const int rotation = rules.has.rotation ? 1 : 0;
  const std::int64_t total = c.contacts.end[2];
  std::int64_t both_from = c.contacts.end[0], both_to = c.contacts.end[1];
  double* f = s.f.data() - static_cast<std::ptrdiff_t>(rules.stride) * c.lo;
  if (rules.hooks.reorder != nullptr) {
    blocks.settle_history();
    rules.hooks.reorder(rules.has.history_columns, c, both_from, both_to, false);
  }
  std::optional<LateList> late;
  if (rules.law.late) late.emplace(c);
  ahead.spread_over(total);
  for (std::int64_t k0 = 0; k0 < total; k0 += k_block) {
    ahead.prefetch();
    const int n = static_cast<int>(std::min<std::int64_t>(k_block, total - k0));
    const int from = static_cast<int>(std::clamp<std::int64_t>(both_from - k0, 0, n));
    const int to = static_cast<int>(std::clamp<std::int64_t>(both_to - k0, 0, n));
    const ScatterArgs to_rows{f, s.ci.data() + k0, s.cj.data() + k0, n, from, to, buffers.r};
    if (rules.law.trial) {
      Block b = blocks.gather(k0, buffers);
      late->offer(b, k0);
      const double back = rules.kernels->trial(b, blocks.law());
      rules.kernels->scatter_limited(LimitArgs{to_rows,
                                               buffers.t,
                                               blocks.law().contact_lever != 0 ? buffers.g[3] : nullptr,
                                               {b.h[0], b.h[1], b.h[2]},
                                               back});
      continue;
    }
    const Block b = blocks.evaluate(k0, buffers, late ? &*late : nullptr);
    if (blocks.shaped() != nullptr)
      blocks.shaped()->scatter(to_rows, b);
    else
      rules.kernels->scatter[rotation](to_rows);
    if (rules.has.moments)
      rules.kernels->scatter[0](ScatterArgs{s.m.data() - 4 * static_cast<std::ptrdiff_t>(c.lo), s.ci.data() + k0,
                                            s.cj.data() + k0, n, from, to, buffers.s});
    if (rules.has.energies) scatter_energy(energy, s.ci.data() + k0, s.cj.data() + k0, n, from, to, buffers.e);
  }
  if (late) late->add(rules, blocks, f, both_from, both_to);
  blocks.keep_history();
  // the history goes back into list order: only the order of the sums was wrong
  if (rules.hooks.reorder != nullptr) rules.hooks.reorder(rules.has.history_columns, c, both_from, both_to, true);
}

}  // namespace talus
