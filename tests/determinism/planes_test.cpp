// Flux planes: counted in every step, whatever the way of running, the outputs, a stop or a failure; the witness are
// the positions of every step.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "core/base/error.hpp"
#include "tests/determinism/scenes.hpp"
#include "tests/determinism/variants.hpp"
#include "tests/faults.hpp"

namespace talus::determinism {
namespace {

/// Open bottom, a stream and a moving gate: planes in the opening, in the bottom side itself, and oblique.
Scene draining() {
  Scene s = hopper();
  s.output.flux_planes = {{"opening", {0, 0, 0.0035}, {0, 0, -1}},
                          {"bottom", {0, 0, 0}, {0, 0, -1}},
                          {"slant", {0, 0, 0.02}, {0.6, 0, -0.8}}};
  return s;
}

/// Periodic in all directions: planes in the middle, in both ends of an axis, and along another axis.
Scene rounds() {
  Scene s = gas();
  for (Source& q : s.sources) q.velocity = {3, -2, 1};
  s.output.flux_planes = {{"middle", {0.01, 0, 0}, {1, 0, 0}},
                          {"lower end", {0, 0, 0}, {1, 0, 0}},
                          {"upper end", {0.02, 0, 0}, {-1, 0, 0}},
                          {"y", {0, 0.003, 0}, {0, 1, 0}}};
  return s;
}

/// Driven grains on top of a bed, periodic in x and y.
Scene sheared() {
  Scene s = sheared_bed();
  s.output.flux_planes = {{"x", {0.51, 0, 0}, {1, 0, 0}}, {"z", {0, 0, 0.01}, {0, 0, 1}}};
  return s;
}

const std::vector<NamedScene> k_scenes = {{"draining", draining}, {"rounds", rounds}, {"sheared", sheared}};

class Planes : public testing::TestWithParam<NamedScene> {};

INSTANTIATE_TEST_SUITE_P(Scenes, Planes, testing::ValuesIn(k_scenes),
                         [](const testing::TestParamInfo<NamedScene>& i) { return std::string(i.param.name); });

struct Tally {
  std::int64_t forward = 0, backward = 0;
  double mass = 0;
};

/// Passages of one grain: images of the plane between its unwrapped positions.
int passages(const Scene& s, const OutputSettings::Plane& p, Vec3 from, Vec3 to) {
  int axis = -1, across = 0;
  for (int k = 0; k < 3; ++k)
    if (p.normal[k] != 0) {
      axis = k;
      ++across;
    }
  if (across > 1) {  // oblique planes in these scenes have no periodic axis
    const auto side = [&](Vec3 x) { return dot(p.normal, x - p.point) >= 0 ? 1 : 0; };
    return side(to) - side(from);
  }
  const double period = s.domain.upper[axis] - s.domain.lower[axis];
  const double start = from[axis] - p.point[axis];
  double way = to[axis] - from[axis];
  if (s.domain.periodic(axis)) {
    if (way > 0.5 * period) way -= period;
    if (way < -0.5 * period) way += period;
  }
  const auto image = [&](double x) { return s.domain.periodic(axis) ? std::floor(x / period) : (x >= 0 ? 1.0 : 0.0); };
  return static_cast<int>(p.normal[axis] * (image(start + way) - image(start)));
}

TEST_P(Planes, CountEveryPassageThatThePositionsOfAllStepsShow) {
  const Scene s = GetParam().build();
  Simulation sim(s, Variant{ListPolicy::local, 200, 2, 64, Isa::automatic}.options());
  std::vector<Tally> tally(s.output.flux_planes.size());
  Frame before = sim.frame();
  for (int n = 0; n < 1100; ++n) {
    sim.run(1);
    const Frame now = sim.frame();
    std::map<ParticleId, std::size_t> place;
    for (std::size_t k = 0; k < now.id.size(); ++k) place[now.id[k]] = k;
    for (std::size_t k = 0; k < before.id.size(); ++k) {
      const auto found = place.find(before.id[k]);
      // who is gone has left through the open bottom, straight on
      const Vec3 to = found != place.end() ? now.x[found->second] : before.x[k] + Vec3{0, 0, -0.01};
      const double r = before.r[k], mass = 2500 * 4.0 / 3 * 3.14159265358979323846 * r * r * r;
      for (std::size_t q = 0; q < tally.size(); ++q) {
        const int net = passages(s, s.output.flux_planes[q], before.x[k], to);
        (net > 0 ? tally[q].forward : tally[q].backward) += std::abs(net);
        tally[q].mass += net * mass;
      }
    }
    before = now;
  }
  for (std::size_t q = 0; q < tally.size(); ++q) {
    const PlaneTotal& t = sim.planes()[q];
    EXPECT_EQ(t.forward, tally[q].forward) << s.output.flux_planes[q].name;
    EXPECT_EQ(t.backward, tally[q].backward) << s.output.flux_planes[q].name;
    EXPECT_NEAR(t.mass, tally[q].mass, 1e-9 * std::abs(tally[q].mass) + 1e-15) << s.output.flux_planes[q].name;
    EXPECT_GT(t.forward + t.backward, 10) << s.output.flux_planes[q].name << ": too few to tell anything";
  }
}

TEST(PlanesScene, ABottomPlaneCountsWhatIsRemovedAndTheEndsOfAnAxisAreOnePlane) {
  Simulation drain(draining(), RunOptions{}), round(rounds(), RunOptions{});
  drain.run(k_steps);
  EXPECT_GT(drain.counters().removed, 10);
  EXPECT_EQ(drain.planes()[1].forward, drain.counters().removed);
  EXPECT_EQ(drain.planes()[1].backward, 0);
  EXPECT_NEAR(drain.planes()[1].mass, drain.counters().removed_mass, 1e-12 * drain.counters().removed_mass);
  round.run(k_steps);
  EXPECT_GT(round.planes()[1].particles(), 100);
  EXPECT_EQ(round.planes()[1].forward, round.planes()[2].backward);
  EXPECT_EQ(round.planes()[1].backward, round.planes()[2].forward);
}

TEST_P(Planes, HaveTheSameBitsForEveryWayOfRunningAndLeaveTheTrajectoryAlone) {
  const Scene s = GetParam().build();
  Scene bare = s;
  bare.output.flux_planes.clear();
  constexpr std::int64_t steps = 900;
  Simulation without(bare, RunOptions{});
  without.run(steps);
  constexpr std::pair<int, int> ways[] = {{1, 0}, {2, 64}, {3, 257}, {1, 100}};
  std::uint64_t counts = 0;
  for (std::size_t k = 0; k < exact_policies().size(); ++k) {
    const auto [threads, chunk] = ways[k % std::size(ways)];
    const Variant v{exact_policies()[k], k % 2 == 0 ? 20.0 : 200.0, threads, chunk, Isa::automatic};
    Simulation sim(v.apply(s), v.options());
    sim.run(steps);
    EXPECT_EQ(sim.state_hash(), without.state_hash()) << v.text();
    if (counts == 0) counts = sim.planes_hash();
    EXPECT_EQ(sim.planes_hash(), counts) << v.text();
  }
}

TEST_P(Planes, GoOnAfterAResumeAsIfThereHadBeenNoStop) {
  const Scene s = GetParam().build();
  const Variant first{ListPolicy::local, 200, 1, 257, Isa::automatic}, second{ListPolicy::paper, 20, 2, 64, Isa::sse2};
  Simulation through(first.apply(s), first.options());
  through.run(1200);
  for (const std::int64_t stop : {1, 333, 700, 1199}) {
    const std::string path = temporary_file("planes.checkpoint");
    Simulation before(first.apply(s), first.options());
    before.run(stop);
    CheckpointWriter out;
    before.save(out);
    out.commit(path);
    Simulation after(second.apply(s), second.options(), CheckpointReader(path));
    EXPECT_EQ(after.planes_hash(), before.planes_hash());
    after.run(1200 - stop);
    EXPECT_EQ(after.planes_hash(), through.planes_hash()) << "stopped at " << stop;
    EXPECT_TRUE(checkpoint_bytes(after) == checkpoint_bytes(through)) << "stopped at " << stop;
  }
}

// A step that fails is taken back, and with it what it has counted: the checkpoint of a failure is that of the step
// before.
TEST_P(Planes, OfAFailedStepAreTakenBackWithTheLedger) {
  Scene s = GetParam().build();
  s.output.energies = true;
  RunOptions options;
  options.threads = 2;
  const auto sections = [](const Simulation& sim) {
    const std::string path = temporary_file("failed.checkpoint");
    CheckpointWriter out;
    sim.save(out);
    out.commit(path);
    return CheckpointReader(path);
  };
  Simulation good(s, options);
  const faults::SeededFault seeded(faults::Fault::force);  // in step 50
  Simulation bad(s, options);
  good.run(50);
  EXPECT_THROW(bad.run(200), Error);
  ASSERT_EQ(bad.step(), 50);
  EXPECT_EQ(bad.planes_hash(), good.planes_hash());
  const CheckpointReader a = sections(good), b = sections(bad);
  for (const char* name : {"meta", "planes"}) {
    const auto x = a.section(name), y = b.section(name);
    EXPECT_TRUE(std::equal(x.begin(), x.end(), y.begin(), y.end())) << name;
  }
}

}  // namespace
}  // namespace talus::determinism
