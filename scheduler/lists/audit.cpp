// The audit of the lists (RunOptions::audit): what touches now and is in no list. Who calls it: the node that starts a
// step. Invariant: it finds its pairs without the cells, levels and skins under test.
#include "scheduler/lists/audit.hpp"

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "scheduler/lists/skin_check.hpp"

namespace talus {

namespace {

using Pair = std::pair<Row, Row>;

std::vector<Pair> listed_pairs(const Contacts& contacts) {
  std::vector<Pair> listed;
  for (const auto& c : contacts.chunks)
    for (std::int64_t s = 0; s < c->list.end[2]; ++s) {
      const Row i = c->list.pi[static_cast<std::size_t>(s)], j = c->list.pj[static_cast<std::size_t>(s)];
      listed.emplace_back(std::min(i, j), std::max(i, j));
    }
  std::sort(listed.begin(), listed.end());
  return listed;
}

/// By row: radius and, for adhesive laws, what forces reach beyond it [m] (a cube root: once per row).
std::vector<double> reaches(const Rows& rows, const Lists& lists) {
  std::vector<double> reach(static_cast<std::size_t>(rows.n));
  for (Row i = 0; i < rows.n; ++i)
    reach[static_cast<std::size_t>(i)] = rows.p[4L * i + 3] + lists.skin.range(rows.p[4L * i + 3]);
  return reach;
}

bool touch(const Rules& rules, const Rows& rows, Row i, Row j, double r) {
  const double *a = rows.p.data() + 4L * i, *b = rows.p.data() + 4L * j;
  return norm2(rules.scene.domain.box().nearest({a[0] - b[0], a[1] - b[1], a[2] - b[2]})) < r * r;
}

/// Rows in strips across the domain's second longest side, sorted along the longest one within each: partners are in
/// the same strip or the next one. Sorted along one side alone, 120k grains in a thin layer took 15 s per step.
class Strips {
 public:
  Strips(const Rules& rules, const Rows& rows, const std::vector<double>& reach)
      : rules_(rules), grains_(rows), reach_(reach) {
    for (int k = 1; k < 3; ++k)
      if (rules.size[k] > rules.size[along_]) along_ = k;
    across_ = along_ == 0 ? 1 : 0;
    for (int k = 0; k < 3; ++k)
      if (k != along_ && rules.size[k] > rules.size[across_]) across_ = k;
    std::int64_t alive = 0;
    for (Row i = 0; i < rows.n; ++i)
      if (rows.is_alive(i)) {
        largest_ = std::max(largest_, reach[static_cast<std::size_t>(i)]);
        ++alive;
      }
    // a hair more than the reach: only what cannot touch may be left out
    const double width = 2 * largest_ * (1 + 1e-9);
    const double fit = width > 0 ? rules.size[across_] / width : 1;
    auto count = static_cast<std::int64_t>(std::clamp(fit, 1.0, static_cast<double>(std::max<std::int64_t>(1, alive))));
    if (rules.scene.domain.periodic(across_) && count < 3) count = 1;  // the first and the last would meet twice
    strips_.resize(static_cast<std::size_t>(count));
    for (Row i = 0; i < rows.n; ++i)
      if (rows.is_alive(i)) strips_[strip_of(i)].push_back(i);
    for (auto& strip : strips_)
      std::sort(strip.begin(), strip.end(), [&](Row i, Row j) { return place(i) < place(j); });
  }

  /// Calls found(i, j) once for every pair that may touch.
  template <class F>
  void for_pairs(F found) const {
    const bool ring = rules_.scene.domain.periodic(along_);
    const double turn = rules_.size[along_];
    for (std::size_t s = 0; s < strips_.size(); ++s) {
      const auto& own = strips_[s];
      const bool last = s + 1 == strips_.size();
      const bool wraps = last && strips_.size() > 1 && rules_.scene.domain.periodic(across_);
      const std::vector<Row>* next = last ? (wraps ? strips_.data() : nullptr) : &strips_[s + 1];
      for (std::size_t k = 0; k < own.size(); ++k) {
        const Row i = own[k];
        const double reach = (reach_[static_cast<std::size_t>(i)] + largest_) * (1 + 1e-9), x = place(i);
        std::size_t q = k + 1;
        for (; q < own.size() && place(own[q]) <= x + reach; ++q) found(i, own[q]);
        if (ring && q == own.size())  // not where they have met already
          for (std::size_t p = 0; p < k && place(own[p]) + turn <= x + reach; ++p) found(i, own[p]);
        if (next == nullptr) continue;
        for (const double shift : {0.0, -turn, turn}) {
          if (shift != 0 && !ring) continue;
          auto p = std::lower_bound(next->begin(), next->end(), x - reach,
                                    [&](Row j, double least) { return place(j) + shift < least; });
          for (; p != next->end() && place(*p) + shift <= x + reach; ++p) found(i, *p);
        }
      }
    }
  }

