// See tuner.hpp.
#include "scheduler/lists/tuner.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

#include "scheduler/lists/rebuild.hpp"
#include "scheduler/team/parallel.hpp"

namespace talus {

namespace {

constexpr double k_first[2] = {20, 300};  // of the first guess
constexpr double k_least_k = 1, k_most_k = 5000, k_least_floor = 1e-4, k_most_floor = 0.25;
constexpr double k_weight = 0.5;     // of one interval in the moving average of ln K and ln floor
constexpr double k_most_change = 2;  // of K or floor in one rebuild
// Intervals that nobody looks at once K has settled, unless one is unexpectedly short or long. A look costs some 20 ns
// per particle, a rebuild 110 (chute of 32k grains).
constexpr int k_rest = 3;
// Share of the run time that rebuilds should not exceed, and how much longer than cheapest lists may last for it: the
// optimum is flat, 1.25 costs (1.25 + 1 / 1.25) / 2 - 1 = 2.5 % of the lists' own cost, 2 costs 25 %. With a velocity
// profile, where that cost is some 6 % of a step, K = 200 was as fast as what the model takes for the optimum, 100 to
// 140.
constexpr double k_share = 0.037, k_longer = 1.25, k_longer_profile = 2;
constexpr std::int64_t k_sample = 16;  // every k_sample-th group of 8 slots is looked at
constexpr int k_wall_sample = 16;      // and every k_wall_sample-th row near a wall

// Classes of skins, in diameters: two per octave of the square, from 2^-28 (6e-5 d) on.
constexpr int k_first_class = (127 - 28) * 2, k_classes = 2 * 30;

double square(double a) { return a * a; }

int class_of(double square) {
  const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(square));
  return std::clamp(static_cast<int>(bits >> 22) - k_first_class, 0, k_classes - 1);
}

}  // namespace

void RecentMedian::add(double x) noexcept {
  last_[count_ % k_size] = x;
  if (++count_ == 2 * k_size) count_ = k_size;
}

double RecentMedian::value() const noexcept {
  if (count_ == 0) return 0;
  const int n = std::min(count_, k_size);
  double sorted[k_size];
  for (int k = 0; k < n; ++k) {
    int at = k;
    for (; at > 0 && sorted[at - 1] > last_[k]; --at) sorted[at] = sorted[at - 1];
    sorted[at] = last_[k];
  }
  return sorted[n < 3 ? 0 : n / 2];
}

/// What an interval has used of the skins, by class of skin; lengths in diameters. Rows at the floor are apart: their
/// speeds say nothing about their skins.
struct SkinTuner::Use {
  double rows[k_classes] = {}, skin[k_classes] = {};       ///< number, sum of skins
  double travel2[k_classes] = {}, ratio2[k_classes] = {};  ///< largest; of (travel / skin)^2
  double floor_rows = 0, floor_travel2 = 0, floor_ratio2 = 0;
  double cap_rows = 0, cap_skin = 0, cap_ratio2 = 0;  ///< rows whose skin is capped: no K changes it
  double life2 = 0;                                   ///< of (interval / life of the lists)^2, where K sets that life

  void add(const Use& o) {
    for (int k = 0; k < k_classes; ++k) {
      rows[k] += o.rows[k];
      skin[k] += o.skin[k];
      travel2[k] = fmax2(travel2[k], o.travel2[k]);
      ratio2[k] = fmax2(ratio2[k], o.ratio2[k]);
    }
    floor_rows += o.floor_rows;
    floor_travel2 = fmax2(floor_travel2, o.floor_travel2);
    floor_ratio2 = fmax2(floor_ratio2, o.floor_ratio2);
    cap_rows += o.cap_rows;
    cap_skin += o.cap_skin;
    cap_ratio2 = fmax2(cap_ratio2, o.cap_ratio2);
  }
  double largest_ratio2() const {
    double q = fmax2(life2, fmax2(floor_ratio2, cap_ratio2));
    for (const double r : ratio2) q = fmax2(q, r);
    return q;
  }
};

