// Part "conversion": balances close while grains burn, shrink and leave; every way of running gives the same bits;
// sizes move in straight lines; what a grain does alone it does in the bed.
#include "scheduler/parts/conversion.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.hpp"
#include "kernels/conversion/grain_batch.hpp"
#include "scheduler/step/access.hpp"
#include "tests/determinism/scenes.hpp"
#include "tests/determinism/variants.hpp"
#include "tests/part_values.hpp"

namespace talus::determinism {
namespace {

constexpr const char* k_wood = R"(title = "wet wood that burns"
scheme = "di_blasi_branca"
[time]
step = 0.001
duration = 1
[grain]
diameter = 0.002
temperature = 300
[material]
density = 700
moisture = 0.2
ash = 0.02
[heat_capacity]
fuel = { polynomial = [1112, 4.85], origin = 273.15, range = [273, 900] }
char = 1300
ash = 900
gas = 1100
[conductivity]
fuel = 0.15
wet = 0.25
char = 0.1
ash = 0.2
[drying]
law = "boiling"
[shrinkage]
drying = 0.1
devolatilisation = 0.3
burn_off = 0.9
[[char_reaction]]
oxidant = "O2"
A = 1.715
n = 1
E = 74830
[surroundings]
gas = "air"
temperature = 1300
wall_temperature = 1400
velocity = 2
oxygen = 0.23
)";

Scene bed() {
  Scene s = hopper();
  s.materials[0].density = 700;
  s.output.energies = false;
  s.max_overlap = 1;
  s.sources.resize(1);  // the part comes to grains that are there
  return s;
}

ConversionSettings settings(std::int64_t every) {
  auto job = std::make_shared<conversion::GrainJob>(conversion::parse_grain(k_wood, "wood.toml"));
  ConversionSettings s;
  s.every = every;
  s.shells = 10;
  s.gone_below = 0.6;
  s.matter = {job};
  return s;
}

/// The same in so strong a film that grains dry, decompose and burn within the run.
ConversionSettings hot_settings(std::int64_t every) {
  ConversionSettings s = settings(every);
  auto hot = std::make_shared<conversion::GrainJob>(*s.matter[0]);
  hot->around.film = conversion::Series{{0}, {4e4}};
  s.matter = {hot};
  return s;
}

void convert(Simulation& sim, const ConversionSettings& s) {
  World& w = EngineAccess::world(sim);
  auto part = make_conversion(w.rules, s);
  part->add_columns(w.rows.columns);
  set_particle_capacity(w.rows, w.rows.n);
  NewParticles all;
  all.x.resize(static_cast<std::size_t>(w.rows.n));
  part->appended(w.rows, 0, all);
  w.rows.resized = part->resizes();
  w.parts.all.push_back(std::move(part));
}

/// Contact steps are short: time runs faster for the grains.
Scene quick(Scene s) {
  s.dt = 2e-5;
  return s;
}

TEST(Conversion, HeatMassAndElementsCloseWhileGrainsBurnShrinkAndLeave) {
  Simulation sim(quick(bed()), RunOptions{});
  convert(sim, hot_settings(50));
  const double mass = value_of(sim, "conversion.mass"), radius = sim.frame().r[0];
  sim.run(4000);
  EXPECT_LT(value_of(sim, "conversion.mass"), 0.8 * mass);
  EXPECT_LT(sim.frame().r[0], 0.99 * radius) << "it has shrunk";
  const double turned = std::fabs(value_of(sim, "conversion.heat_in")) + value_of(sim, "conversion.heat");
  EXPECT_LT(std::fabs(value_of(sim, "conversion.heat_residual")), 1e-10 * turned);
  EXPECT_LT(std::fabs(value_of(sim, "conversion.mass_residual")), 1e-9 * mass);
  for (const char* e : {"carbon", "hydrogen", "oxygen", "ash", "water"})
    EXPECT_LT(std::fabs(value_of(sim, std::string("conversion.") + e + "_residual")), 1e-12 * mass) << e;
}

// Shells become light while they still hold fuel: a step that heat just allowed at the start is too long later.
TEST(Conversion, StepThatBecomesTooLongAsGrainsDecomposeIsRefusedByName) {
  Simulation sim(quick(bed()), RunOptions{});
  World& w = EngineAccess::world(sim);
  const double most = make_conversion(w.rules, hot_settings(1))->step_limit(view_of(w));  // [s]
  const auto every = static_cast<std::int64_t>(0.9 * most / w.rules.scene.dt);
  convert(sim, hot_settings(every));
  sim.run(2 * every);
  try {
    for (int k = 0; k < 40; ++k) sim.run(every);
    FAIL() << "accepted";
  } catch (const Error& e) {
    const std::string what = e.what();
    EXPECT_EQ(e.code(), ErrorCode::physics);
    EXPECT_NE(what.find("conversion step"), std::string::npos) << what;
    EXPECT_NE(what.find("of grain "), std::string::npos) << what;
    EXPECT_NE(what.find("conversion.every = "), std::string::npos) << what;
    EXPECT_EQ(what.find("step "), 0U) << what;
  }
}

// Grains convert exactly beside contacts of either precision; the kernels of "fast" have another name.
TEST(Conversion, GoesOnBesideFastContacts) {
  double mass[2];
  for (const bool fast : {false, true}) {
    Scene s = quick(bed());
    s.precision = fast ? Precision::fast : Precision::exact;
    try {
      Simulation sim(s, RunOptions{});
      convert(sim, hot_settings(50));
      const double before = value_of(sim, "conversion.mass");
      sim.run(1000);
      mass[fast ? 1 : 0] = value_of(sim, "conversion.mass");
      EXPECT_LT(mass[fast ? 1 : 0], 0.99 * before);
    } catch (const Error& e) {
      ASSERT_EQ(e.code(), ErrorCode::usage) << e.what();
      GTEST_SKIP() << "no instruction set with fused multiply-add here";
    }
  }
  EXPECT_NEAR(mass[1] / mass[0], 1, 1e-6);  // their surroundings are the same wherever they roll
}

TEST(Conversion, BitsDependOnTheTrajectoryAlone) {
  const Scene s = quick(bed());
  const Variant plain{ListPolicy::local, 200, 1, 0, Isa::automatic};
  Simulation first(plain.apply(s), plain.options());
  convert(first, hot_settings(20));
  first.run(1500);
  const std::uint64_t wanted = first.state_hash();
  const Frame f = first.frame();
  for (const Variant& way :
       {Variant{ListPolicy::paper, 10, 2, 64, Isa::sse2}, Variant{ListPolicy::always, 0, 3, 257, Isa::scalar},
        Variant{ListPolicy::two_largest, 200, 2, 100, Isa::automatic},
        Variant{ListPolicy::outer_inner, 100, 8, 64, Isa::automatic}}) {
    Simulation sim(way.apply(s), way.options());
    convert(sim, hot_settings(20));
    sim.run(1500);
    EXPECT_EQ(sim.state_hash(), wanted) << way.text();
    EXPECT_EQ(sim.part_values().size(), first.part_values().size());
    for (std::size_t k = 0; k < first.part_values().size(); ++k)
      EXPECT_EQ(sim.part_values()[k].value, first.part_values()[k].value) << first.part_values()[k].name;
  }
}

TEST(Conversion, SizesMoveInStraightLinesWithoutAJump) {
  Simulation sim(quick(bed()), RunOptions{});
  convert(sim, hot_settings(25));
  const World& w = EngineAccess::world(sim);
  std::vector<double> radius;
  sim.run(2000);
  for (int n = 0; n < 400; ++n) {
    sim.run(1);
    for (Row i = 0; i < w.rows.n; ++i)
      if (w.rows.id[i] == 3) radius.push_back(w.rows.p[4L * i + 3]);
  }
  ASSERT_EQ(radius.size(), 400U);
  EXPECT_LT(radius.back(), radius.front());
  double largest = 0;
  for (std::size_t k = 1; k < radius.size(); ++k) largest = std::max(largest, std::fabs(radius[k] - radius[k - 1]));
  EXPECT_LT(largest, 3 * (radius.front() - radius.back()) / 400) << "no step takes more than its share";
  for (std::size_t k = 51; k + 1 < 74; ++k)
    EXPECT_NEAR(radius[k + 1] - radius[k], radius[k] - radius[k - 1], 1e-15 * radius[0]) << k;
}

TEST(Conversion, AGrainDoesInTheBedWhatItDoesAlone) {
  const Scene s = quick(bed());
  Simulation sim(s, RunOptions{});
  ConversionSettings set = settings(20);
  set.resizes = false;
  convert(sim, set);
  const double r = sim.frame().r[5];
  sim.run(600);
  const conversion::GrainJob& job = *set.matter[0];
  conversion::BedTables tables(job.matter, set.shells, job.around.gas, job.around.law);
  const conversion::BedMatter& m = tables.matter();
  std::vector<double> row(static_cast<std::size_t>(conversion::bed_row(m).size)), in(8 * conversion::k_bed_in),
      out(static_cast<std::size_t>(8 * (conversion::k_out_released + m.gases))),
      scratch(static_cast<std::size_t>(conversion::bed_scratch(m)));
  tables.begin(r, job.temperature, row.data());
  const auto give = [&](conversion::BedIn c, double x) { in[static_cast<std::size_t>(8 * c)] = x; };
  using namespace conversion;
  give(k_in_gas, 1300), give(k_in_wall, 1400), give(k_in_sees, 1), give(k_in_velocity, 2), give(k_in_oxygen, 0.23);
  give(k_in_film, -1), give(k_in_molar, job.around.molar_at(0));
  give(k_in_pressure, 101325);
  double* at = row.data();
  GrainBatch b;
  b.grains = 1, b.row = &at, b.in = in.data(), b.out = out.data(), b.stride = 8, b.dt = 20 * s.dt;
  b.scratch = scratch.data();
  for (int n = 0; n < 30; ++n) grain_solver("scalar")(m, b);
  const Frame f = sim.frame();
  for (const ExtraColumn& c : f.extra) {
    if (c.name == "mean_temperature") {
      EXPECT_EQ(c.values[5], out[8 * k_out_mean]);
      EXPECT_GT(c.values[5], 310);
    }
    if (c.name == "moisture") {
      EXPECT_EQ(c.values[5], out[8 * k_out_moisture]);
    }
  }
}

/// The whole hopper, whose grains come and go, as a scene asks for it.
Scene burning_hopper() {
  Scene s = quick(hopper());
  s.materials[0].density = 700;
  s.output.energies = false;
  s.max_overlap = 1;
  s.conversion.on = true;
  s.conversion.every = 20;
  s.conversion.shells = 10;
  std::string text = k_wood;
  text.replace(text.find("velocity = 2"), 12, "film = 4e4");
  s.conversion.grain = {temporary_file("wood.toml", text)};
  return s;
}

TEST(Conversion, ResumeGoesOnToTheBitWhileGrainsComeAndGo) {
  const Scene s = burning_hopper();
  RunOptions o;
  o.threads = 2;
  Simulation whole(s, o);
  whole.run(1200);
  EXPECT_GT(whole.counters().inserted, 0);
  const double mass = value_of(whole, "conversion.mass");
  EXPECT_LT(std::fabs(value_of(whole, "conversion.mass_residual")), 1e-9 * mass);
  const std::string path = temporary_file("conversion.checkpoint");
  {
    Simulation half(s, o);
    half.run(613);
    CheckpointWriter out;
    half.save(out);
    out.commit(path);
  }
  o.chunk = 64;
  Simulation rest(s, o, CheckpointReader(path));
  rest.run(1200 - 613);
  EXPECT_EQ(rest.state_hash(), whole.state_hash());
  EXPECT_EQ(checkpoint_bytes(rest), checkpoint_bytes(whole));
  for (std::size_t k = 0; k < whole.part_values().size(); ++k)
    EXPECT_EQ(rest.part_values()[k].value, whole.part_values()[k].value) << whole.part_values()[k].name;
}

TEST(Conversion, IsLeftOutWhereTheSceneDoesNotAsk) {
  const Simulation without(hopper(), RunOptions{}), with(burning_hopper(), RunOptions{});
  EXPECT_TRUE(without.frame().extra.empty());
  EXPECT_EQ(without.plan().graph.find("conversion"), std::string::npos);
  EXPECT_NE(with.plan().graph.find("integrate[c] -> resize[c] -> conversion[c]"), std::string::npos)
      << with.plan().graph;
  for (const auto& a : without.plan().arrays) EXPECT_EQ(a.name.find("conversion"), std::string::npos);
}

TEST(Conversion, RefusesAnotherDensityThanThatOfTheMaterial) {
  Simulation sim(hopper(), RunOptions{});
  EXPECT_THROW(make_conversion(EngineAccess::world(sim).rules, settings(50)), Error);
}

}  // namespace
}  // namespace talus::determinism
