// See check.hpp.
#include "scheduler/nodes/check.hpp"

#include "core/walls/wall_motion.hpp"
#include "scheduler/nodes/events.hpp"
#include "scheduler/state/step_failure.hpp"

namespace talus {

namespace {

[[noreturn]] void fail_deep(const Rules& rules, std::vector<ParticleId> ids, const std::string& who,
                            const std::string& cure) {
  throw StepFailure(std::move(ids),
                    who + " overlap by more than " + std::to_string(rules.scene.max_overlap) + " of the smaller radius",
                    cure);
}

const char* const k_stiffer =
    "stiffer contacts, a smaller time step, relax.steps for an overlapping start, or a larger checks.max_overlap";

/// A wall that has appeared in the last steps.
bool just_appeared(const Rules& rules, const Clock& clock, int wall) {
  const auto& walls = rules.scene.walls;
  if (static_cast<std::size_t>(wall) >= walls.size()) return false;  // a side of the domain
  const WallSpec& w = walls[static_cast<std::size_t>(wall)];
  return w.appear > 0 && !acts_at(w, clock.step - 2, rules.scene.dt);
}

void report_chunk(const Rules& rules, const Clock& clock, const Rows& rows, const Contacts& contacts,
                  const WallSet& walls, const Chunk& c) {
  const ChunkResults& r = c.result;
  if (r.deep_slot >= 0) {
    const ParticleId i = rows.id[r.deep_rows[0]], j = rows.id[r.deep_rows[1]];
    fail_deep(rules, {i, j}, "particles " + std::to_string(i) + " and " + std::to_string(j), k_stiffer);
  }
  if (r.deep_wall >= 0) {
    const WallState& t = c.wall.state[static_cast<std::size_t>(r.deep_wall)];
    const ParticleId i = rows.id[t.row];
    const bool young = just_appeared(rules, clock, t.contact.wall);
    fail_deep(rules, {i},
              "particle " + std::to_string(i) + " and wall '" + walls.name(t.contact.wall) + "'" +
                  (young ? ", which has just appeared where grains are," : ""),
              young ? "a place without grains, or a wall.appear when they lie out of its way" : k_stiffer);
  }
  if (r.unstable_row >= 0) {
    const ParticleId i = rows.id[r.unstable_row];
    throw StepFailure({i},
                      "particle " + std::to_string(i) + ": the stiffness of its contacts makes the time step unstable",
                      "a smaller time.step");
  }
  for (std::int32_t k = 0; k < r.out_count; ++k)
    if (const Row i = r.out[static_cast<std::size_t>(k)]; !finite_row(rows, i))
      fail_non_finite(rows, contacts, walls, i);
}

/// A row that has left has done so through open sides.
void check_exit(const Rules& rules, const Rows& rows, Row i) {
  static const char* const axis = "xyz";
  const Vec3 x = centre_of(rules, rows, i) - rules.scene.domain.lower;
  const Domain& domain = rules.scene.domain;
  for (int a = 0; a < 3; ++a) {
    if (domain.periodic(a) || (x[a] >= 0 && x[a] < rules.size[a])) continue;
    if (domain.boundary[static_cast<std::size_t>(a)][x[a] < 0 ? 0 : 1] == Boundary::open) continue;
    const Vec3 at = centre_of(rules, rows, i);
    throw StepFailure({rows.id[i]},
                      "particle " + std::to_string(rows.id[i]) + " left the domain through the closed " + axis[a] +
                          " side at (" + std::to_string(at.x) + ", " + std::to_string(at.y) + ", " +
                          std::to_string(at.z) + ")",
                      "a smaller time.step, stiffer walls, or an open boundary there", false);
  }
}

}  // namespace

void report_failures(const Rules& rules, const Clock& clock, const Rows& rows, const Contacts& contacts,
                     const WallSet& walls) {
  for (const auto& c : contacts.chunks) report_chunk(rules, clock, rows, contacts, walls, *c);
}

void remove_leavers(const Rules& rules, const Clock& clock, Rows& rows, Contacts& contacts, Lists& lists,
                    Ledger& ledger, Counters& counters, Parts& parts) {
  for (const auto& c : contacts.chunks) {
    for (std::int32_t k = 0; k < c->result.out_count; ++k) {
      const Row i = c->result.out[static_cast<std::size_t>(k)];
      check_exit(rules, rows, i);
      remove_row(rules, clock, rows, lists, ledger, counters, parts, i);
    }
    c->result.out_count = 0;
  }
}

void forget_results(Contacts& contacts) {
  for (const auto& c : contacts.chunks) {
    c->result.deep_slot = c->result.deep_wall = -1;
    c->result.unstable_row = -1;
    c->result.out_count = 0;
    c->result.extremes.filled = false;
  }
}

ListRecord list_record(const Rules& rules, const Clock& clock, const Contacts& contacts, const Lists& lists,
                       const Counters& counters) {
  ListRecord r;
  r.step = clock.step;
  r.interval = clock.step - lists.last_rebuild_step;
  r.k = lists.skin.has_k() ? lists.skin.k_dt / rules.scene.dt : 0;
  r.floor = lists.skin.floor_on ? lists.skin.floor : 0;
  r.skin = lists.frame.mean_skin;
  r.pairs = counters.pairs;
  std::int64_t twice = 0;
  for (const auto& c : contacts.chunks) {
    const std::int64_t* end = c->contacts.end;
    const std::int64_t* apart = c->contacts.apart;
    twice += 2 * (end[1] - end[0] - apart[0]) + end[0] + (end[2] - end[1]) - apart[1];
  }
  r.contacts = twice / 2;
  return r;
}

}  // namespace talus