void SkinTuner::prepare(const Rules& rules, const SkinRule& skin) {
  on_ = rules.scene.list.automatic && skin.has_k();
  has_floor_ = skin.floor_on;
  k_ = rules.scene.list.verlet_k;
  floor_ = rules.scene.list.floor;
  spacing_ = static_cast<double>(rules.scene.sort_every);
}

/// K before anything is measured: K* = c (v dt / R)^-1/2 (cost model of tuner.hpp with pairs that grow with s / R), c
/// from the chute of 32k grains.
void SkinTuner::guess(const Rules& rules, const Clock& clock, const Rows& rows, Lists& lists) {
  double speeds = 0, radii = 0, count = 0;
  for (Row i = 0; i < rows.n; ++i) {
    if (!rows.is_alive(i) || (rules.has.fixed && rows.fixed[i] != 0)) continue;
    const double* v = rows.v.data() + static_cast<long>(rules.stride) * i;
    speeds += __builtin_sqrt((v[0] * v[0] + v[1] * v[1]) + v[2] * v[2]);
    radii += rows.p[4L * i + 3];
    count += 1;
  }
  if (!(count > 0) || !(speeds < 1e200)) return;
  cut_ = clock.step;
  k_ = speeds > 0 ? std::clamp(2.3 * __builtin_sqrt(radii / (speeds * rules.scene.dt)), k_first[0], k_first[1])
                  : k_first[1];
  lists.skin.k_dt = k_ * rules.scene.dt;
  guessed_ = true;
}

SkinTuner::Ticks SkinTuner::ticks(const Rules& rules, const Team& team) const {
  Ticks t;
  t.narrow = team.times.ticks(Node::narrow_phase);
  t.walls = rules.has.walls ? team.times.ticks(Node::wall_contact) : 0;
  t.step = t.narrow + t.walls + team.times.ticks(Node::contact_force) + team.times.ticks(Node::integrate);
  return t;
}

SkinTuner::Use SkinTuner::used_skins(const Rules& rules, const Clock& clock, const Rows& rows, const Contacts& contacts,
                                     const Lists& lists, Team& team) const {
  std::vector<Use> parts(contacts.chunks.size());
  const double floor2 = has_floor_ ? floor_ * floor_ * (1 + 1e-9) : 0;
  parallel(team, static_cast<int>(contacts.chunks.size()), [&](int q) {
    const Chunk& c = *contacts.chunks[static_cast<std::size_t>(q)];
    Use& use = parts[static_cast<std::size_t>(q)];
    const Row last = std::min(c.hi, lists.frame.rows);  // an insertion may have appended rows since
    for (Row i = c.lo; i < last; ++i) {
      const double *x = rows.p.data() + 4L * i, *ref = lists.x0.data() + 4L * i;
      if (!(x[0] < k_far) || !(ref[3] > 0) || !(ref[3] < k_far)) continue;
      const double size2 = 4 * x[3] * x[3], skin2 = ref[3] / size2,
                   travelled2 = used2(rules, clock, rows, lists, i) / size2;
      const double ratio2 = travelled2 / skin2;
      if (skin2 <= floor2) {
        use.floor_rows += 1;
        use.floor_travel2 = fmax2(use.floor_travel2, travelled2);
        use.floor_ratio2 = fmax2(use.floor_ratio2, ratio2);
        continue;
      }
      const double most = lists.skin.most(x[3]) / (2 * x[3]);
      if (skin2 >= most * most * (1 - 1e-9)) {
        use.cap_rows += 1;
        use.cap_skin += __builtin_sqrt(skin2);
        use.cap_ratio2 = fmax2(use.cap_ratio2, ratio2);
        continue;
      }
      const int k = class_of(skin2);
      use.rows[k] += 1;
      use.skin[k] += __builtin_sqrt(skin2);
      use.travel2[k] = fmax2(use.travel2[k], travelled2);
      use.ratio2[k] = fmax2(use.ratio2[k], ratio2);
    }
  });
  Use all;
  for (const Use& u : parts) all.add(u);
  if (lists.skin.policy->ages)
    all.life2 = square(static_cast<double>(clock.step - lists.frame.built) * rules.scene.dt / lists.skin.k_dt);
  return all;
}

