// How long a heat step may be, and how long the next one is where an error is wanted. See heat.hpp.
//
// An explicit step of length h leaves h/2 T'' h of error; of a temperature that goes to where it belongs, by itself or
// with the slow modes of a bed, what is not yet forgotten of it stays below half of its change per step. So the next
// step is the longest one that keeps half of the largest change below what is wanted, were the rates those of the last
// one. What the rates do not know yet is looked ahead for: tables of gas, walls and enclosure, grains to come, contacts
// to come (excess_in_a_bed). Steps are `every` 2^k and begin at multiples of their length: the length alone is state.
#include <fmt/format.h>

#include <algorithm>

#include "scheduler/parts/heat.hpp"

namespace talus {
namespace {

constexpr double k_excess = 0.25;   // of the limit of stability: contacts may come to conduct four times as much
constexpr double k_longer = 0.8;    // of what is wanted is left after doubling
constexpr double k_overlap = 0.01;  // of the radius, of a hard contact
constexpr double k_contacts = 6;

struct Span {
  double low = k_never, high = -k_never;
  void add(double x) { low = fmin2(low, x), high = fmax2(high, x); }
  double width() const { return high > low ? high - low : 0.0; }
};

double change_in(const TimeTable& table, double from, double to) {
  if (!table.given()) return 0;
  Span span;
  span.add(table(from)), span.add(table(to));
  for (std::size_t k = 0; k < table.time.size(); ++k)
    if (table.time[k] > from && table.time[k] <= to) span.add(table.value[k]), span.add(table.value[k > 0 ? k - 1 : 0]);
  return span.width();
}

/// Largest step of a temperature that grains will see between two times, beside that of grains themselves [K].
double change_ahead(const HeatScene& h, double from, double to) {
  double change = h.gas.on ? change_in(h.gas.temperature, from, to) : 0;
  change = fmax2(change, change_in(h.radiation.enclosure, from, to));
  for (const WallHeat& wall : h.walls) change = fmax2(change, change_in(wall.temperature, from, to));
  return change;
}

/// Difference between the hottest and the coldest of grains and what is around, where grains are still to come [K].
double spread_of_new_ones(const HeatState& s, const PartView& w, double now) {
  bool coming = false;
  Span all;
  for (std::size_t k = 0; k < s.scene.sources.size(); ++k) {
    const Source& source = w.rules.scene.sources[k];
    if (!((source.kind == Source::Kind::stream ? source.end : source.start) > now)) continue;
    coming = true;
    all.add(s.scene.sources[k].temperature);
  }
  if (!coming) return 0;
  if (s.scene.gas.on) all.add(s.scene.gas.temperature(now));
  if (s.scene.radiation.enclosure.given()) all.add(s.scene.radiation.enclosure(now));
  for (const WallHeat& wall : s.scene.walls)
    if (wall.temperature.given()) all.add(wall.temperature(now));
  for (Row i = 0; i < w.rows.n; ++i)
    if (w.rows.is_alive(i)) all.add(s.temperature[static_cast<std::size_t>(i)]);
  return all.width();
}

}  // namespace

double HeatState::middle(const PartView& w) const {
  return (static_cast<double>(w.clock.step + 1) - 0.5 * static_cast<double>(pace.steps)) * w.rules.scene.dt;
}

double HeatState::excess(const PartView& w, const GrainInside* inside, Row i) const {
  const double g = conductance[static_cast<std::size_t>(i)];
  if (inside == nullptr || !has_shells(w, i))
    return dt(w) * g / (mass_of(w.rules, w.rows, i) * matter[static_cast<std::size_t>(material(w, i))].least_capacity);
  const GrainSurface shell = inside->surface(i);
  return g > 0 ? dt(w) * (g * shell.inner / (g + shell.inner)) / shell.capacity : 0;
}

double HeatState::excess_in_a_bed(const PartView& w, Row i) const {
  const int m = material(w, i);
  const double k = conductivity(w, nullptr, i);
  double g = 0;
  for (Row q = i; q < end_of_grain(w, i); ++q) {
    const double r = w.rows.p[4L * q + 3];
    g = g + k_contacts * heat::contact_conductance(k, k, pair(m, m).of(heat::reduced(r, r), k_overlap * r));
  }
  return dt(w) * g / (mass_of(w.rules, w.rows, i) * matter[static_cast<std::size_t>(m)].least_capacity);
}

namespace {

/// The shortest heat step has changed temperatures by more than the wanted error allows.
void warn_of_error(HeatState& s, const PartView& w) {
  const HeatScene& h = s.scene;
  if (s.pace.steps > h.every || !(s.pace.error > h.error)) return;
  const double most = static_cast<double>(h.every) * h.error / s.pace.error, seconds = most * w.rules.scene.dt;
  const std::string cure = most >= 1 ? fmt::format("at most every = {}", static_cast<std::int64_t>(most))
                                     : fmt::format("every = 1 and a time.step of at most {:.2g} s", seconds);
  s.pace.concerns.push_back({"error",
                             fmt::format("heat.error = {:g} K is not kept: at step {} the shortest heat step (every = "
                                         "{}) leaves an error of about {:.2g} K; {} would keep it there",
                                         h.error, w.clock.step, h.every, s.pace.error, cure),
                             s.pace.error, h.error});
}

}  // namespace

void choose_pace(HeatState& s, const PartView& w, double change, double excess) {
  const HeatScene& h = s.scene;
  const std::int64_t done = w.clock.step + 1, was = s.pace.steps;
  const std::int64_t most = h.every_most > 0 ? h.every_most : k_heat_growth * h.every;
  const double now = static_cast<double>(done) * w.rules.scene.dt, spread = spread_of_new_ones(s, w, now);
  /// How much of what may be a heat step of so many steps would use up.
  const auto use = [&](std::int64_t steps) {
    const double share = static_cast<double>(steps) / static_cast<double>(was), beyond = excess * share;
    const double end = now + static_cast<double>(steps) * w.rules.scene.dt;
    const double jump = fmax2(change_ahead(h, now, end), spread) * fmin2(beyond, 1.0);
    return fmax2(0.5 * (change * share + jump) / h.error, beyond / k_excess);
  };
  s.pace.error = 0.5 * change;
  warn_of_error(s, w);
  std::int64_t next = was;
  while (next > h.every && (next > most || use(next) > 1)) next /= 2;
  if (next == was && done % (2 * was) == 0 && 2 * was <= most && use(2 * was) <= k_longer) next = 2 * was;
  s.pace.steps = next;
}

}  // namespace talus
