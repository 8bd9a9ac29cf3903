// See hash.hpp. A column that is added gets a term of its own, with its own seed: scenes without it keep their hashes.
#include "scheduler/state/hash.hpp"

#include <xxhash.h>

#include <algorithm>
#include <cstring>
#include <vector>

namespace talus {

namespace {

std::uint64_t hash_of_rows(const Rows& rows) {
  std::uint64_t sum = 0;
  for (Row i = 0; i < rows.n; ++i) {
    if (!rows.is_alive(i)) continue;
    struct {
      ParticleId id;
      double x[4], v[8];
    } t{};
    t.id = rows.id[i];
    std::memcpy(t.x, rows.p.data() + 4L * i, sizeof t.x);
    std::memcpy(t.v, rows.v.data() + static_cast<long>(rows.stride) * i,
                sizeof(double) * static_cast<std::size_t>(rows.stride));
    sum += XXH3_64bits(&t, sizeof t);
  }
  return sum;
}

std::uint64_t hash_of_columns(const Rows& rows) {
  std::uint64_t sum = 0;
  for (const Columns::Entry& e : rows.columns.all()) {
    if (!e.info.in || e.info.hash_seed == 0) continue;
    std::vector<unsigned char> t(sizeof(ParticleId) + e.bytes);
    for (Row i = 0; i < rows.n; ++i) {
      if (!rows.is_alive(i)) continue;
      std::memcpy(t.data(), &rows.id[i], sizeof(ParticleId));
      std::memcpy(t.data() + sizeof(ParticleId), e.data() + e.bytes * static_cast<std::size_t>(i), e.bytes);
      sum += XXH3_64bits_withSeed(t.data(), t.size(), e.info.hash_seed);
    }
  }
  return sum;
}

/// Bodies, under the number of their first sphere.
std::uint64_t hash_of_bodies(const Rows& rows) {
  std::uint64_t sum = 0;
  for (const Columns::Entry& e : rows.bodies.columns.all()) {
    if (!e.info.in) continue;
    std::vector<unsigned char> t(sizeof(ParticleId) + e.bytes);
    for (std::int32_t b = 0; b < rows.bodies.n; ++b) {
      const Row first = rows.bodies.first[static_cast<std::size_t>(b)];
      if (!rows.is_alive(first)) continue;
      std::memcpy(t.data(), &rows.id[first], sizeof(ParticleId));
      std::memcpy(t.data() + sizeof(ParticleId), e.data() + e.bytes * static_cast<std::size_t>(b), e.bytes);
      sum += XXH3_64bits_withSeed(t.data(), t.size(), e.info.hash_seed);
    }
  }
  return sum;
}

/// History of one contact; first and second: ids of the partners, lower first, or id and -1 - wall. `flip`: it is
/// oriented from the higher id to the lower one.
std::uint64_t hash_of_history(const Rules& rules, std::int64_t first, std::int64_t second, const double* law,
                              const double* moments, bool flip, std::uint64_t seed) {
  struct {
    std::int64_t a, b;
    double h[k_max_history];
  } t{};
  t.a = first;
  t.b = second;
  for (int k = 0; k < rules.has.law_columns; ++k) t.h[k] = flip && rules.flips(k) ? -law[k] : law[k];
  // laws of at most k_usual_history columns keep the hashes that they had before there was a wider one
  const auto unused = static_cast<std::size_t>(k_max_history - std::max(rules.has.law_columns, k_usual_history));
  std::uint64_t sum = XXH3_64bits(&t, sizeof t - unused * sizeof(double));
  if (rules.has.moments) {
    double m[k_max_moment + 2] = {};
    std::memcpy(m, &t.a, sizeof t.a);
    std::memcpy(m + 1, &t.b, sizeof t.b);
    for (int k = 0; k < rules.has.moment_columns; ++k)
      m[k + 2] = flip && rules.flips(rules.has.law_columns + k) ? -moments[k] : moments[k];
    sum += XXH3_64bits_withSeed(m, sizeof m, seed);
  }
  return sum;
}

std::uint64_t hash_of_contacts(const Rules& rules, const Rows& rows, const Contacts& contacts, bool failed) {
  std::uint64_t sum = 0;
  for (const auto& c : contacts.chunks)
    for (const ContactEntry& e : contacts_of(rules, *c, failed)) {
      if (!rows.is_alive(e.a) || !rows.is_alive(e.b)) continue;
      const bool flip = rows.id[e.a] > rows.id[e.b];
      sum += hash_of_history(rules, rows.id[flip ? e.b : e.a], rows.id[flip ? e.a : e.b], e.h,
                             e.h + rules.has.law_columns, flip, 4);
    }
  for (const WallEntry& s : collect_wall_states(rules, contacts))
    if (rows.is_alive(s.row)) sum += hash_of_history(rules, rows.id[s.row], -1 - s.contact.wall, s.h, s.m, false, 5);
  return sum;
}

}  // namespace

std::uint64_t state_hash(const Rules& rules, const Clock& clock, const Rows& rows, const Contacts& contacts,
                         const Insertion& insertion, bool failed) {
  std::uint64_t sum = hash_of_rows(rows) + hash_of_columns(rows) + hash_of_bodies(rows);
  // a neck beyond touch is state, with or without history
  if (rules.has.history_columns > 0 || rules.has.adhesion) sum += hash_of_contacts(rules, rows, contacts, failed);
  sum += XXH3_64bits_withSeed(&clock.step, sizeof clock.step, 1);
  sum += XXH3_64bits_withSeed(&rows.next_id, sizeof rows.next_id, 2);
  const std::vector<std::uint8_t> bytes = insertion.save();
  return sum + XXH3_64bits_withSeed(bytes.data(), bytes.size(), 3);
}

}  // namespace talus