void SkinTuner::interval_ends(const Rules& rules, const Clock& clock, const Rows& rows, const Contacts& contacts,
                              Lists& lists, Team& team) {
  if (!on_ || ended_ == clock.step) return;
  ended_ = clock.step;
  if (!guessed_) return guess(rules, clock, rows, lists);
  const std::int64_t steps = clock.step - lists.frame.built;
  if (lists.frame.rows == 0 || steps <= 0) return;
  if (rest_ > 0 && static_cast<double>(steps) > 0.7 * wanted_ && static_cast<double>(steps) < 1.4 * wanted_) {
    --rest_;
    return;
  }
  rest_ = 0;
  const Ticks now = ticks(rules, team);
  // Rows and contacts have their part in the narrow phase, in slots: 0.9 and 0.1. A further slot costs 0.9 ns whatever
  // the bed (uniform skins of 0.01 to 0.1 d, AMD Zen 5); what is left is worth 0.4 slots per row at rest, 1.0 and 1.6
  // in flowing beds of 32k and 128k grains.
  const double work = slots_ + 0.9 * static_cast<double>(rows.alive) + 0.1 * contacts_;
  // less: the profile was restarted in between
  if (now.narrow > begin_.narrow && now.walls >= begin_.walls && now.step > begin_.step && sampled_) {
    const auto n = static_cast<double>(steps);
    pair_.add(static_cast<double>(now.narrow - begin_.narrow) / (n * work));
    // a contact with a wall costs some three candidates
    if (wall_pairs_ > 0)
      wall_pair_.add(static_cast<double>(now.walls - begin_.walls) / (n * (wall_pairs_ + 3 * wall_contacts(contacts))));
    step_.add(static_cast<double>(now.step - begin_.step) / n);
  }
  const Use use = used_skins(rules, clock, rows, contacts, lists, team);
  if (use.largest_ratio2() < 1) {  // an epoch, an insertion, a wall
    // two cuts close together are chance: down in half steps, up at once
    const auto spacing = static_cast<double>(clock.step - cut_);
    if (spacing > 0) spacing_ = spacing < spacing_ ? __builtin_sqrt(spacing * spacing_) : spacing;
    cut_ = clock.step;
  }
  choose(rules, lists, use, static_cast<double>(steps));
}

