// cases/grates/steady.py on series that are known: what holds is accepted, what drifts, leaks or cannot be told is not.
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <map>

#include "tests/cli/cli_runner.hpp"

namespace talus::test {
namespace {
namespace fs = std::filesystem;

class Steady : public Cli {
 protected:
  using Row = std::map<std::string, double>;

  /// A furnace of 250 grains and 5 fed per second for 300 s: what is stored stays, what passes grows evenly.
  static Row at(double t) {
    Row r{{"time", t},
          {"particles", 250 + 0.5 * std::sin(t)},
          {"inserted", 5 * t},
          {"removed", 5 * t},
          {"removed_mass", 1e-6 * t},
          {"gas.mass_in", 1e-3 * t},
          {"gas.mass_out", 1.022e-3 * t},
          {"gas.mass_from_grains", 22e-6 * t},
          {"gas.enthalpy_from_grains", -400 * t},
          {"gas.heat_from_grains", -100 * t},
          {"gas.enthalpy_out", -500 * t},
          {"heat.in_by_gas", 100 * t},
          {"heat.into_shells", 80 * t},
          {"conversion.heat_in", 80 * t},
          {"conversion.released_CO2", 44.0098e-6 * t},
          {"conversion.released_H2O", 10e-6 * t},
          {"conversion.oxygen_taken", 31.9988e-6 * t},
          {"conversion.gone_carbon", 12.011e-6 * t},
          {"conversion.gone_water", 10e-6 * t},
          {"gas.out_CO2", 44.0098e-6 * t},
          {"gas.out_H2O", 10e-6 * t}};
    r["gas.mass_from_grains"] = (44.0098e-6 + 10e-6 - 31.9988e-6) * t;
    r["gas.mass_out"] = r["gas.mass_in"] + r["gas.mass_from_grains"];
    for (const char* s : {"mass", "moisture", "fuel", "char", "ash"}) r[std::string("conversion.") + s] = 1e-4;
    r["conversion.heat"] = r["heat.mean"] = 500;
    for (const char* s : {"O2", "CO", "H2", "CH4", "tar", "N2"})
      r[std::string("conversion.released_") + s] = r[std::string("gas.out_") + s] = 0;
    for (const char* s : {"carbon", "hydrogen", "oxygen", "ash", "water", "mass", "heat"})
      r[std::string("conversion.") + s + "_residual"] = 1e-18;
    for (const char* s : {"conversion.gone_hydrogen", "conversion.carbon_dioxide_taken", "conversion.steam_taken",
                          "gas.element_residual", "gas.mass_residual", "gas.enthalpy_residual", "gas.enthalpy_in",
                          "heat.in_by_walls", "heat.in_by_radiation"})
      r[s] = 0;
    return r;
  }

  /// Exit code of the script; what it says is in "log".
  int judge(const std::function<void(double, Row&)>& change) {
    fs::create_directories(folder / "run");
    std::ofstream out(folder / "run" / "series.csv");
    out.precision(17);
    for (const bool names : {true, false})
      for (double t = 0; t <= (names ? 0 : 300); t += 0.5) {
        Row r = at(t);
        change(t, r);
        const char* between = "";
        for (const auto& [name, value] : r) {
          out << between;
          if (names)
            out << name;
          else
            out << value;
          between = ",";
        }
        out << "\n";
      }
    out.close();
    const std::string command =
        "cd '" + folder.string() + "' && /usr/bin/python3 " TALUS_SOURCE_DIR "/cases/grates/steady.py run > log 2>&1";
    const int status = std::system(command.c_str());
    return status == 0 ? 0 : WEXITSTATUS(status);
  }
  bool says(const std::string& line) { return read("log").find(line) != std::string::npos; }
};

TEST_F(Steady, HoldsWhereNothingDrifts) {
  EXPECT_EQ(judge([](double, Row&) {}), 0) << read("log");
  EXPECT_TRUE(says("Residence time 50.0 s; blocks from 150.0 to 300.0 s.")) << read("log");
  EXPECT_TRUE(says("Steady, and the books close."));
  EXPECT_FALSE(says("NO"));
}

TEST_F(Steady, SeesCharThatGathers) {
  EXPECT_EQ(judge([](double t, Row& r) { r["conversion.char"] = 1e-4 * (1 + t / 2000); }), 1);
  EXPECT_TRUE(says("| char [mg] |")) << read("log");
  EXPECT_TRUE(says("NO"));
}

TEST_F(Steady, SeesThatFewerLeaveThanCome) {
  EXPECT_EQ(judge([](double t, Row& r) { r["removed"] = 4.5 * t; }), 1);
  EXPECT_TRUE(says("| grains | -10.00 % | 3.0 % | NO |")) << read("log");
}

TEST_F(Steady, SeesBooksThatDoNotClose) {
  EXPECT_EQ(judge([](double, Row& r) { r["conversion.carbon_residual"] = 1e-11; }), 1);
  EXPECT_TRUE(says("| carbon of the grains | ")) << read("log");
  EXPECT_EQ(judge([](double t, Row& r) { r["conversion.released_CO2"] = 44.0e-6 * t; }), 1);
  EXPECT_TRUE(says("carbon from grains to gas, both books | -2.2e-04 | NO")) << read("log");
}

TEST_F(Steady, TellsNothingFromWhatVariesWidely) {
  EXPECT_EQ(judge([](double t, Row& r) { r["conversion.moisture"] = 1e-4 * (1 + std::sin(t / 17)); }), 1);
  EXPECT_TRUE(says("NOT steady")) << read("log");
}

}  // namespace
}  // namespace talus::test
