// See narrow.hpp.
#include "scheduler/nodes/narrow.hpp"

#include <immintrin.h>

#include "core/base/error.hpp"
#include "scheduler/nodes/add_ons.hpp"

namespace talus {

namespace {

/// Fills the padding behind the last contact with the dead row, so that whole SIMD blocks can run.
void pad_contacts(const Rows& rows, Scratch& s, std::int64_t n) {
  for (int k = 0; k < k_pad; ++k) {
    s.ci[n + k] = s.cj[n + k] = rows.n;  // the dead row
  }
}

}  // namespace

void narrow_chunk(const Rules& rules, const Clock& clock, const Rows& rows, Chunk& c) {
  // FTZ, DAZ or another rounding mode would change bits silently (DESIGN I4); every worker passes here every step.
  if ((_mm_getcsr() & 0xe040U) != 0)
    throw Error(ErrorCode::physics,
                "flush-to-zero, denormals-are-zero or a changed rounding mode is active in a worker thread",
                "step " + std::to_string(clock.step), "do not link with -ffast-math and leave MXCSR at its default");
  Scratch& s = *c.scratch;
  const std::size_t room = static_cast<std::size_t>(c.list.pairs[0] + c.list.pairs[1] + c.list.pairs[2]) + 2 * k_pad;
  grow(s.ci, room);
  grow(s.cj, room);
  NarrowArgs a{};
  a.p = rows.p.data();
  a.pi = c.list.pi.data();
  a.pj = c.list.pj.data();
  a.mask = c.list.mask.data();
  const Box box = rules.scene.domain.box();
  for (int k = 0; k < 3; ++k) a.end[k] = c.list.end[k], a.half[k] = box.half(k), a.period[k] = box.period(k);
  a.periodic = rules.has.periodic ? 1 : 0;
  if (rules.has.law_columns > 0 && !rules.has.adhesion) {
    for (int k = 0; k < rules.has.law_columns; ++k) grow(c.contacts.h[k], k_pad);
    grow(s.runs, room);
    a.runs = s.runs.data();
  }
  a.ci = s.ci.data();
  a.cj = s.cj.data();
  if (rules.has.adhesion || rules.has.moments || rules.has.superquadrics)
    narrow_add_ons(rules, rows, c, a, room);
  else
    rules.kernels->narrow(a);
  for (int k = 0; k < 3; ++k) c.contacts.end[k] = a.contact_end[k];
  c.contacts.run_count = a.run_count;
  pad_contacts(rows, s, c.contacts.end[2]);
  c.result.deep_slot = -1;
}

}  // namespace talus