/// `use` holds for an interval of `steps`.
void SkinTuner::choose(const Rules& rules, Lists& lists, const Use& use, double steps) {
  // 1. The (K', floor') of least total skin among those that last as long: K' = K * factor covers the classes that
  // floor' does not. Floors are tried upwards from what the rows at the floor need.
  double present = use.floor_rows * floor_ + use.cap_skin, least = 1e300, factor = 1, floor = floor_;
  for (const double s : use.skin) present += s;
  double tried = has_floor_ ? fmax2(__builtin_sqrt(use.floor_travel2), k_least_floor) : 0;
  for (int round = 0; round < 40; ++round, tried *= 1.2) {
    double f = use.life2, total = use.floor_rows * tried + use.cap_skin;
    for (int k = 0; k < k_classes; ++k)
      if (use.rows[k] > 0 && use.travel2[k] > tried * tried) f = fmax2(f, use.ratio2[k]);
    f = __builtin_sqrt(f);
    for (int k = 0; k < k_classes; ++k) total += fmax2(f * use.skin[k], tried * use.rows[k]);
    if (total < least) {
      least = total;
      factor = f;
      floor = tried;
    }
    if (!has_floor_ || tried > k_most_floor) break;
  }
  // 2. How long lists should last.
  const double rebuild = list_ticks(), pair = pair_.value();
  if (!(present > 0) || !(least > 0) || !(rebuild > 0) || !(pair > 0)) return;
  // a pair costs at its rebuild as much as in 3 steps: 8 ns
  const double share = least / present;
  const double slope =
      pair * fmax2(gain_ * share, 1e-3 * slots_) * (1 + 3 / steps) + wall_pair_.value() * wall_gain_ * share;
  double ideal = __builtin_sqrt(rebuild * steps / slope);
  // the share that rebuilds should keep to, where that is near
  const double longer = step_.value() > 0 ? rebuild * (1 - k_share) / (k_share * step_.value()) : 0;
  if (lists.skin.policy->ages)
    ideal = fmax2(ideal, fmin2(longer, k_longer_profile * ideal));
  else if (longer > ideal && longer < k_longer * ideal)
    ideal = longer;
  ideal = fmin2(ideal, 1.2 * spacing_);
  if (use.cap_ratio2 > 0) ideal = fmin2(ideal, 1.05 * steps / __builtin_sqrt(use.cap_ratio2));
  ideal = fmax2(ideal, 1);
  // 3. A step towards it; an interval much shorter than wanted says little about a long one.
  const double weight = (learned_ ? k_weight : 1) * fmin2(1, 2 * steps / ideal), scale = ideal / steps;
  learned_ = true;
  wanted_ = ideal;
  const double k_before = k_;
  const auto move = [&](double& value, double to, double low, double high) {
    const double ratio = std::clamp(to / value, 1 / k_most_change, k_most_change);
    value = std::clamp(value * std::pow(ratio, weight), low, high);
  };
  if (factor > 0) move(k_, factor * k_ * scale, k_least_k, k_most_k);
  if (has_floor_) move(floor_, floor * scale, k_least_floor, k_most_floor);
  if (k_ > 0.9 * k_before && k_ < 1.1 * k_before) rest_ = k_rest;
  lists.skin.k_dt = k_ * rules.scene.dt;
  lists.skin.floor = floor_;
}

bool rebuild_tuned(const Rules& rules, const Clock& clock, const Rows& rows, Contacts& contacts, Lists& lists,
                   Counters& counters, WallSet& walls, Team& team, bool may_cut) {
  const std::uint64_t begin = __rdtsc();
  lists.tuner.interval_ends(rules, clock, rows, contacts, lists, team);
  const bool cut = may_cut && cut_lists(rules, clock, rows, contacts, lists, counters, walls, team);
  if (!cut) rebuild_lists(rules, clock, rows, contacts, lists, counters, walls, team);
  lists.tuner.list_built(rules, rows, contacts, lists, walls, team,
                         static_cast<double>(__rdtsc() - begin) * rules.threads, cut);
  return cut;
}

/// What a new list costs, on an average over an outer one and the inner ones cut out of it.
double SkinTuner::list_ticks() const noexcept {
  return (rebuild_.value() + cuts_each_ * cut_list_.value()) / (1 + cuts_each_);
}

