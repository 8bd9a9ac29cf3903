// Grain files: what is refused and in which words, and that every key's example is what the key allows.
#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "core/base/error.hpp"
#include "core/conversion/grain_advice.hpp"
#include "core/conversion/grain_keys.hpp"
#include "core/conversion/grain_run.hpp"
#include "tests/conversion/grain_support.hpp"

namespace talus::conversion {
namespace {

const std::string k_small = R"(scheme = "chan"
[time]
step = 0.1
duration = 1
[grain]
diameter = 0.01
temperature = 300
[material]
density = 600
[heat_capacity]
fuel = 1500
[conductivity]
fuel = 0.2
[surroundings]
temperature = 900
film = 20
)";

std::string fault(const std::string& text) {
  try {
    parse_grain(text, "g.toml");
  } catch (const Error& e) {
    EXPECT_EQ(e.exit_code(), 3) << e.what();
    return e.what();
  }
  return "accepted";
}

std::string with(const std::string& from, const std::string& to) {
  std::string s = k_small;
  const std::size_t k = s.find(from);
  EXPECT_NE(k, std::string::npos) << from;
  return s.replace(k, from.size(), to);
}

void expect_fault(const std::string& text, const std::vector<std::string>& words) {
  const std::string message = fault(text);
  for (const std::string& w : words) EXPECT_NE(message.find(w), std::string::npos) << w << " in: " << message;
  EXPECT_EQ(message.find('\n'), std::string::npos);
}

TEST(GrainFile, SmallestOneRuns) {
  const GrainJob job = parse_grain(k_small, "g.toml");
  EXPECT_EQ(job.steps, 10);
  const std::string table = grain_table(job);
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 12);
  EXPECT_NE(table.find("released_tar"), std::string::npos);
}

/// The column of a table.
std::vector<double> column(const std::string& table, const std::string& name) {
  std::istringstream lines(table);
  std::string line, cell;
  std::getline(lines, line);
  const auto at = std::count(line.begin(), line.begin() + static_cast<long>(line.find(name)), ',');
  std::vector<double> values;
  while (std::getline(lines, line)) {
    std::istringstream cells(line);
    for (long k = 0; k <= at; ++k) std::getline(cells, cell, ',');
    values.push_back(std::stod(cell));
  }
  return values;
}

TEST(GrainFile, NoStepOvershootsWhatIsAroundTheGrain) {
  for (const std::string around : {"film = 0\nwall_temperature = 2300", "film = 0.06", "film = 6e4", "film = 600"})
    for (const double step : {0.05, 5.0, 500.0}) {
      std::string text = with("temperature = 900\nfilm = 20", "temperature = 2300\n" + around);
      text.replace(text.find("scheme = \"chan\"\n"), 16, "");
      text.replace(text.find("step = 0.1\nduration = 1\n"), 24,
                   fmt::format("step = {}\nduration = {}\n", step, 40 * step));
      text.replace(text.find("density = 600"), 13, "density = 600\nemissivity = 1");
      const bool radiates = around.find("wall") != std::string::npos;
      if (radiates && step > 100) {
        EXPECT_THROW(grain_table(parse_grain(text, "g.toml")), Error) << "bounded, or refused";
        continue;
      }
      const std::string table = grain_table(parse_grain(text, "g.toml"));
      for (const char* name : {"centre_temperature", "mean_temperature", "surface_temperature"})
        for (const double T : column(table, name)) {
          // the centre is that of a parabola through two shells
          EXPECT_GT(T, name[0] == 'c' ? 250 : 300 - 1e-5) << around << " " << step << " " << name;
          EXPECT_LT(T, 2300 + 1e-5) << around << " " << step << " " << name;
        }
      for (const double q : column(table, "heat_residual")) EXPECT_LT(std::fabs(q), 1e-9);
    }
}

