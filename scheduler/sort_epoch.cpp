// Sort epoch: compacts the storage and permutes it into Morton order.
// Who calls it: the rebuild node, at steps fixed by the scene. Invariant: I3 (the order is a function of the
// trajectory).
#include <algorithm>
#include <cstring>

#include "scheduler/parallel.hpp"
#include "scheduler/world.hpp"

namespace talus {

namespace {

std::uint64_t spread21(std::uint64_t x) {
  x &= 0x1fffff;
  x = (x | x << 32) & 0x1f00000000ffff;
  x = (x | x << 16) & 0x1f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  x = (x | x << 2) & 0x1249249249249249;
  return x;
}

std::int32_t cell_of(double x, double inverse, std::int32_t n) {
  const auto c = static_cast<std::int32_t>(x * inverse);
  return c < 0 ? 0 : (c >= n ? n - 1 : c);
}

}  // namespace

void sort_epoch(World& w) {
  std::vector<ContactEntry> contacts = list_contacts(w);  // distribute_contacts() sorts by the new rows
  std::vector<WallEntry> walls = collect_wall_states(w);
  // The key comes from a grid of the scene alone, never from the list's cells (I3).
  const double inverse = 1.0 / (2.6 * w.r_max);
  std::vector<std::pair<std::uint64_t, Row>> keys;
  keys.reserve(static_cast<std::size_t>(w.alive));
  for (Row i = 0; i < w.n; ++i) {
    if (!w.is_alive(i)) continue;
    const double* x = w.p.data() + 4L * i;
    std::uint64_t k = 0;
    for (int a = 0; a < 3; ++a)
      k |= spread21(static_cast<std::uint64_t>(cell_of(fmin2(x[a], w.size[a]), inverse, 1 << 21))) << a;
    keys.emplace_back(k, i);
  }
  std::sort(keys.begin(), keys.end());  // ties by row: stable
  std::vector<Row> inverse_row(static_cast<std::size_t>(w.n), -1);
  for (std::size_t q = 0; q < keys.size(); ++q)
    inverse_row[static_cast<std::size_t>(keys[q].second)] = static_cast<Row>(q);
  const auto n = static_cast<Row>(keys.size());
  const int stride = w.stride;
  parallel(w, w.threads, [&](int b) {
    for (std::size_t q = keys.size() * b / w.threads; q < keys.size() * (b + 1) / w.threads; ++q) {
      const long o = keys[q].second;
      std::memcpy(w.p2.data() + 4 * q, w.p.data() + 4 * o, 4 * sizeof(double));
      std::memcpy(w.v2.data() + stride * q, w.v.data() + stride * o, static_cast<std::size_t>(stride) * sizeof(double));
    }
  });
  std::swap(w.p, w.p2);
  std::swap(w.v, w.v2);
  const auto permute = [&](auto& column) {
    auto copy = column;
    for (std::size_t q = 0; q < keys.size(); ++q) column[q] = copy[static_cast<std::size_t>(keys[q].second)];
  };
  permute(w.id);
  if (w.has.materials) permute(w.material);
  if (w.has.fixed) permute(w.fixed);
  if (w.has.groups) permute(w.group);
  std::size_t kept = 0;
  for (ContactEntry& e : contacts) {
    e.a = inverse_row[static_cast<std::size_t>(e.a)];
    e.b = inverse_row[static_cast<std::size_t>(e.b)];
    if (e.a >= 0 && e.b >= 0) contacts[kept++] = e;
  }
  contacts.resize(kept);
  kept = 0;
  for (WallEntry& s : walls) {
    s.row = inverse_row[static_cast<std::size_t>(s.row)];
    if (s.row >= 0) walls[kept++] = s;
  }
  walls.resize(kept);
  set_particle_capacity(w, n);
  w.velocity_at_old_step = false;
  make_chunks(w);
  distribute_contacts(w, contacts, walls);
  ++w.counters.sort_epochs;
}

}  // namespace talus
