// Lists of the hierarchical cell grid against brute force: random grains with diameters from 1:1 to 1:100, periodic or
// not, moving, several chunks; after every step each owner's list holds every pair within the reaches that it was built
// for, each exactly once, in the order that the sums rely on (I1, I3, I8). TALUS_FULL=1 runs ten times as many scenes.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <set>
#include <string>
#include <utility>

#include "core/base/rng.hpp"
#include "core/scene/scene_file.hpp"
#include "scheduler/step/access.hpp"
#include "tests/determinism/scenes.hpp"
#include "tests/determinism/variants.hpp"

namespace talus::determinism {
namespace {

/// Repeatable numbers in [0, 1) that need no library: a 64-bit congruence.
struct Numbers {
  std::uint64_t state;
  double next() {
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<double>(state >> 11) * 0x1p-53;
  }
};

struct Made {
  Scene scene;
  double ratio = 1;
  bool periodic = false;
};

/// Grains of radius 1 to `ratio` thrown into a box without touching; the coarse ones come first.
Made make_scene(int index) {
  Numbers u{static_cast<std::uint64_t>(index) * 7919 + 17};
  static constexpr double ratios[] = {1, 2, 3, 5, 10, 20, 50, 100};
  Made m;
  m.ratio = ratios[index % 8];
  m.periodic = index / 8 % 2 == 0;
  const double box = 4.2 * m.ratio + 14;
  struct Grain {
    double x[3], r;
  };
  std::vector<Grain> grains;
  const int wanted = 300;
  for (int attempt = 0; attempt < 20000 && static_cast<int>(grains.size()) < wanted; ++attempt) {
    // one of the largest, a few in between, the rest near the smallest
    Grain g{};
    const std::size_t n = grains.size();
    g.r = n == 0 ? m.ratio : (n < 12 ? std::pow(m.ratio, u.next() * (n < 4 ? 0.9 : 0.6)) : 1 + 0.2 * u.next());
    g.r = std::min(g.r, m.ratio);
    // half of the small ones close to the first grain, where they have to be found
    for (double& x : g.x) x = g.r + u.next() * (box - 2 * g.r);
    if (n >= 12 && n % 2 == 0) {
      double d[3], norm = 0;
      for (double& q : d) {
        q = u.next() - 0.5;
        norm += q * q;
      }
      for (int k = 0; k < 3; ++k)
        g.x[k] = grains[0].x[k] + d[k] / std::sqrt(norm) * (grains[0].r + g.r + 0.05 * u.next());
    }
    bool free = true;
    for (const double x : g.x) free = free && x > g.r && x < box - g.r;
    for (const Grain& o : grains) {
      double d2 = 0;
      for (int k = 0; k < 3; ++k) d2 += (g.x[k] - o.x[k]) * (g.x[k] - o.x[k]);
      free = free && d2 > (g.r + o.r) * (g.r + o.r);
    }
    if (free) grains.push_back(g);
  }
  std::string csv = "x,y,z,radius,vx,vy,vz\n";
  for (const Grain& g : grains) {
    char line[256];
    std::snprintf(line, sizeof line, "%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", g.x[0], g.x[1], g.x[2], g.r,
                  u.next() - 0.5, u.next() - 0.5, u.next() - 0.5);
    csv += line;
  }
  const std::string file = temporary_file("levels.csv", csv), side = m.periodic ? "\"periodic\"" : "\"open\"";
  const std::string b = std::to_string(box);
  m.scene = parse_scene("title = \"levels " + std::to_string(index) + "\"\n[domain]\nlower = [0, 0, 0]\nupper = [" + b +
                            ", " + b + ", " + b + "]\nboundary = [" + side + ", " + side + ", " + side +
                            "]\n[time]\nstep = 0.01\nsteps = 1000\n[[material]]\nname = \"grain\"\ndensity = 1\n" +
                            "[contact]\nnormal_stiffness = 100\ntangential_stiffness = 30\nnormal_damping = "
                            "1\nfriction = 0.5\n[[source]]\nkind = \"file\"\nfile = \"" +
                            file + "\"\n",
                        "levels", ".");
  m.scene.list.policy = exact_policies()[static_cast<std::size_t>(index) % exact_policies().size()];
  m.scene.list.verlet_k = 1 + 20 * u.next();
  m.scene.list.automatic = false;
  m.scene.sort_every = 7 + index % 5;
  return m;
}

/// Compares the lists of a world that has just been rebuilt with brute force; returns the number of pairs.
std::int64_t check_lists(const World& w, bool periodic) {
  std::int64_t pairs = 0;
  for (const auto& cp : w.contacts.chunks) {
    const Chunk& c = *cp;
    std::set<std::pair<Row, Row>> listed;
    for (int s = 0; s < 3; ++s) {
      std::pair<Row, Row> last{-1, -1};
      for (std::int64_t q = s == 0 ? 0 : c.list.end[s - 1]; q < c.list.end[s]; ++q) {
        const auto k = static_cast<std::size_t>(q);
        const std::pair<Row, Row> p{c.list.pi[k], c.list.pj[k]};
        if (p.first == w.rows.n) continue;  // padding
        EXPECT_LT(last, p) << "order within section " << s;
        last = p;
        EXPECT_TRUE(p.first >= c.lo && p.first < c.hi);
        EXPECT_EQ(s, p.second < c.lo ? 0 : (p.second < c.hi ? 1 : 2));
        if (s == 1) {
          EXPECT_LT(p.first, p.second);
        }
        EXPECT_TRUE(listed.insert(p).second) << "listed twice";
      }
    }
    for (Row i = c.lo; i < c.hi; ++i)
      for (Row j = 0; j < w.rows.n; ++j) {
        if (i == j || !w.rows.is_alive(i) || !w.rows.is_alive(j) || (j >= c.lo && j < i)) continue;
        double d2 = 0;
        for (int k = 0; k < 3; ++k) {
          double d = w.lists.x0[4L * i + k] - w.lists.x0[4L * j + k];
          if (periodic) d -= w.rules.size[k] * std::nearbyint(d / w.rules.size[k]);
          d2 += d * d;
        }
        const double reach =
            w.lists.frame.stretch * (w.rows.p[4L * i + 3] + w.rows.p[4L * j + 3] + std::sqrt(w.lists.x0[4L * i + 3]) +
                                     std::sqrt(w.lists.x0[4L * j + 3]));
        if (d2 <= reach * reach) {
          EXPECT_TRUE(listed.count({i, j}) == 1) << i << " " << j << " lack each other";
          ++pairs;
        } else if (listed.count({i, j}) == 1) {  // float slack only
          EXPECT_LT(d2, reach * reach * 1.0001 + 1e-4 * reach * w.rules.size[0]);
        }
      }
  }
  return pairs;
}

TEST(CellLevels, ListsEqualBruteForceForRadiiFromOneToHundred) {
  const int count = full_requested() ? 320 : 32;
  std::int64_t pairs = 0;
  int most_levels = 0, rebuilds = 0;
  for (int index = 0; index < count; ++index) {
    const Made m = make_scene(index);
    RunOptions options;
    options.threads = 1 + index % 2;
    options.chunk = index % 3 == 0 ? 64 : 4096;
    options.audit = true;
    Simulation sim(m.scene, options);
    SCOPED_TRACE(m.scene.title);
    std::int64_t seen = -1;
    for (int step = 0; step < 40; ++step) {
      sim.run(1);
      const World& w = EngineAccess::world(sim);
      if (sim.counters().rebuilds == seen) continue;
      seen = sim.counters().rebuilds;
      ++rebuilds;
      // the step that followed the rebuild has moved the rows; removed ones are in no list and in x0 no more
      if (sim.counters().removed == 0) pairs += check_lists(w, m.periodic);
      most_levels = std::max(most_levels, w.lists.grid.levels);
      if (m.ratio >= 20) {
        EXPECT_GE(w.lists.grid.levels, 2) << "the ratio asks for levels";
      }
      if (m.ratio <= 2) {
        EXPECT_EQ(w.lists.grid.levels, 1) << "levels cost and bring nothing here";
      }
    }
    EXPECT_EQ(sim.counters().missed_contacts, 0);
  }
  std::printf("%d scenes, %d rebuilds, up to %d levels, %lld pairs within reach\n", count, rebuilds, most_levels,
              static_cast<long long>(pairs));
  EXPECT_GE(most_levels, 4);
  EXPECT_GT(pairs, 500 * count);
}

// Levels change the way to the list only: one hash for every policy, K, thread count, chunk and instruction set.
TEST(CellLevels, SameBitsForEveryWayOfRunning) {
  for (const int index : {5, 13, 7}) {  // 1:20 periodic and open, 1:100 periodic
    const Made m = make_scene(index);
    std::set<std::uint64_t> hashes;
    std::int64_t contacts = 0;
    int runs = 0;
    for (const Levels& levels : pairwise_cover(level_counts())) {
      const Variant v = variant_of(levels);
      Simulation sim(v.apply(m.scene), v.options());
      for (int part = 0; part < 4; ++part) {
        sim.run(50);
        contacts += sim.counters().contacts;
      }
      if (v.policy != ListPolicy::global_velocity) {  // its one skin for all can make all reaches alike
        EXPECT_GE(EngineAccess::world(sim).lists.grid.levels, 2);
      }
      hashes.insert(sim.state_hash());
      ++runs;
    }
    std::printf("%s: %d combinations, %zu hash\n", m.scene.title.c_str(), runs, hashes.size());
    EXPECT_EQ(hashes.size(), 1U);
    EXPECT_GT(contacts, runs) << "without contacts the order of sums is not tested";
  }
}

}  // namespace
}  // namespace talus::determinism