TEST(GrainFile, FaultsNameLineKeyValueAndWhatIsAllowed) {
  expect_fault(with("density = 600", "densty = 600"), {"g.toml:9:", "densty", "did you mean 'density'"});
  expect_fault(with("density = 600", "density = -1"), {"g.toml:9:", "density", "-1", "(0, 100000]"});
  expect_fault(with("density = 600", "density = nan"), {"density"});
  expect_fault(with("density = 600\n", ""), {"material.density", "missing"});
  expect_fault(with("temperature = 300", "temperature = 27000"), {"grain.temperature", "[K]"});
  expect_fault(with("\"chan\"", "\"cham\""), {"g.toml:1:", "cham", "did you mean 'chan'"});
  expect_fault(with("[conductivity]\nfuel = 0.2\n", ""), {"conductivity.fuel", "missing"});
  expect_fault(with("fuel = 1500", "fuel = { polynomial = [1, -1] }"), {"heat_capacity.fuel", "stays above 0"});
  expect_fault(with("fuel = 1500", "fuel = { table = [[300, 1], [200, 2]] }"), {"heat_capacity.fuel"});
  expect_fault(with("film = 20", "film = 20\nvelocity = 1"), {"contradicts 'film'"});
  expect_fault(with("temperature = 900", "temperature = [[0, 300], [0, 400]]"), {"surroundings.temperature"});
  expect_fault(with("diameter = 0.01", "diameter = 0.01\nlength = 1"), {"no effect"});
  expect_fault(with("density = 600", "density = 600\nmoisture = 0.6\nash = 0.4"), {"leave nothing"});
  expect_fault(k_small + "[drying]\nlaw = \"boiling\"\n", {"no effect without material.moisture"});
  expect_fault(k_small + "[[reaction]]\nreactant = \"wod\"\nproducts = { gas = 1 }\nA = 1\nE = 1\n",
               {"did you mean 'wood'"});
  expect_fault(k_small + "[[reaction]]\nreactant = \"wood\"\nproducts = { gas = 0.9 }\nA = 1\nE = 1\n",
               {"yields must sum to 1"});
  expect_fault(k_small + "[[reaction]]\nreactant = \"char\"\nproducts = { wood = 1 }\nA = 1\nE = 1\n", {"back to it"});
  expect_fault(k_small + "[melting]\nsolidus = 500\nlatent_heat = 1e5\n", {"neither moisture nor reactions"});
  expect_fault(k_small + "[reaction]\nA = 1\n", {"[[reaction]]"});
  expect_fault(k_small + "[unknown]\n", {"unknown key"});
}

TEST(GrainFile, EveryKeyHasAnExampleOfItsType) {
  for (const GrainKey& k : grain_keys()) {
    EXPECT_FALSE(k.example.empty()) << k.section << "." << k.name;
    EXPECT_NE(grain_help(k.name).find(std::string(k.name)), std::string::npos);
    // An example that its key refuses would be named in the message of that key.
    std::string text = k.section.empty() ? "" : "[" + std::string(k.section) + "]\n";
    for (const GrainSection& s : grain_sections())
      if (s.name == k.section && s.repeated) text = "[[" + std::string(k.section) + "]]\n";
    text += std::string(k.name) + " = " + std::string(k.example) + "\n";
    EXPECT_EQ(fault(text).find("must be " + allowed_text(k)), std::string::npos) << text << fault(text);
  }
}

TEST(Advice, NamesBiotLevelAndStep) {
  const GrainJob job = parse_grain(k_small, "g.toml");
  const GrainAdvice a = advise(job);
  EXPECT_NEAR(a.biot, 20 * 0.005 / (3 * 0.2), 1e-12);
  EXPECT_NEAR(a.diffusion, 0.005 * 0.005 * 600 * 1500 / 0.2, 1e-9);
  EXPECT_NE(advice_text(job).find("gradients matter"), std::string::npos);
}

}  // namespace
}  // namespace talus::conversion