void SkinTuner::list_built(const Rules& rules, const Rows& rows, const Contacts& contacts, const Lists& lists,
                           const WallSet& walls, Team& team, double rebuild_ticks, bool cut) {
  if (!on_) return;
  if (cut) {
    cuts_ += 1;
  } else {
    cuts_each_ = k_weight * (cuts_each_ + cuts_);
    cuts_ = 0;
  }
  sampled_ = rest_ == 0;
  if (!sampled_) return;
  (cut ? cut_list_ : rebuild_).add(rebuild_ticks);
  begin_ = ticks(rules, team);
  // pairs whose gap lies between 3/4 and 1 of their skins: what a change of skins adds or takes
  const double stretch = 1 / (1 - 0.75 * (1 - 1 / lists.frame.stretch));  // that of 3/4 of the lists' life
  std::vector<std::int64_t> near_of(contacts.chunks.size());
  parallel(team, static_cast<int>(contacts.chunks.size()), [&](int q) {
    const Chunk& c = *contacts.chunks[static_cast<std::size_t>(q)];
    std::int64_t near = 0;
    for (std::int64_t group = 8 * (c.index % k_sample); group < c.list.end[2]; group += 8 * k_sample)
      for (std::int64_t k = group; k < group + 8; ++k) {
        const Row i = c.list.pi[static_cast<std::size_t>(k)], j = c.list.pj[static_cast<std::size_t>(k)];
        if (i >= rows.n || j >= rows.n) continue;  // padding
        const double *x = rows.p.data() + 4L * i, *y = rows.p.data() + 4L * j;
        const double skins = __builtin_sqrt(lists.x0[4L * i + 3]) + __builtin_sqrt(lists.x0[4L * j + 3]);
        const double touch = x[3] + lists.skin.range(x[3]) + y[3] + lists.skin.range(y[3]);
        near += distance2(rules, x, y) > square((touch + 0.75 * skins) * stretch) ? 1 : 0;
      }
    near_of[static_cast<std::size_t>(q)] = near;
  });
  std::int64_t near = 0;
  slots_ = contacts_ = 0;
  for (std::size_t q = 0; q < contacts.chunks.size(); ++q) {
    slots_ += static_cast<double>(contacts.chunks[q]->list.end[2]);
    contacts_ += static_cast<double>(contacts.chunks[q]->contacts.end[2]);
    near += near_of[q];
  }
  gain_ = 4.0 * k_sample * static_cast<double>(near);
  if (rules.has.walls) sample_walls(rules, rows, contacts, lists, walls, team);
}

/// The same for walls: what the candidates of a sample of rows would be with 3/4 of their skins.
void SkinTuner::sample_walls(const Rules& rules, const Rows& rows, const Contacts& contacts, const Lists& lists,
                             const WallSet& walls, Team& team) {
  struct Sums {
    double pairs = 0, sampled = 0, fewer = 0;
  };
  std::vector<Sums> parts(contacts.chunks.size());
  parallel(team, static_cast<int>(contacts.chunks.size()), [&](int q) {
    const Chunk& c = *contacts.chunks[static_cast<std::size_t>(q)];
    std::vector<std::int32_t> found;
    Sums s;
    s.pairs = static_cast<double>(c.wall.element.size());
    for (std::size_t k = static_cast<std::size_t>(c.index % k_wall_sample); k < c.wall.row.size(); k += k_wall_sample) {
      const double* x = rows.p.data() + 4L * c.wall.row[k];
      const double* ref = (lists.skin.cuts() ? lists.outer : lists.x0).data() + 4L * c.wall.row[k];
      const double skin = lists.skin.to_walls(lists.skin.cuts() ? ref[3] : __builtin_sqrt(ref[3]));
      const double drift = drift_reach(lists, c.wall.row[k]);
      found.clear();
      walls.candidates({x[0], x[1], x[2]}, x[3] + 2 * lists.skin.range(x[3]) + 0.75 * (skin + drift), found);
      s.sampled += static_cast<double>(c.wall.begin[k + 1] - c.wall.begin[k]);
      s.fewer += static_cast<double>(found.size());
    }
    parts[static_cast<std::size_t>(q)] = s;
  });
  Sums all;
  for (const Sums& s : parts) {
    all.pairs += s.pairs;
    all.sampled += s.sampled;
    all.fewer += s.fewer;
  }
  wall_pairs_ = all.pairs;
  wall_gain_ = all.sampled > 0 ? 4 * fmax2(all.sampled - all.fewer, 0) * all.pairs / all.sampled : 0;
}

double SkinTuner::wall_contacts(const Contacts& contacts) {
  double n = 0;
  for (const auto& c : contacts.chunks) n += static_cast<double>(c->wall.state.size());
  return n;
}

}  // namespace talus
