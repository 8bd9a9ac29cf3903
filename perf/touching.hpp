// A bed of perf/bed.hpp as it is between narrow phase and contact forces: what kernels of contacts are run on, alone.
// Who calls it: perf/kernels_contacts.cpp, perf/kernels_laws.cpp.
#pragma once

#include <algorithm>

#include "perf/bed.hpp"
#include "scheduler/nodes/contact_blocks.hpp"

namespace talus::perf {

inline constexpr double k_row4 = 32, k_row8 = 64;  ///< bytes of a row

/// All chunks with their contacts in scratch, as between narrow phase and contact forces.
class Touching {
 public:
  explicit Touching(Bed& b) : b_(b) {
    b.nodes.rules.kernels = &select_kernels(Isa::automatic);
    for (const auto& c : b.w.contacts.chunks) {
      b.nodes.narrow(*c);
      b.nodes.force(*c);  // sizes the force rows
    }
  }
  ~Touching() {
    for (const auto& c : b_.w.contacts.chunks) b_.nodes.give_back(*c);
  }
  Touching(const Touching&) = delete;
  Touching& operator=(const Touching&) = delete;
  /// fn(chunk, first contact) for every block.
  template <class F>
  void blocks(F fn) {
    for (const auto& c : b_.w.contacts.chunks)
      for (std::int64_t k0 = 0; k0 < c->contacts.end[2]; k0 += k_block) fn(*c, k0);
  }

 private:
  Bed& b_;
};

inline int block_size(const Chunk& c, std::int64_t k0) {
  return static_cast<int>(std::min<std::int64_t>(k_block, c.contacts.end[2] - k0));
}

inline GatherArgs gather_args(const World& w, const Chunk& c, std::int64_t k0, BlockBuffers& buffers) {
  GatherArgs g{};
  g.v = w.rows.v.data();
  g.p = w.rows.p.data();
  g.i = c.scratch->ci.data() + k0;
  g.j = c.scratch->cj.data() + k0;
  g.n = block_size(c, k0);
  g.x = buffers.x;
  g.r = buffers.r;
  g.g = buffers.g;
  for (double& half : g.half) half = 1e300;
  prefetch_next(w.rules, w.rows, c, k0, g);
  return g;
}

}  // namespace talus::perf
