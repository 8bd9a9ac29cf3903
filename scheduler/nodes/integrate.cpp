// See integrate.hpp.
#include "scheduler/nodes/integrate.hpp"

#include "scheduler/lists/skin_check.hpp"
#include "scheduler/nodes/add_ons.hpp"
#include "scheduler/nodes/body_motion.hpp"
#include "scheduler/nodes/monitor.hpp"

namespace talus {

namespace {

/// What the drive of rows without a free mass puts into the step: it holds their velocity against the contacts.
void driven_work(const Rules& rules, const Rows& rows, Column<double>& energy, const Chunk& c) {
  const double* f = c.scratch->f.data();
  for (Row i = c.lo; i < c.hi; ++i, f += rules.stride) {
    const double* v = rows.v.data() + static_cast<long>(rules.stride) * i;
    if (v[rules.stride - 1] != 0 || !rows.is_alive(i)) continue;
    double power = (f[0] * v[0] + f[1] * v[1]) + f[2] * v[2];
    if (rules.has.rotation) power += (f[4] * v[4] + f[5] * v[5]) + f[6] * v[6];
    energy[4L * i + 3] = -rules.scene.dt * power;
  }
}

inline constexpr std::size_t k_streamed_bytes = std::size_t{64} << 20;  ///< of both copies of all rows

/// What the kernel reads and writes, without what is optional.
IntegrateArgs arguments(const Rules& rules, const Clock& clock, Rows& rows, const Lists& lists, const Chunk& c) {
  IntegrateArgs a{};
  a.lo = c.lo;
  a.hi = c.hi;
  a.p = rows.p.data();
  a.v = rows.v.data();
  a.f = c.scratch->f.data() - static_cast<std::ptrdiff_t>(rules.stride) * c.lo;
  a.p2 = rows.p2.data();
  a.v2 = rows.v2.data();
  a.x0 = lists.x0.data();
  if (lists.skin.drifts()) {
    a.drift = lists.drift.empty() ? lists.frame.drift : lists.drift.data();
    a.drift_stride = lists.drift.empty() ? 0 : 4;
    a.drift_time = static_cast<double>(clock.step + 1 - lists.frame.built) * rules.scene.dt;
  }
  a.dt = rules.scene.dt;
  // velocity Verlet starts with a half kick (initial velocities hold at step 0), leapfrog takes them as v(-1/2)
  a.kick =
      clock.step == 0 && rules.scene.integrator == Integrator::velocity_verlet ? 0.5 * rules.scene.dt : rules.scene.dt;
  const Box box = rules.scene.domain.box();
  for (int k = 0; k < 3; ++k) {
    a.gravity[k] = clock.gravity[k];
    a.upper[k] = rules.size[k];
    a.wrap[k] = box.period(k);
    a.half[k] = box.half(k);
  }
  a.upper[3] = a.half[3] = 1e300;
  return a;
}

/// Only rows that are no body's go through the kernel, run by run.
void integrate_runs(const Rules& rules, const Rows& rows, IntegrateArgs& a, Chunk& c) {
  std::int32_t expired = 0, unstable = -1;
  c.result.out_count = 0;
  for (Row i = c.lo, to = c.lo; i < c.hi; i = to) {
    for (to = i; to < c.hi && rows.body[static_cast<std::size_t>(to)] < 0;) ++to;
    if (to == i) {
      ++to;
      continue;
    }
    a.lo = i;
    a.hi = to;
    a.out = c.result.out.data() + c.result.out_count;
    rules.kernels->integrate[rules.has.rotation ? 1 : 0](a);
    c.result.out_count += a.out_count;
    expired |= a.expired;
    if (a.unstable_row >= 0) unstable = a.unstable_row;
  }
  c.result.expired = expired;
  c.result.unstable_row = unstable;
}

}  // namespace

void integrate_chunk(const Rules& rules, const Clock& clock, Rows& rows, const Lists& lists, Column<double>& energy,
                     Chunk& c) {
  Scratch& s = *c.scratch;
  grow(c.result.out, static_cast<std::size_t>(c.hi - c.lo));
  if (clock.step < rules.scene.relax.steps) {
    relax_chunk(rules, clock, rows, lists, c);
    if (rules.has.bodies) move_bodies(rules, clock, rows, lists, energy, c);
    if (lists.skin.own_check()) travel_chunk(rules, rows, lists, c);
    return;
  }
  if (rules.has.moments) fold_moments(rows, c);
  if (rules.has.energies && rules.has.fixed) driven_work(rules, rows, energy, c);
  IntegrateArgs a = arguments(rules, clock, rows, lists, c);
  // -4 % at 512k grains; at 128k the rows would have stayed in the last-level cache: +10 %
  const std::size_t rows_bytes = static_cast<std::size_t>(rows.n) * (rules.stride + 4) * 2 * sizeof(double);
  a.stream = rows_bytes > k_streamed_bytes && !rules.has.planes ? 1 : 0;  // plane_chunk reads p2
  a.viscous = rules.scene.viscous_damping;
  a.local = rules.scene.local_damping;
  a.loss = rules.has.energies && a.local != 0 ? energy.data() : nullptr;
  a.unstable = rules.bounds.unstable;
  a.out = c.result.out.data();
  if (rules.hooks.spoil != nullptr) rules.hooks.spoil(clock.step, c, s.f.data());
  if (clock.sampled) observe_stiffness(rules, rows, c);
  if (rules.has.bodies) {
    integrate_runs(rules, rows, a, c);
    move_bodies(rules, clock, rows, lists, energy, c);
  } else {
    rules.kernels->integrate[rules.has.rotation ? 1 : 0](a);
    c.result.out_count = a.out_count;
    c.result.expired = a.expired;
    c.result.unstable_row = a.unstable_row;
  }
  s.clean = true;  // it leaves zeros behind: a pass of its own over the rows would cost 1 ns per particle
  if (lists.skin.own_check()) travel_chunk(rules, rows, lists, c);
  if (clock.sampled) observe_chunk(rules, clock, rows, c);
}

}  // namespace talus
