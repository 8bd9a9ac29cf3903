// Contacts in a frame are those of the present positions, also where the frame falls on a sort epoch or the list has
// just expired; brute force over the frame's own positions is the witness.
#include <gtest/gtest.h>

#include "tests/determinism/scenes.hpp"

namespace talus::determinism {
namespace {

std::int64_t touching(const Frame& f, const Scene& s) {
  std::int64_t n = 0;
  for (std::size_t i = 0; i < f.x.size(); ++i)
    for (std::size_t j = i + 1; j < f.x.size(); ++j) {
      if (!f.fixed.empty() && f.fixed[i] != 0 && f.fixed[j] != 0) continue;
      Vec3 d = f.x[i] - f.x[j];
      for (int k = 0; k < 3; ++k) {
        const double size = s.domain.upper[k] - s.domain.lower[k];
        if (!s.domain.periodic(k)) continue;
        if (d[k] > 0.5 * size) d[k] -= size;
        if (d[k] < -0.5 * size) d[k] += size;
      }
      const double r = f.r[i] + f.r[j];
      if (norm2(d) < r * r) ++n;
    }
  return n;
}

TEST(Observe, FrameHoldsEveryTouchingPairAlsoAtSortEpochs) {
  for (Scene (*build)() : {sheared_bed, gas}) {
    Scene s = build();
    s.list.policy = ListPolicy::paper;  // lists expire often
    s.list.verlet_k = 3;
    s.list.automatic = false;
    s.sort_every = 40;
    RunOptions o;
    o.threads = 2;
    o.chunk = 64;
    Simulation sim(s, o), undisturbed(s, o);
    std::int64_t all = 0;
    for (int k = 0; k < 12; ++k) {
      sim.run(20);  // every second stop is an epoch
      const Frame f = sim.frame({.contacts = true});
      std::int64_t pairs = 0;
      for (const ContactRecord& c : f.contacts) pairs += c.b >= 0 ? 1 : 0;
      // a difference of positions from the domain's corner may round across the touch: none in these scenes
      EXPECT_EQ(pairs, touching(f, s)) << "step " << f.step;
      all += pairs;
    }
    EXPECT_GT(all, 100);
    undisturbed.run(240);
    EXPECT_EQ(sim.state_hash(), undisturbed.state_hash());
  }
}

}  // namespace
}  // namespace talus::determinism
