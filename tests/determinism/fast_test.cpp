// precision = "fast": the bits may depend on the instruction set, but on nothing else that may change how a scene runs,
// and they stay within rounding of the exact mode's for as long as rounding has not grown.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/base/error.hpp"
#include "kernels/kernel_table.hpp"
#include "tests/determinism/scenes.hpp"
#include "tests/determinism/variants.hpp"

namespace talus::determinism {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool k_fuses = false;  // at the sanitizers' level of optimisation the compiler may fuse nothing
#else
constexpr bool k_fuses = true;
#endif

Scene fast(Scene s) {
  s.precision = Precision::fast;
  return s;
}

std::vector<Isa> fast_isas() {
  std::vector<Isa> v;
  for (const Isa isa : available_isas()) {
    try {
      select_kernels(isa, nullptr, Precision::fast);
      v.push_back(isa);
    } catch (const Error&) {
    }
  }
  return v;
}

std::uint64_t hash_after(const Scene& scene, const RunOptions& options, std::int64_t steps) {
  Simulation sim(scene, options);
  sim.run(steps);
  return sim.state_hash();
}

/// The bed with resistance to rolling and twisting: spins are differences of products.
template <Rolling Kind>
Scene rolling_bed() {
  Scene s = sheared_bed();
  s.contact.rolling = Kind;
  s.contact.twisting = true;
  s.pairs[0].rolling_friction = s.pairs[0].twisting_friction = 0.1;
  s.pairs[0].rolling_damping = s.pairs[0].twisting_damping = 0.3;
  return s;
}

/// Every way of running one instruction set gives the same bits, and others than the exact mode.
void expect_one_trajectory(Scene (*build)(), Isa isa, std::int64_t steps) {
  const Variant ways[] = {{ListPolicy::always, 200, 1, 0, isa},
                          {ListPolicy::local, 50, 2, 64, isa},
                          {ListPolicy::paper, 500, 3, 200, isa},
                          {ListPolicy::uniform, 0, 2, 128, isa}};
  std::uint64_t hash = 0;
  for (const Variant& v : ways) {
    const std::uint64_t h = hash_after(fast(v.apply(build())), v.options(), steps);
    if (hash == 0) hash = h;
    EXPECT_EQ(h, hash) << v.text();
  }
  // and the mode is another one: the comparison above is not that of the exact kernels
  if (k_fuses) {
    EXPECT_NE(hash, hash_after(ways[0].apply(build()), ways[0].options(), steps));
  }
}

TEST(Fast, SameBitsForEveryWayOfRunningOneInstructionSet) {
  const std::vector<Isa> isas = fast_isas();
  if (isas.empty()) GTEST_SKIP() << "no instruction set with fused multiply-add here";
  for (Scene (*build)() : {sheared_bed, hertz_drum})
    for (const Isa isa : isas) expect_one_trajectory(build, isa, 900);
}

TEST(Fast, SameBitsWithResistanceToRollingAndTwisting) {
  const std::vector<Isa> isas = fast_isas();
  if (isas.empty()) GTEST_SKIP() << "no instruction set with fused multiply-add here";
  for (Scene (*build)() : {rolling_bed<Rolling::cdt>, rolling_bed<Rolling::epsd>})
    for (const Isa isa : isas) expect_one_trajectory(build, isa, 450);
}

TEST(Fast, StaysWithinRoundingOfTheExactModeWhileRoundingIsSmall) {
  const std::vector<Isa> isas = fast_isas();
  if (isas.empty()) GTEST_SKIP() << "no instruction set with fused multiply-add here";
  for (Scene (*build)() : {sheared_bed, hertz_drum})
    for (const Isa isa : isas) {
      RunOptions o;
      o.threads = 1;
      o.isa = isa;
      Simulation a(build(), o), b(fast(build()), o);
      a.run(200);
      b.run(200);
      FrameRequest all;
      const Frame fa = a.frame(all), fb = b.frame(all);
      ASSERT_EQ(fa.id, fb.id);
      double worst = 0;
      for (std::size_t k = 0; k < fa.x.size(); ++k) worst = std::max(worst, norm(fa.x[k] - fb.x[k]));
      std::printf("figure: fast %s, 200 steps: positions within %.1e m of the exact mode's\n", isa_name(isa), worst);
      if (k_fuses) {
        EXPECT_GT(worst, 0.0);
      }
      // grains of 1e-3 m at coordinates up to 0.03 m (ulp 3e-18 m); collisions multiply differences by a few each
      EXPECT_LT(worst, 1e-12);
    }
}

TEST(Fast, IsRefusedWhereThereAreNoKernels) {
  RunOptions o;
  o.isa = Isa::scalar;
  EXPECT_THROW(Simulation(fast(gas()), o), Error);
}

}  // namespace
}  // namespace talus::determinism
