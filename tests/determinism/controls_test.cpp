// Seeded controls of figure 2: breaking the canonical order of contacts (I3, I8) must change the hash; otherwise the
// equality tests would prove nothing.
#include <gtest/gtest.h>

#include "tests/determinism/scenes.hpp"
#include "tests/determinism/variants.hpp"
#include "tests/faults.hpp"

namespace talus::determinism {
namespace {

using faults::Fault;
using faults::SeededFault;

std::uint64_t hash_with_fault(const Scene& scene, Fault fault, int chunk) {
  RunOptions options;
  options.threads = 1;
  options.chunk = chunk;
  const SeededFault seeded(fault);
  Simulation sim(scene, options);
  sim.run(k_steps);
  return sim.state_hash();
}

class Control : public testing::TestWithParam<NamedScene> {};

TEST_P(Control, BorderPairsAfterTheInteriorGiveAnotherHashPerChunkSize) {
  const Scene scene = GetParam().build();
  const std::uint64_t right = hash_with_fault(scene, Fault::none, 64);
  EXPECT_EQ(hash_with_fault(scene, Fault::none, 257), right);
  const std::uint64_t a = hash_with_fault(scene, Fault::border_order, 64),
                      b = hash_with_fault(scene, Fault::border_order, 257);
  EXPECT_NE(a, right);
  EXPECT_NE(b, right);
  EXPECT_NE(a, b);
  // One chunk has no borders: there the fault is none.
  EXPECT_EQ(hash_with_fault(scene, Fault::border_order, 4096), right);
}

TEST_P(Control, ContactsInOrderOfArrivalGiveAnotherHash) {
  const Scene scene = GetParam().build();
  const std::uint64_t right = hash_with_fault(scene, Fault::none, 64);
  const std::uint64_t a = hash_with_fault(scene, Fault::contact_order, 64),
                      b = hash_with_fault(scene, Fault::contact_order, 4096);
  EXPECT_NE(a, right);
  EXPECT_NE(b, right);
  EXPECT_NE(a, b);
}

INSTANTIATE_TEST_SUITE_P(Scenes, Control, testing::ValuesIn(scenes()),
                         [](const testing::TestParamInfo<NamedScene>& i) { return std::string(i.param.name); });

// The faults reorder sums and nothing else: after one contact-rich step the state agrees to rounding.
TEST(ControlFault, ChangesNothingButTheOrderOfSums) {
  const Scene scene = sheared_bed();
  for (const Fault fault : {Fault::border_order, Fault::contact_order}) {
    RunOptions options;
    options.threads = 1;
    options.chunk = 64;
    Simulation right(scene, options);
    const SeededFault seeded(fault);
    Simulation wrong(scene, options);
    right.run(200);
    wrong.run(200);
    const Frame a = right.frame(), b = wrong.frame();
    ASSERT_EQ(a.id, b.id);
    EXPECT_EQ(right.counters().contacts, wrong.counters().contacts);
    double worst = 0;
    for (std::size_t k = 0; k < a.x.size(); ++k) worst = fmax2(worst, norm(a.x[k] - b.x[k]));
    // rounding of sums, 1e-16 of a force, grows by collisions: 1e-9 of a diameter is still far from a lost history
    EXPECT_LT(worst, 2e-12);
    EXPECT_GT(worst, 0);
  }
}

}  // namespace
}  // namespace talus::determinism
