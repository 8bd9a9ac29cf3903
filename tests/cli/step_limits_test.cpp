// What `check` says about the time step is what `run` does: a grid of scenes around the limit, walls that turn, grains
// of files.
#include <cmath>
#include <string>

#include "tests/cli/cli_runner.hpp"

namespace talus::test {
namespace {

std::string scene(const std::string& law, const std::string& more) {
  return R"(gravity = [0, 0, -9.81]
[domain]
lower = [0, 0, 0]
upper = [0.05, 0.05, 0.1]
[time]
step = 1e-8
steps = 40
[[material]]
name = "soft"
density = 2500
young = 5e6
poisson = 0.3
[[material]]
name = "steel"
density = 7800
young = 2e9
poisson = 0.3
[contact]
)" + law +
         more;
}

const char* const k_pack = R"([[source]]
kind = "random"
number = 60
region = { lower = [0, 0, 0], upper = [0.05, 0.05, 0.1] }
size = { kind = "uniform", min = 0.004, max = 0.006 }
)";

const char* const k_file = R"([[source]]
kind = "file"
file = "grains.csv"
)";

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

TEST_F(Cli, CheckAcceptsTheStepsThatRunAcceptsAndNoOthers) {
  write("grains.csv",
        "x,y,z,radius,vx,vy,vz,material\n0.01,0.01,0.01,0.001,0,0,-3,soft\n0.02,0.01,0.01,0.001,0,0,0,soft\n"
        "0.03,0.03,0.05,0.01,0,0,0,steel\n");
  const std::string hertz = "model = \"hertz_mindlin\"\n", linear = "model = \"linear\"\nnormal_stiffness = 1e4\n";
  const std::string rates = linear + "normal_damping = 3e3\n";
  const std::string rubs = "friction = 0.5\ntangential_stiffness = 8e3\n";
  int n = 0;
  for (const std::string& law :
       {linear + "restitution = 0.1\n", linear + "restitution = 0.5\n" + rubs, rates + "dashpot = \"lagged\"\n",
        rates + rubs + "tangential_damping = 2e3\n", hertz + "restitution = 0.5\nfriction = 0.4\n",
        hertz + "restitution = 0.2\n", hertz + "restitution = 0.9\nfriction = 0.3\ndashpot = \"pairwise\"\n"})
    for (const char* const source : {k_pack, k_file}) {
      const std::string name = write("scene" + std::to_string(n++) + ".toml", scene(law, source));
      const Result fine = talus({"check", name, "--json", "--calibrate", "0"});
      ASSERT_EQ(fine.exit_code, 0) << law << fine.err;
      const double limit = std::stod(json_value(fine.out, "time_step_limit"));
      for (const double share : {0.3, 0.999, 1.001, 2.0}) {
        const std::string set = "time.step=" + number(share * limit);
        const Result check = talus({"check", name, "--set", set, "--calibrate", "0"});
        const Result run = talus({"run", name, "--set", set, "--out", "out", "--overwrite", "--quiet"});
        EXPECT_EQ(check.exit_code, share > 1 ? 3 : 0) << law << source << share << check.err;
        EXPECT_EQ(run.exit_code, check.exit_code) << law << source << share << run.err;
        if (share > 1) {
          EXPECT_EQ(run.err, check.err) << law;
        }
      }
      EXPECT_EQ(talus({"check", name, "--calibrate", "0", "--set", "time.step=" + json_value(fine.out, "time_step_20")})
                    .exit_code,
                0)
          << law << source;
    }
}

TEST_F(Cli, ABladeIsJudgedByItsTip) {
  write("grain.csv", "x,y,z,radius,vx,vy,vz\n0.066,0.0227,0,0.001,0,0,0\n");
  write("blade.obj", "v 0.01 0 -0.02\nv 0.075 0 -0.02\nv 0.075 0 0.02\nv 0.01 0 0.02\nf 1 2 3\nf 1 3 4\n");
  const std::string text = R"([domain]
lower = [-0.1, -0.1, -0.1]
upper = [0.1, 0.1, 0.1]
boundary = "open"
[time]
step = 5e-5
steps = 1000
[[material]]
name = "g"
density = 2500
[contact]
model = "linear"
normal_stiffness = 100
restitution = 0.5
[[source]]
kind = "file"
file = "grain.csv"
[[wall]]
name = "blade"
shape = "mesh"
file = "blade.obj"
[wall.motion]
)";
  write("turns.toml", text + "rotation_axis = [0, 0, 1]\nrotation_rate = 628.3\n");
  write("flies.toml", text + "velocity = [0, 42, 0]\n");
  for (const char* name : {"turns.toml", "flies.toml"})
    for (const char* command : {"check", "run", "explain"}) {
      const Result r = talus({command, name});
      EXPECT_EQ(r.exit_code, 3) << command << name << r.err;
      EXPECT_NE(r.err.find("wall 'blade' moves 2."), std::string::npos) << r.err;
    }
  // motion that starts after the scene's end is met by a longer run
  write("later.toml", text + "rotation_axis = [0, 0, 1]\nrotation_rate = 628.3\nstart = 0.06\n");
  EXPECT_EQ(talus({"run", "later.toml", "--out", "later", "--quiet"}).exit_code, 0);
  const Result longer = talus({"run", "later.toml", "--resume", "later", "--steps", "2000", "--quiet"});
  EXPECT_EQ(longer.exit_code, 3) << longer.err;
}

TEST_F(Cli, AGrainOfAFileThatOutrunsTheStepIsNamedWithItsRow) {
  write("grains.csv",
        "x,y,z,radius,vx,vy,vz,material\n0.01,0.01,0.01,0.001,0,0,0,soft\n"
        "0.03,0.03,0.05,0.001,0,1500,0,soft\n");
  write("shot.toml", scene("model = \"linear\"\nnormal_stiffness = 10\n", k_file));
  const Result r = talus({"check", "shot.toml", "--set", "time.step=1e-6"});
  EXPECT_EQ(r.exit_code, 3) << r.out;
  EXPECT_NE(r.err.find("particle 1 moves 1.5 of its radius in one step (grains.csv:3; 1500 m/s)"), std::string::npos)
      << r.err;
  EXPECT_EQ(talus({"run", "shot.toml", "--set", "time.step=1e-6"}).exit_code, 3);
}

}  // namespace
}  // namespace talus::test