 private:
  double place(Row i) const { return grains_.p[4L * i + along_]; }
  std::size_t strip_of(Row i) const {
    const double size = rules_.size[across_];
    double y = grains_.p[4L * i + across_];
    if (rules_.scene.domain.periodic(across_)) y += y < 0 ? size : (y >= size ? -size : 0);
    const auto count = static_cast<double>(strips_.size());
    return static_cast<std::size_t>(std::clamp(y / size * count, 0.0, count - 1));
  }

  const Rules& rules_;
  const Rows& grains_;
  const std::vector<double>& reach_;
  int along_ = 0, across_ = 1;
  double largest_ = 0;
  std::vector<std::vector<Row>> strips_;
};

/// Contacts of a row with walls, all images asked, that its candidates do not yield.
std::int64_t missed_walls(const Rules& rules, const Rows& rows, const Contacts& contacts, const Lists& lists,
                          const WallSet& walls, Row i, std::vector<std::int32_t>& all) {
  all.clear();
  WallContact near[WallSet::k_max_contacts], listed[WallSet::k_max_contacts];
  const Vec3 centre{rows.p[4L * i], rows.p[4L * i + 1], rows.p[4L * i + 2]};
  const double reach = rows.p[4L * i + 3] + 2 * lists.skin.range(rows.p[4L * i + 3]);
  walls.audit_candidates(centre, reach, all);
  const int n = all.empty() ? 0 : walls.contacts(centre, reach, all, near);
  const Chunk& c = *contacts.chunks[static_cast<std::size_t>(contacts.chunk_of(i))];
  const auto at = std::lower_bound(c.wall.row.begin(), c.wall.row.end(), i);
  const bool has = at != c.wall.row.end() && *at == i;
  int m = 0;
  if (has) {
    const auto row = static_cast<std::size_t>(at - c.wall.row.begin());
    const std::span<const std::int32_t> own(c.wall.element.data() + c.wall.begin[row],
                                            c.wall.element.data() + c.wall.begin[row + 1]);
    const double* listed_at = (lists.skin.cuts() ? lists.outer : lists.x0).data() + 4L * i;
    m = walls.contacts(centre, reach, own, listed, wraps_of(rules, rows.p.data() + 4L * i, listed_at));
  }
  std::int64_t missed = 0;
  for (int k = 0; k < n; ++k)
    missed += std::none_of(listed, listed + m,
                           [&](const WallContact& t) {
                             return t.element == near[k].element && t.distance == near[k].distance &&
                                    norm2(t.centre - near[k].centre) == 0;
                           })
                  ? 1
                  : 0;
  return missed;
}

}  // namespace

std::int64_t audit_lists(const Rules& rules, const Rows& rows, const Contacts& contacts, const Lists& lists,
                         const WallSet& walls) {
  const std::vector<Pair> listed = listed_pairs(contacts);
  const std::vector<double> reach = reaches(rows, lists);
  std::int64_t missed = 0;
  Strips(rules, rows, reach).for_pairs([&](Row i, Row j) {
    if (rules.has.fixed && rows.fixed[i] != 0 && rows.fixed[j] != 0) return;
    if (rows.body_of(i) >= 0 && rows.body_of(i) == rows.body_of(j)) return;
    if (touch(rules, rows, i, j, reach[static_cast<std::size_t>(i)] + reach[static_cast<std::size_t>(j)]) &&
        !std::binary_search(listed.begin(), listed.end(), Pair(std::min(i, j), std::max(i, j))))
      ++missed;
  });
  std::vector<std::int32_t> all;
  if (rules.has.walls)
    for (Row i = 0; i < rows.n; ++i)
      if (rows.is_alive(i) && !(rules.has.fixed && rows.fixed[i] != 0))
        missed += missed_walls(rules, rows, contacts, lists, walls, i, all);
  return missed;
}

}  // namespace talus
