// Heat, conversion and gas of the same grains: bits depend on the trajectory alone, a resume goes on to the bit, books
// close while grains come, shrink and go; what cannot be had together is refused.
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.hpp"
#include "core/scene/scene_file.hpp"
#include "scheduler/step/access.hpp"
#include "tests/determinism/charring_wood.hpp"
#include "tests/determinism/part_final.hpp"
#include "tests/determinism/scenes.hpp"
#include "tests/determinism/variants.hpp"

namespace talus::determinism {
namespace {

constexpr std::int64_t k_run = 1500;  // with sort epochs

const std::string k_wood = k_charring_wood + R"([[char_reaction]]
oxidant = "H2O"
A = 34.2
n = 1
E = 129700
[surroundings]
gas = "air"
temperature = 300
)";

/// A hopper whose grains come and go, in hot gas.
Scene furnace(Scene s = hopper()) {
  s = heated(s);
  s.dt = 2e-5;
  s.output.energies = false;
  s.max_overlap = 1;
  s.heat.gas = {};
  for (SourceHeat& h : s.heat.sources) h.held = false;
  for (Material& m : s.materials) m.density = 700;
  s.conversion.on = true;
  s.conversion.every = s.heat.every;
  s.conversion.shells = 8;
  s.conversion.grain.assign(s.materials.size(), temporary_file("furnace-wood.toml", k_wood));
  s.gas.on = true;
  s.gas.lower = s.domain.lower;
  s.gas.upper = s.domain.upper;
  s.gas.cells = {3, 3, 6};
  s.gas.every = s.heat.every;
  s.gas.temperature = 1200;
  s.gas.combustion = true;
  GasInlet in, out;
  in.velocity = 0.8;
  in.temperature = 1100;
  out.side = GasSide::top;
  out.kind = GasInlet::Kind::pressure;
  s.gas.inlets = {in, out};
  return s;
}

TEST(FurnaceBits, DependOnTheTrajectoryAlone) {
  const Scene s = furnace();
  const Variant plain{ListPolicy::local, 200, 1, 0, Isa::automatic};
  Simulation first(plain.apply(s), plain.options());
  const double mass = value_of(first, "conversion.mass");
  first.run(k_run);
  const Final wanted = final_of(first);
  EXPECT_GT(value_of(first, "conversion.oxygen_taken"), 1e-7 * mass);
  EXPECT_GT(value_of(first, "conversion.steam_taken"), 0);
  EXPECT_GT(value_of(first, "conversion.released_CO"), 1e-4 * mass);
  EXPECT_GT(value_of(first, "conversion.released_H2O"), 0);
  EXPECT_NE(value_of(first, "heat.in_by_friction"), 0);
  expect_same_in_other_ways(s, k_run, wanted);
}

TEST(FurnaceBits, ResumeGoesOnToTheBitWhileGrainsComeAndGo) {
  const Scene s = furnace();
  expect_same_after_resume(s, k_run, {20, 733});  // before the first step of the parts, and between two
}

TEST(FurnaceBits, BooksCloseWhileGrainsComeShrinkAndGo) {
  Simulation sim(furnace(), RunOptions{});
  sim.run(k_run);
  const double mass = value_of(sim, "conversion.mass"), gas = mass + value_of(sim, "gas.mass_in");
  EXPECT_LT(std::fabs(value_of(sim, "conversion.mass_residual")), 1e-10 * mass);
  EXPECT_LT(std::fabs(value_of(sim, "conversion.heat_residual")), 1e-10 * value_of(sim, "conversion.heat"));
  EXPECT_LT(std::fabs(value_of(sim, "gas.mass_residual")), 1e-10 * gas);
  EXPECT_LT(value_of(sim, "gas.element_residual"), 1e-10 * gas);
  EXPECT_LT(std::fabs(value_of(sim, "gas.enthalpy_residual")), 1e-10 * gas * 1e6);
  EXPECT_NEAR(value_of(sim, "heat.into_shells"), value_of(sim, "conversion.heat_in"),
              1e-10 * std::fabs(value_of(sim, "conversion.heat_in")));
}

/// The same in warm and moist gas, its grains cold, so that steam condenses on them.
Scene dewy() {
  Scene s = furnace();
  const std::string law = "[drying]\nlaw = \"equilibrium\"\n";
  s.conversion.grain.assign(s.materials.size(), temporary_file("dew-wood.toml", k_wood + law));
  s.gas.temperature = 365;
  s.gas.fractions = {0.1, 0, 0, 0.3, 0, 0, 0, 0.6};
  s.gas.inlets[0].temperature = 365;
  s.gas.inlets[0].fractions = s.gas.fractions;
  for (SourceHeat& h : s.heat.sources) h.temperature = 300;
  return s;
}

TEST(CondensationBits, DependOnTheTrajectoryAlone) {
  const Scene s = dewy();
  const Variant plain{ListPolicy::local, 200, 1, 0, Isa::automatic};
  Simulation first(plain.apply(s), plain.options());
  first.run(k_run);
  EXPECT_GT(value_of(first, "conversion.steam_taken"), 1e-6 * value_of(first, "conversion.mass"));
  EXPECT_LT(std::fabs(value_of(first, "conversion.water_residual")), 1e-12 * value_of(first, "conversion.mass"));
  expect_same_in_other_ways(s, k_run, final_of(first));
}

TEST(CondensationBits, ResumeGoesOnToTheBit) { expect_same_after_resume(dewy(), k_run, {733}); }

TEST(FurnaceBits, NodesRunInTheOrderThatTheExchangeNeeds) {
  const Simulation sim(furnace(), RunOptions{});
  std::vector<std::string> order;
  for (const auto& n : sim.plan().nodes)
    if (n.name == "gas_step" || n.name == "heat_step" || n.name == "conversion_step") order.push_back(n.name);
  EXPECT_EQ(order, (std::vector<std::string>{"gas_step", "heat_step", "conversion_step"}));
  EXPECT_EQ(sim.plan().graph.find("conversion[c]"), std::string::npos) << "not before heat has come";
}

// --- what is refused -------------------------------------------------------------------------------------------------

std::string text_of(const std::string& heat, const std::string& conversion, const std::string& gas,
                    const std::string& more = "") {
  return "domain = { lower = [0, 0, 0], upper = [0.1, 0.1, 0.1] }\ntime = { step = 1e-5, steps = 10 }\n"
         "[contact]\nmodel = \"linear\"\nnormal_stiffness = 1000\nrestitution = 0.5\n" +
         heat + conversion + gas +
         "[[source]]\nkind = \"random\"\nnumber = 3\nregion = { lower = [0.02, 0.02, 0.02], upper = [0.08, 0.08, 0.08] "
         "}\n"
         "size = { diameter = 0.01 }\n[[material]]\nname = \"wood\"\ndensity = 700\n" +
         more;
}

std::string refusal(const std::string& text) {
  try {
    const Simulation sim(parse_scene(text, "furnace", "/"), RunOptions{});
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(Furnace, RefusesWhatCannotBeHadTogether) {
  const std::string heat = "[heat]\ntemperature = 300\n", gas = "[gas]\ncells = [2, 2, 2]\n",
                    conversion = "[conversion]\n";
  const std::string grain = "grain = \"" + temporary_file("refused-wood.toml", k_wood) + "\"\n";
  const auto has = [](const std::string& text, const char* word) { return text.find(word) != std::string::npos; };
  EXPECT_EQ(refusal(text_of(heat, conversion, gas, grain)), "");
  EXPECT_TRUE(has(refusal(text_of("", conversion, gas, grain)), "needs [heat]"));
  EXPECT_TRUE(has(refusal(text_of(heat + "every = 50\n", conversion, "", grain)), "heat.every"));
  EXPECT_TRUE(has(refusal(text_of(heat + "capacity = 1\nconductivity = 1\n", "", gas + "every = 50\n")), "heat.every"));
  EXPECT_TRUE(has(refusal(text_of(heat + "[heat.gas]\ntemperature = 500\n", conversion, gas, grain)), "[gas]"));
  EXPECT_TRUE(has(refusal(text_of(heat, conversion, gas + "upper = [0.1, 0.1, 0.05]\n", grain)), "fill the domain"));
  EXPECT_TRUE(has(refusal(text_of(heat, conversion, "", grain)), "[heat.gas]")) << "char without gas";
  EXPECT_TRUE(has(refusal(text_of(heat, conversion, gas, grain + "heat = { capacity = 3 }\n")), "no effect"));
  EXPECT_TRUE(has(refusal(text_of("", "", gas + "nusselt = \"gunn\"\n")), "no effect"));
  std::string bad = k_wood;
  bad += "wall_temperature = 900\n";
  EXPECT_TRUE(has(refusal(text_of(heat, conversion, gas, "grain = \"" + temporary_file("bad.toml", bad) + "\"\n")),
                  "wall_temperature"));
  bad = k_wood;
  bad.replace(bad.find("char = 0.2, volatiles = 0.8"), 27, "char = 0.7, volatiles = 0.3");
  EXPECT_TRUE(has(refusal(text_of(heat, conversion, gas, "grain = \"" + temporary_file("carbon.toml", bad) + "\"\n")),
                  "mixture"))
      << "0.7 kg of carbon of 0.5";
}

}  // namespace
}  // namespace talus::determinism
