// What a scene does not need is not there. Judged by the plan that `explain` prints, by the
// memory that the arrays really take, and by the sections of a checkpoint.
#include <gtest/gtest.h>

#include <map>

#include "tests/determinism/scenes.hpp"

namespace talus::determinism {
namespace {

/// Frictionless, one material, one size, periodic: nothing optional.
Scene bare() {
  Scene s = gas();
  s.sources[0].number = 1000;
  s.contact.onset_correction = false;  // which recalls the velocity of every contact
  s.list.automatic = false;            // a chosen K follows measured times, and the memory of the lists with it
  return s;
}

/// Everything optional at once.
Scene loaded() {
  Scene s = hertz_drum();
  s.output.energies = true;
  s.output.flux_planes = {{"middle", {0, 0, 0}, {0, 0, 1}}};
  s.groups = {GroupSpec{"few", false, std::nullopt, std::array<ParticleId, 2>{0, 5}}};
  Event e;
  e.group = 0;
  e.time = 100 * s.dt;
  s.events = {e};
  Source stream = s.sources[1];
  stream.kind = Source::Kind::stream;
  stream.number = 5;
  stream.number_rate = 1e4;
  stream.interval = 20 * s.dt;
  s.sources.push_back(stream);
  return s;
}

RunOptions one_thread() {
  RunOptions o;
  o.threads = 1;
  return o;
}

std::map<std::string, Plan::Node> nodes_of(const Plan& p) {
  std::map<std::string, Plan::Node> m;
  for (const auto& n : p.nodes) m[n.name] = n;
  return m;
}

std::map<std::string, Plan::Array> arrays_of(const Plan& p) {
  std::map<std::string, Plan::Array> m;
  for (const auto& a : p.arrays) m[a.name] = a;
  return m;
}

constexpr const char* k_optional_nodes[] = {"insert", "wall_contact", "plane_count", "energy"};
constexpr const char* k_optional_arrays[] = {"rotation lanes of v", "material", "fixed", "group", "energy", "history",
                                             "wall contacts"};

TEST(LeftOut, FrictionlessMonodisperseSceneHasNoOptionalNodeAndNoByteOfAnOptionalArray) {
  Simulation sim(bare(), one_thread());
  sim.run(200);
  ASSERT_GT(sim.counters().contacts, 0);
  const Plan plan = sim.plan();
  auto nodes = nodes_of(plan);
  auto arrays = arrays_of(plan);
  for (const char* name : k_optional_nodes) {
    ASSERT_TRUE(nodes.contains(name)) << name << ": explain must say why it is left out";
    EXPECT_FALSE(nodes[name].in) << name;
    EXPECT_FALSE(nodes[name].why.empty()) << name;
    EXPECT_EQ(plan.graph.find(name), std::string::npos) << name << " in\n" << plan.graph;
  }
  for (const char* name : k_optional_arrays) {
    ASSERT_TRUE(arrays.contains(name)) << name;
    EXPECT_FALSE(arrays[name].in) << name;
    EXPECT_EQ(arrays[name].bytes_per_particle, 0) << name;
    EXPECT_FALSE(arrays[name].why.empty()) << name;
  }
  EXPECT_EQ(arrays["v, v2"].bytes_per_particle, 64) << "{vx, vy, vz, 1/m} twice, no rotation";
}

TEST(LeftOut, SceneWithEverythingHasEveryNodeAndArray) {
  Simulation sim(loaded(), one_thread());
  sim.run(400);
  ASSERT_GT(sim.counters().contacts, 0);
  ASSERT_GT(sim.counters().wall_contacts, 0);
  const Plan plan = sim.plan();
  auto nodes = nodes_of(plan);
  auto arrays = arrays_of(plan);
  for (const char* name : k_optional_nodes) EXPECT_TRUE(nodes[name].in) << name;
  for (const char* name : {"insert", "wall_contact", "plane_count"})
    EXPECT_NE(plan.graph.find(name), std::string::npos) << plan.graph;
  for (const char* name : k_optional_arrays) {
    EXPECT_TRUE(arrays[name].in) << name;
    if (std::string(name) != "rotation lanes of v") {  // counted in v
      EXPECT_GT(arrays[name].bytes_per_particle, 0) << name;
    }
  }
  EXPECT_EQ(arrays["v, v2"].bytes_per_particle, 128);
}

// Nodes that run are those of the plan: the profile lists what was executed.
TEST(LeftOut, OnlyPlannedNodesRun) {
  for (const Scene& scene : {bare(), loaded()}) {
    Simulation sim(scene, one_thread());
    sim.run(200);
    auto nodes = nodes_of(sim.plan());
    std::map<std::string, std::int64_t> ran;
    for (const NodeTime& t : sim.profile().nodes) ran[t.node] = t.calls;
    for (const auto& [name, node] : nodes) EXPECT_EQ(ran[name] > 0, node.in) << scene.title << ": " << name;
    for (const auto& [name, calls] : ran) EXPECT_TRUE(nodes.contains(name)) << name;
  }
}

// The plan could be wrong about memory; the arrays cannot. Turning one feature on costs at least its bytes, and a
// checkpoint has a section exactly for what the scene has.
TEST(LeftOut, MemoryAndCheckpointConfirmThePlan) {
  const auto sections = [](const Simulation& sim) {
    const std::string path = temporary_file("sections.checkpoint");
    CheckpointWriter out;
    sim.save(out);
    out.commit(path);
    return CheckpointReader(path);
  };
  Simulation plain(bare(), one_thread());
  plain.run(200);
  const double n = static_cast<double>(plain.particles());
  const auto bare_sections = sections(plain);
  for (const char* name : {"material", "fixed", "group", "planes"}) EXPECT_FALSE(bare_sections.has(name)) << name;
  EXPECT_EQ(bare_sections.section("wall_contacts").size(), 0U);
  EXPECT_EQ(bare_sections.section("velocity").size(), static_cast<std::size_t>(32 * n));

  Simulation everything(loaded(), one_thread());
  everything.run(200);
  const auto all = sections(everything);
  for (const char* name : {"material", "fixed", "group", "planes"}) EXPECT_GT(all.section(name).size(), 0U) << name;
  EXPECT_GT(all.section("wall_contacts").size(), 0U);

  Scene energies = bare();
  energies.output.energies = true;
  Simulation with_energies(energies, one_thread());
  with_energies.run(200);
  EXPECT_GE(static_cast<double>(with_energies.bytes()) - static_cast<double>(plain.bytes()), 32 * n);

  Scene friction = bare();
  friction.contact.friction = true;
  friction.contact.tangential_stiffness = 200;
  friction.pairs[0].friction = 0.5;
  Simulation with_friction(friction, one_thread());
  with_friction.run(200);
  // 32 bytes more in each of v and v2, and three history columns
  EXPECT_GE(static_cast<double>(with_friction.bytes()) - static_cast<double>(plain.bytes()), 64 * n);
  // Asking for what is free of charge changes no bit: energies are an observer.
  EXPECT_EQ(with_energies.state_hash(), plain.state_hash());
}

}  // namespace
}  // namespace talus::determinism
