// `talus compare` over two runs: frames are matched by time, the growth of the difference is measured, equal runs are
// equal in every frame.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "core/io/vtkhdf.hpp"
#include "tests/cli/cli_runner.hpp"

namespace talus::test {
namespace {

double number(const std::string& text) { return std::strtod(text.c_str(), nullptr); }

/// Two frictionless grains, one of which meets a wall of fixed speed: free flight, so that differences are known.
std::string flight(double vx) {
  return "[domain]\nlower = [0, 0, 0]\nupper = [1, 1, 1]\nboundary = \"periodic\"\n[time]\nstep = 1e-3\nsteps = 400\n"
         "[[material]]\nname = \"a\"\ndensity = 2500\n[contact]\nnormal_stiffness = 1e2\n[[source]]\nkind = \"file\"\n"
         "file = \"s" +
         std::to_string(vx) + ".csv\"\n[output]\nparticles_every = 0.05\n";
}

class Compare : public Cli {
 protected:
  void flight_run(const std::string& folder_name, double vx, const std::vector<std::string>& more = {}) {
    write(folder_name + ".toml", flight(vx));
    write("s" + std::to_string(vx) + ".csv",
          "x,y,z,radius,vx,vy,vz\n0.5,0.5,0.5,0.01," + std::to_string(vx) + ",0,0\n0.2,0.2,0.2,0.01,0,0,0.1\n");
    std::vector<std::string> arguments = {"run", folder_name + ".toml", "--out", folder_name};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Result r = talus(arguments);
    ASSERT_EQ(r.exit_code, 0) << r.err;
  }
};

TEST_F(Compare, DifferenceOfTwoFlightsIsTheKnownOneInEveryFrame) {
  flight_run("a", 1);
  flight_run("b", 1.001);
  const Result r = talus({"compare", "a", "b", "--json"});
  EXPECT_EQ(r.exit_code, 1) << r.err;
  EXPECT_EQ(json_value(r.out, "equal"), "false");
  EXPECT_EQ(json_value(r.out, "frames_equal"), "false");
  // frame 0: equal positions, other velocities; last frame, t = 0.4: 4e-4 m apart, one of two particles, across a wrap
  EXPECT_EQ(json_value(r.out, "first_difference_id"), "0");
  EXPECT_EQ(number(json_value(r.out, "first_difference_time")), 0);
  const std::string last = r.out.substr(r.out.rfind("\"time\""));
  EXPECT_NEAR(number(json_value(last, "time")), 0.4, 1e-12);
  EXPECT_NEAR(number(json_value(last, "max")), 4e-4, 1e-12);
  EXPECT_NEAR(number(json_value(last, "rms")), 4e-4 / std::sqrt(2.0), 1e-12);
  EXPECT_NEAR(number(json_value(last, "rms_velocity")), 1e-3 / std::sqrt(2.0), 1e-12);
  EXPECT_EQ(json_value(last, "different"), "1");
  const Result text = talus({"compare", "a", "b"});
  EXPECT_NE(text.out.find("first that differs at t = 0 s"), std::string::npos) << text.out;
  EXPECT_NE(text.out.find("growth: rms ~ exp("), std::string::npos) << text.out;
}

TEST_F(Compare, ColumnsOfPartsCountAsTheGrainsDo) {
  const std::string heat = "[heat]\ncapacity = 800\nconductivity = 1\ntemperature = ";
  write("s1.csv", "x,y,z,radius,vx,vy,vz\n0.5,0.5,0.5,0.01,1,0,0\n0.2,0.2,0.2,0.01,0,0,0.1\n");
  for (const std::string folder : {"a", "b"}) {
    std::string text = flight(1);
    text.replace(text.find("s1.000000.csv"), 13, "s1.csv");
    write(folder + ".toml", text + heat + (folder == "a" ? "300\n" : "312.5\n"));
    ASSERT_EQ(talus({"run", folder + ".toml", "--out", folder}).exit_code, 0);
  }
  const Result text = talus({"compare", "a", "b"}), json = talus({"compare", "a", "b", "--json"});
  EXPECT_EQ(text.exit_code, 1);
  EXPECT_NE(text.out.find("first difference: particle 0, temperature [K]"), std::string::npos) << text.out;
  EXPECT_NE(text.out.find("temperature [K] 2 particles differ, at most 1.250e+01"), std::string::npos) << text.out;
  EXPECT_NE(text.out.find("the first that differs at t = 0 s"), std::string::npos) << text.out;
  EXPECT_NE(text.out.find("also in the columns: temperature"), std::string::npos) << text.out;
  EXPECT_EQ(json_value(json.out, "first_difference_field"), "temperature [K]");
  EXPECT_EQ(talus({"compare", "a", "a"}).exit_code, 0);
}

TEST_F(Compare, BodiesThatLieOtherwiseDiffer) {
  const std::string shape = "[[shape]]\nname = \"pill\"\nkind = \"superquadric\"\nsemi_axes = [0.02, 0.02, 0.01]\n";
  for (const std::string folder : {"a", "b"}) {
    write("s1.csv", std::string("x,y,z,radius,vx,vy,vz,shape,scale,qw,qx,qy,qz\n0.5,0.5,0.5,0,1,0,0,pill,1,") +
                        (folder == "a" ? "1,0,0,0\n" : "0.6,0.8,0,0\n"));
    std::string text = flight(1);
    text.replace(text.find("s1.000000.csv"), 13, "s1.csv");
    write(folder + ".toml", text + shape);
    const Result r = talus({"run", folder + ".toml", "--out", folder});
    ASSERT_EQ(r.exit_code, 0) << r.err;
  }
  const Result r = talus({"compare", "a", "b"});
  EXPECT_EQ(r.exit_code, 1);
  EXPECT_NE(r.out.find("first difference: particle 0, orientation"), std::string::npos) << r.out;
  EXPECT_NE(r.out.find("the first that differs at t = 0 s"), std::string::npos) << r.out;
  EXPECT_EQ(talus({"compare", "a", "a"}).exit_code, 0);
}

TEST_F(Compare, RunsOfOtherStepsAreMatchedByTime) {
  flight_run("a", 1);
  flight_run("b", 1, {"--set", "time.step=5e-4", "--set", "time.steps=800"});
  const Result r = talus({"compare", "a", "b", "--json"});
  const std::string last = r.out.substr(r.out.rfind("\"time\""));
  EXPECT_EQ(json_value(last, "step_a"), "400");
  EXPECT_EQ(json_value(last, "step_b"), "800");
  EXPECT_LT(number(json_value(last, "max")), 1e-13);  // straight flight: rounding only
}

TEST_F(Compare, EqualRunsAreEqualInEveryFrame) {
  write("scene.toml", small_scene());
  ASSERT_EQ(talus({"run", "scene.toml", "--out", "a", "--steps", "200"}).exit_code, 0);
  ASSERT_EQ(talus({"run", "scene.toml", "--out", "b", "--steps", "200", "--chunk", "64", "--threads", "2"}).exit_code,
            0);
  const Result r = talus({"compare", "a", "b"});
  EXPECT_EQ(r.exit_code, 0) << r.out;
  EXPECT_NE(r.out.find("and so are"), std::string::npos) << r.out;
  // a run with more frames is compared on the common ones
  ASSERT_EQ(
      talus({"run", "scene.toml", "--out", "c", "--steps", "200", "--set", "output.particles_every=0.0001"}).exit_code,
      0);
  EXPECT_EQ(talus({"compare", "a", "c"}).exit_code, 0);
}

TEST_F(Compare, ReaderGivesBackTheBitsOfTheWriter) {
  ParticleColumns columns;
  Frame f;
  f.id = {3, 7};
  f.x = {{0.1, 1.0 / 3, 1e-300}, {-0.0, 2, 3}};
  f.v = {{1, 2, 3}, {4, 5, 0.1}};
  f.r = {0.5, 0.25};
  const std::string path = (folder / "p.vtkhdf").string();
  {
    VtkHdfWriter writer(path, columns);
    f.step = 5;
    f.time = 0.5;
    writer.append(f);
    f.step = 9;
    f.time = 0.9;
    f.id = {7};
    f.x.pop_back();
    f.v.pop_back();
    f.r.pop_back();
    writer.append(f);
  }
  const VtkHdfReader reader(path);
  ASSERT_EQ(reader.steps().size(), 2U);
  EXPECT_EQ(reader.steps()[1].step, 9);
  const Frame a = reader.frame(0), b = reader.frame(1);
  ASSERT_EQ(a.id.size(), 2U);
  EXPECT_EQ(a.id[1], 7);
  EXPECT_EQ(a.x[0].y, 1.0 / 3);
  EXPECT_TRUE(std::signbit(a.x[1].x));
  EXPECT_EQ(a.v[1].z, 0.1);
  ASSERT_EQ(b.id.size(), 1U);
  EXPECT_EQ(b.x[0].z, 1e-300);
  write("foreign.vtkhdf", "no HDF5");
  EXPECT_THROW(VtkHdfReader((folder / "foreign.vtkhdf").string()), std::runtime_error);
}

}  // namespace
}  // namespace talus::test
