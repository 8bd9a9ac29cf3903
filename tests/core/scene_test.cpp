// Claims about scene files: every key, every default, every refusal with its position.
#include <gtest/gtest.h>

#include <functional>
#include <set>

#include "core/base/error.hpp"
#include "core/scene/scene_file.hpp"
#include "core/scene/scene_keys.hpp"

namespace talus {
namespace {

constexpr const char* k_minimal = R"([domain]
lower = [0, 0, 0]
upper = [1, 1, 2]
[time]
step = 1e-5
steps = 100
[[material]]
name = "glass"
density = 2500
[contact]
normal_stiffness = 7e4
)";

Scene parse(const std::string& text, const std::vector<std::string>& overrides = {}) {
  return parse_scene(text, "t.toml", ".", overrides);
}

/// The message of the Error{scene} that parsing must raise.
std::string refusal(const std::string& text, const std::vector<std::string>& overrides = {}) {
  try {
    parse(text, overrides);
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::scene);
    return e.what();
  }
  return "accepted";
}

#define EXPECT_CONTAINS(text, part) EXPECT_NE(std::string(text).find(part), std::string::npos) << text

TEST(SceneFile, MinimalSceneGetsTheDefaultsOfTheTable) {
  const Scene s = parse(k_minimal);
  EXPECT_EQ(s.domain.upper.z, 2);
  EXPECT_EQ(s.domain.boundary[2][1], Boundary::wall);
  EXPECT_EQ(s.dt, 1e-5);
  EXPECT_EQ(s.steps, 100);
  EXPECT_EQ(s.seed, 1u);
  EXPECT_EQ(s.sort_every, 1000);
  EXPECT_EQ(s.contact.model, ContactModel::linear);
  EXPECT_EQ(s.contact.tangential_stiffness, 2.0 / 7.0 * 7e4);
  EXPECT_FALSE(s.contact.friction);
  EXPECT_FALSE(s.contact.by_restitution);
  EXPECT_EQ(s.contact.dashpot, Dashpot::centred);
  EXPECT_TRUE(s.contact.synchronised);
  EXPECT_EQ(s.list.policy, ListPolicy::local);
  EXPECT_TRUE(s.list.automatic);
  EXPECT_TRUE(s.list.floor_on && s.list.acceleration_on && s.list.cap_on);
  EXPECT_EQ(s.list.floor, 0.02);
  EXPECT_EQ(s.max_overlap, 0.5);
  EXPECT_TRUE(s.output.vtp);
  EXPECT_FALSE(s.output.vtkhdf);
  EXPECT_FALSE(s.output.grid.on);
}

// Defaults of the table and of the struct are stated twice; they must agree.
TEST(SceneFile, DefaultsEqualThoseOfThePlainStruct) {
  const Scene a = parse(k_minimal), b;
  EXPECT_EQ(a.integrator, b.integrator);
  EXPECT_EQ(a.list.verlet_k, b.list.verlet_k);
  EXPECT_EQ(a.list.automatic, b.list.automatic);
  EXPECT_EQ(a.list.floor, b.list.floor);
  EXPECT_EQ(a.list.uniform_skin, b.list.uniform_skin);
  EXPECT_EQ(a.list.cell_factor, b.list.cell_factor);
  EXPECT_EQ(a.list.policy, b.list.policy);
  EXPECT_EQ(a.sort_every, b.sort_every);
  EXPECT_EQ(a.max_overlap, b.max_overlap);
  EXPECT_EQ(a.seed, b.seed);
  EXPECT_EQ(a.contact.onset_correction, b.contact.onset_correction);
  EXPECT_EQ(a.contact.lever, b.contact.lever);
  EXPECT_EQ(a.output.vtkhdf, b.output.vtkhdf);
  EXPECT_EQ(a.output.vtp, b.output.vtp);
  EXPECT_EQ(a.output.checkpoint_wall, b.output.checkpoint_wall);
  EXPECT_EQ(a.monitor.warn_overlap, b.monitor.warn_overlap);
  EXPECT_EQ(a.monitor.warn_travel, b.monitor.warn_travel);
  EXPECT_EQ(a.monitor.max_travel, b.monitor.max_travel);
  EXPECT_EQ(a.monitor.warn_stiffness, b.monitor.warn_stiffness);
  EXPECT_EQ(a.monitor.warn_energy, b.monitor.warn_energy);
  EXPECT_EQ(a.monitor.max_energy, b.monitor.max_energy);
  EXPECT_EQ(a.relax.steps, b.relax.steps);
  EXPECT_EQ(a.relax.displacement, b.relax.displacement);
}

TEST(SceneFile, EveryKeyIsReadIntoTheScene) {
  const Scene s = parse(R"(
title = "all # keys"    # comment with ümlaut
seed = 7
gravity = [0.5, 0, -9.81]
integrator = "leapfrog"
sort_every = 77
[domain]
lower = [-1, -1, 0]
upper = [1, 1, 2]
boundary = ["periodic", "wall", ["wall", "open"]]
wall_material = "steel"
[time]
step = 2e-5
duration = 0.1
[damping]
viscous = 0.25
local = 0.5
[[material]]
name = "glass"
density = 2500
young = 5e7
poisson = 0.25
[[material]]
name = "steel"
density = 7800
young = 2e8
poisson = 0.3
[contact]
model = "hertz_mindlin"
friction = 0.5
restitution = 0.8
dashpot = "lagged"
onset_correction = false
synchronised = false
lever = "radius"
[[pair]]
materials = ["steel", "glass"]
friction = 0.2
restitution = 0.6
[[group]]
name = "bottom"
fixed_in_file = true
[[group]]
name = "slab"
region = {lower = [-1, -1, 0], upper = [1, 1, 0.1], radius = 0.5}
[[group]]
name = "first"
ids = [0, 99]
[[source]]
kind = "file"
name = "bed"
file = "bed.csv.gz"
group = "bottom"
[[source]]
kind = "stream"
mass_rate = 2.5
interval = 0.01
number = 1000
mass = 4
start = 0.1
end = 0.9
velocity = [0, 0, -1]
velocity_jitter = 0.1
material = "steel"
[source.region]
lower = [-0.5, -0.5, 1.5]
upper = [0.5, 0.5, 1.9]
radius = 0.4
[source.size]
kind = "sieve"
by = "mass"
edges = [0.01, 0.02, 0.04]
weights = [1, 3]
[[source]]
kind = "lattice"
lattice = "cubic"
spacing = 1.25
region = {lower = [0, 0, 0], upper = [1, 1, 1]}
size = {kind = "lognormal", min = 0.01, max = 0.03, mean = 0.02, stddev = 0.004}
[[wall]]
name = "gate"
shape = "box"
lower = [-1, -1, 0]
upper = [1, 1, 0.1]
appear = 0.05
vanish = 0.5
[wall.motion]
velocity = [1, 0, 0]
rotation_axis = [0, 2, 0]
rotation_rate = 3
rotation_origin = [0, 0, 1]
amplitude = [0, 0, 0.001]
frequency = 50
phase = 0.25
start = 0.2
end = 0.3
[[wall]]
shape = "cone"
point = [0, 0, 1]
axis = [0, 0, -3]
radius = 0.5
radius_end = 0.2
length = 0.7
material = "steel"
[[wall]]
shape = "mesh"
file = "silo.stl"
scale = 0.001
shift = [1, 2, 3]
[[event]]
time = 0.05
action = "drive"
group = "slab"
velocity = [1, 0, 0]
spin = [0, 1, 0]
[[event]]
time = 0.06
action = "gravity"
gravity = [0, 1, 0]
[list]
policy = "paper"
verlet_k = 50
cap = false
uniform_skin = 0.3
cell_factor = 1.5
[output]
particles_every = 0.01
vtkhdf = true
vtp = false
csv_every = 0.001
checkpoint_wall = 7.5
energies = true
contacts = true
coordination = true
stress = true
grid = [2, 3, 4]
[[output.plane]]
name = "outlet"
point = [0, 0, 0.1]
normal = [0, 0, -2]
[[output.region]]
name = "core"
lower = [0, 0, 0]
upper = [1, 1, 1]
radius = 0.3
[checks]
max_overlap = 0.25
allow_initial_overlap = true
allow_unstable_step = true
warn_overlap = 0.02
warn_travel = 0.03
max_travel = 0.4
warn_stiffness = 1.5
warn_energy = 0.01
max_energy = 0.7
[relax]
steps = 300
displacement = 0.005
)");
  EXPECT_EQ(s.title, "all # keys");
  EXPECT_EQ(s.seed, 7u);
  EXPECT_EQ(s.gravity.x, 0.5);
  EXPECT_EQ(s.integrator, Integrator::leapfrog);
  EXPECT_EQ(s.sort_every, 77);
  EXPECT_TRUE(s.domain.periodic(0));
  EXPECT_EQ(s.domain.boundary[1][0], Boundary::wall);
  EXPECT_EQ(s.domain.boundary[2][0], Boundary::wall);
  EXPECT_EQ(s.domain.boundary[2][1], Boundary::open);
  EXPECT_EQ(s.domain.wall_material, 1);
  EXPECT_EQ(s.steps, 5000);
  EXPECT_EQ(s.viscous_damping, 0.25);
  EXPECT_EQ(s.local_damping, 0.5);
  EXPECT_EQ(s.materials[1].young, 2e8);
  EXPECT_EQ(s.materials[1].poisson, 0.3);
  EXPECT_EQ(s.contact.model, ContactModel::hertz_mindlin);
  EXPECT_TRUE(s.contact.friction);
  EXPECT_EQ(s.contact.dashpot, Dashpot::lagged);
  EXPECT_FALSE(s.contact.onset_correction);
  EXPECT_FALSE(s.contact.synchronised);
  EXPECT_EQ(s.contact.lever, Lever::radius);
  EXPECT_EQ(s.pair(0, 0).friction, 0.5);
  EXPECT_EQ(s.pair(0, 1).friction, 0.2);
  EXPECT_EQ(s.pair(1, 0).friction, 0.2);
  EXPECT_EQ(s.pair(1, 0).restitution, 0.6);
  EXPECT_EQ(s.pair(1, 1).restitution, 0.8);
  ASSERT_EQ(s.groups.size(), 3u);
  EXPECT_TRUE(s.groups[0].fixed_in_file);
  EXPECT_EQ(s.groups[1].region->radius, 0.5);
  EXPECT_EQ((*s.groups[2].ids)[1], 99);
  ASSERT_EQ(s.sources.size(), 3u);
  EXPECT_EQ(s.sources[0].kind, Source::Kind::file);
  EXPECT_EQ(s.sources[0].group, 0);
  const Source& stream = s.sources[1];
  EXPECT_EQ(stream.name, "source_1");
  EXPECT_EQ(stream.mass_rate, 2.5);
  EXPECT_EQ(stream.interval, 0.01);
  EXPECT_EQ(stream.number, 1000);
  EXPECT_EQ(stream.mass, 4);
  EXPECT_EQ(stream.end, 0.9);
  EXPECT_EQ(stream.velocity.z, -1);
  EXPECT_EQ(stream.velocity_jitter, 0.1);
  EXPECT_EQ(stream.material, 1);
  EXPECT_EQ(stream.region.radius, 0.4);
  EXPECT_TRUE(stream.size.by_mass);
  EXPECT_EQ(stream.size.largest(), 0.04);
  EXPECT_EQ(s.sources[2].lattice, Source::Lattice::cubic);
  EXPECT_EQ(s.sources[2].spacing, 1.25);
  EXPECT_EQ(s.sources[2].size.kind, SizeDistribution::Kind::lognormal);
  EXPECT_EQ(s.sources[2].size.smallest(), 0.01);
  ASSERT_EQ(s.walls.size(), 3u);
  EXPECT_EQ(s.walls[0].name, "gate");
  EXPECT_EQ(s.walls[0].vanish, 0.5);
  EXPECT_EQ(s.walls[0].motion.rotation_axis.y, 1);
  EXPECT_EQ(s.walls[0].motion.phase, 0.25);
  EXPECT_EQ(s.walls[0].motion.end, 0.3);
  EXPECT_EQ(s.walls[1].axis.z, -1);
  EXPECT_EQ(s.walls[1].radius_end, 0.2);
  EXPECT_EQ(s.walls[2].file, "silo.stl");
  EXPECT_EQ(s.walls[2].shift.z, 3);
  EXPECT_EQ(s.events[0].action, Event::Action::drive);
  EXPECT_EQ(s.events[0].group, 1);
  EXPECT_EQ(s.events[0].spin.y, 1);
  EXPECT_EQ(s.events[1].action, Event::Action::gravity);
  EXPECT_EQ(s.events[1].vector.y, 1);
  EXPECT_EQ(s.list.policy, ListPolicy::paper);
  EXPECT_FALSE(s.list.floor_on);
  EXPECT_FALSE(s.list.acceleration_on);
  EXPECT_FALSE(s.list.cap_on);
  EXPECT_EQ(s.output.checkpoint_wall, 7.5);
  EXPECT_FALSE(s.output.vtp);
  EXPECT_TRUE(s.output.vtkhdf && s.output.energies && s.output.contacts && s.output.stress && s.output.coordination);
  EXPECT_EQ(s.output.grid.cells[2], 4);
  EXPECT_EQ(s.output.flux_planes[0].normal.z, -1);
  EXPECT_EQ(s.output.regions[0].region.radius, 0.3);
  EXPECT_EQ(s.max_overlap, 0.25);
  EXPECT_TRUE(s.allow_initial_overlap && s.allow_unstable_step);
  EXPECT_EQ(s.monitor.warn_overlap, 0.02);
  EXPECT_EQ(s.monitor.warn_travel, 0.03);
  EXPECT_EQ(s.monitor.max_travel, 0.4);
  EXPECT_EQ(s.monitor.warn_stiffness, 1.5);
  EXPECT_EQ(s.monitor.warn_energy, 0.01);
  EXPECT_EQ(s.monitor.max_energy, 0.7);
  EXPECT_EQ(s.relax.steps, 300);
  EXPECT_EQ(s.relax.displacement, 0.005);
}

TEST(SceneFile, ExampleOfEveryKeyParsesAndHoldsTheKey) {
  for (const SceneKey& key : scene_keys()) {
    const std::string text = scene_key_example(key);
    EXPECT_CONTAINS(text, std::string(key.name) + " = " + std::string(key.example));
    try {
      parse(text);
    } catch (const Error& e) {
      ADD_FAILURE() << full_name(key) << ": " << e.what() << "\n" << text;
    }
  }
}

TEST(SceneFile, UnknownKeyNamesNearestAndPosition) {
  const std::string m = refusal(std::string(k_minimal) + "normal_stifness = 3\n");
  EXPECT_CONTAINS(m, "t.toml:12:1: contact.normal_stifness: unknown key (did you mean 'contact.normal_stiffness'?)");
  EXPECT_CONTAINS(refusal("[domian]\n"), "did you mean 'domain'?");
  EXPECT_CONTAINS(refusal("step = 1\n"), "did you mean 'time.step'?");
  EXPECT_CONTAINS(refusal(std::string(k_minimal) + "[output.plain]\nx = 1\n"),
                  "output.plain: unknown key (did you mean 'plane'?)");
}

TEST(SceneFile, WrongTypeIsRefusedForEveryKey) {
  for (const SceneKey& key : scene_keys()) {
    std::string text = scene_key_example(key);
    const std::string line = std::string(key.name) + " = " + std::string(key.example) + "\n";
    // A date fits no type.
    std::size_t at = std::string::npos;
    const std::string header = key.section.empty() ? "" : "[" + std::string(key.section) + "]";
    const std::size_t from = header.empty() ? 0 : text.rfind(header);
    at = text.find("\n" + line, from == std::string::npos ? 0 : from);
    at = at == std::string::npos ? text.find(line) : at + 1;
    ASSERT_NE(at, std::string::npos) << full_name(key);
    text.replace(at, line.size(), std::string(key.name) + " = 2020-01-01\n");
    const std::string m = refusal(text);
    EXPECT_CONTAINS(m, std::string(key.name) + ": 2020-01-01: must be " + allowed_text(key));
    EXPECT_CONTAINS(m, "t.toml:");
  }
}

TEST(SceneFile, OutOfRangeAndNonFiniteNumbersAreRefused) {
  EXPECT_CONTAINS(refusal(k_minimal, {"time.step=0"}), "time.step: 0: must be a number > 0 [s]");
  EXPECT_CONTAINS(refusal(k_minimal, {"time.step=nan"}), "must be a number > 0 [s]");
  EXPECT_CONTAINS(refusal(k_minimal, {"time.step=inf"}), "must be a number > 0 [s]");
  EXPECT_CONTAINS(refusal(k_minimal, {"material.0.density=-5"}),
                  "material.0.density: -5: must be a number > 0 [kg/m3]");
  EXPECT_CONTAINS(refusal(k_minimal, {"contact.restitution=1.5"}), "in (0, 1] [-]");
  EXPECT_CONTAINS(refusal(k_minimal, {"gravity=[0, 0, nan]"}), "3 numbers");
  EXPECT_CONTAINS(refusal(k_minimal, {"gravity=[0, 0]"}), "3 numbers");
  EXPECT_CONTAINS(refusal(k_minimal, {"time.steps=1.5"}), "must be an integer");
  EXPECT_CONTAINS(refusal(k_minimal, {"seed=-1"}), "must be an integer >= 0");
}

TEST(SceneFile, MissingRequiredKeysAreNamed) {
  EXPECT_CONTAINS(refusal(""), "required");
  EXPECT_CONTAINS(refusal("[time]\nsteps = 3\n"), "t.toml:1:1: time.step: missing: required");
  std::string no_density = k_minimal;
  no_density.replace(no_density.find("density = 2500\n"), 15, "");
  EXPECT_CONTAINS(refusal(no_density), "t.toml:7:1: material.0.density: missing");
  EXPECT_CONTAINS(refusal(k_minimal, {"contact.model=hertz_mindlin"}), "normal_stiffness: 7");
  std::string hertz = k_minimal;
  hertz.replace(hertz.find("normal_stiffness = 7e4"), 22, "model = \"hertz_mindlin\"");
  EXPECT_CONTAINS(refusal(hertz), "material.0.young: missing: required by the Hertz models");
  EXPECT_CONTAINS(refusal(hertz, {"material.0.young=1e7", "material.0.poisson=0.2"}), "contact.restitution: missing");
}

TEST(SceneFile, ContradictoryKeysAreRefused) {
  const std::string text = k_minimal;
  EXPECT_CONTAINS(refusal(text + "restitution = 0.5\nnormal_damping = 3\n"), "contradicts 'restitution'");
  EXPECT_CONTAINS(refusal("[time]\nstep = 1\nsteps = 2\nduration = 3\n"), "t.toml:4:12: time.duration: 3");
  EXPECT_CONTAINS(refusal(text + "[[wall]]\nshape = \"plane\"\nradius = 2\n"),
                  "wall.0.radius: 2: has no effect with shape = plane; allowed only for cylinder, cone");
  EXPECT_CONTAINS(refusal(text + "[[source]]\nkind = \"file\"\nfile = \"a\"\nsize = {diameter = 1}\n"),
                  "has no effect with kind = file");
  EXPECT_CONTAINS(refusal(text, {"domain.boundary=[['periodic','wall'],'wall','wall']"}), "periodic on both sides");
  EXPECT_CONTAINS(refusal(text, {"domain.upper=[1, 0, 1]"}), "must be above 'lower'");
}

TEST(SceneFile, PolicyOfASceneThatNamesNoneFollowsWhatDrivesIt) {
  const std::vector<std::string> chute = {"gravity=[0.4, 0, -0.9]",
                                          "domain.boundary=[\"periodic\", \"periodic\", \"open\"]"};
  const auto policy = [&](const std::string& more, const std::string& set = "") {
    std::vector<std::string> overrides = chute;
    if (!set.empty()) overrides.push_back(set);
    return parse(k_minimal + more, overrides).list.policy;
  };
  EXPECT_EQ(policy(""), ListPolicy::velocity_profile);
  EXPECT_EQ(policy("[list]\npolicy = \"local\"\n"), ListPolicy::local);
  EXPECT_EQ(policy("", "gravity=[0, 0, -1]"), ListPolicy::local);  // nothing drives a flow
  EXPECT_EQ(policy("", "domain.boundary=\"periodic\""), ListPolicy::local);
  EXPECT_EQ(policy("", "domain.boundary=[\"periodic\", \"periodic\", [\"wall\", \"open\"]]"), ListPolicy::local);
  EXPECT_EQ(policy("[[wall]]\nshape = \"plane\"\n"), ListPolicy::local);
}

TEST(SceneFile, NamesThatDoNotExistAreRefusedWithNearest) {
  const std::string text = k_minimal;
  EXPECT_CONTAINS(refusal(text + "[[wall]]\nshape = \"plane\"\nmaterial = \"glas\"\n"),
                  "wall.0.material: 'glas': no such material (did you mean 'glass'?); there is glass");
  EXPECT_CONTAINS(refusal(text + "[[event]]\ntime = 0\naction = \"freeze\"\ngroup = \"bed\"\n"),
                  "no such group; there is none");
  EXPECT_CONTAINS(refusal(text + "[[pair]]\nmaterials = [\"glass\", \"wood\"]\n"), "no such material");
  EXPECT_CONTAINS(refusal(text + "[list]\npolicy = \"locale\"\n"), "did you mean 'local'?");
  EXPECT_CONTAINS(refusal(text + "[[material]]\nname = \"glass\"\ndensity = 1\n"), "names must be unique");
}

TEST(SceneFile, RegionOutsideTheDomainIsRefused) {
  EXPECT_CONTAINS(refusal(std::string(k_minimal) + "[[source]]\nkind = \"lattice\"\nsize = {diameter = 0.1}\n"
                                                   "region = {lower = [0, 0, 0], upper = [1, 1, 3]}\n"),
                  "the region must lie within the domain");
}

TEST(SceneFile, FrictionlessUnlessSomePairHasPositiveFriction) {
  EXPECT_FALSE(parse(k_minimal, {"contact.friction=0"}).contact.friction);
  EXPECT_FALSE(parse(k_minimal, {"contact.friction=none"}).contact.friction);
  EXPECT_TRUE(parse(k_minimal, {"contact.friction=0.3"}).contact.friction);
  const std::string pair = std::string(k_minimal) + "[[pair]]\nmaterials = [\"glass\", \"glass\"]\nfriction = 0.2\n";
  EXPECT_TRUE(parse(pair).contact.friction);
  EXPECT_FALSE(parse(pair, {"pair.0.friction=none"}).contact.friction);
}

TEST(SceneFile, RestitutionSwitchesTheLinearLawToItAndNeedsEveryPair) {
  EXPECT_TRUE(parse(k_minimal, {"contact.restitution=0.9"}).contact.by_restitution);
  EXPECT_EQ(parse(k_minimal, {"contact.restitution=0.9"}).pair(0, 0).restitution, 0.9);
  const std::string two = std::string(k_minimal) +
                          "[[material]]\nname = \"b\"\ndensity = 1\n"
                          "[[pair]]\nmaterials = [\"glass\", \"b\"]\nrestitution = 0.5\n";
  EXPECT_CONTAINS(refusal(two), "contact.restitution: missing");
  EXPECT_EQ(parse(two, {"contact.restitution=1"}).pair(1, 0).restitution, 0.5);
}

TEST(SceneFile, OverridesReplaceValuesOfAnyKey) {
  const std::string text = std::string(k_minimal) + "[[wall]]\nshape = \"plane\"\n[[wall]]\nshape = \"plane\"\n";
  const Scene s = parse(text, {"list.verlet_k=17", "wall.1.motion.velocity=[1,2,3]", "title=two words",
                               "contact.friction = 0.25", "wall.0.name=floor", "time.duration=1"});
  EXPECT_EQ(s.list.verlet_k, 17);
  EXPECT_FALSE(s.list.automatic);
  EXPECT_EQ(s.walls[1].motion.velocity.y, 2);
  EXPECT_EQ(s.walls[0].motion.velocity.y, 0);
  EXPECT_EQ(s.title, "two words");
  EXPECT_EQ(s.pair(0, 0).friction, 0.25);
  EXPECT_EQ(s.walls[0].name, "floor");
  EXPECT_EQ(s.steps, 100000);
  EXPECT_EQ(parse(text, {"seed=3", "seed=4"}).seed, 4u);
}

TEST(SceneFile, ErrorsInOverridesNameTheOverride) {
  EXPECT_CONTAINS(refusal(k_minimal, {"list.verlet_kk=3"}),
                  "--set list.verlet_kk=3: list.verlet_kk: unknown key (did you mean 'list.verlet_k'?)");
  EXPECT_CONTAINS(refusal(k_minimal, {"list.verlet_k=many"}), "--set list.verlet_k=many: list.verlet_k: 'many'");
  EXPECT_CONTAINS(refusal(k_minimal, {"lists.verlet_k=3"}), "unknown section 'lists' (did you mean 'list.verlet_k'?)");
  EXPECT_CONTAINS(refusal(k_minimal, {"wall.0.name=a"}), "the scene has 0 [[wall]]");
  EXPECT_CONTAINS(refusal(k_minimal, {"verlet"}), "section.key=value");
  EXPECT_CONTAINS(refusal(k_minimal, {"seed=3\nsteps=4"}), "control characters");
  EXPECT_CONTAINS(refusal(k_minimal, {"gravity.x=3"}), "unknown section");
}

TEST(SceneFile, TextThatIsNotPlainTomlIsRefused) {
  EXPECT_EQ(parse(std::string("# gr\xc3\xbc\xc3\x9f\x01\n") + k_minimal).steps, 100);
  EXPECT_CONTAINS(refusal("title = \n"), "t.toml:1:");
  EXPECT_CONTAINS(refusal("a = 1\na = 2\n"), "t.toml:2:");
  EXPECT_CONTAINS(refusal(std::string(2 << 20, '#')), "at most 1 MiB");
  EXPECT_CONTAINS(refusal("title = " + std::string(5000, '[')), "t.toml");
  EXPECT_CONTAINS(refusal("[source]\nkind = \"file\"\n"), "each written [[source]]");
  EXPECT_CONTAINS(refusal("list = 3\n"), "must be a table, written [list]");
}

TEST(SceneFile, MissingFileIsASceneError) {
  try {
    load_scene("/nonexistent/scene.toml");
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.exit_code(), 3);
    EXPECT_CONTAINS(e.what(), "/nonexistent/scene.toml: cannot open");
  }
}

TEST(SceneHelp, ListsEveryKeyOnceWithTypeAndDefault) {
  const std::string help = scene_help("");
  std::set<std::string> names;
  for (const SceneKey& key : scene_keys()) {
    EXPECT_TRUE(names.insert(full_name(key)).second) << full_name(key);
    EXPECT_CONTAINS(help, "  " + full_name(key) + " ");
    EXPECT_CONTAINS(help, allowed_text(key));
    EXPECT_NE(find_scene_section(key.section), nullptr);
    EXPECT_FALSE(key.doc.empty() || key.example.empty() || key.fallback.empty());
  }
}

TEST(SceneHelp, KeyAndSectionTextsHoldTheExample) {
  const std::string key = scene_help("contact.friction");
  EXPECT_CONTAINS(key, "[contact]\n    friction = 0.5");
  EXPECT_CONTAINS(key, "Coulomb");
  EXPECT_CONTAINS(scene_help("wall"), "wall.motion");
  EXPECT_CONTAINS(scene_help("source.spacing"), "only for: kind = lattice");
  try {
    scene_help("contact.frictoin");
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::usage);
    EXPECT_CONTAINS(e.what(), "did you mean 'contact.friction'?");
  }
}

TEST(SizeDistributionBounds, FollowTheKind) {
  SizeDistribution s;
  s.diameter = 3;
  EXPECT_EQ(s.smallest(), 3);
  s.kind = SizeDistribution::Kind::normal;
  s.min = 1, s.max = 2;
  EXPECT_EQ(s.smallest(), 1);
  EXPECT_EQ(s.largest(), 2);
}

}  // namespace
}  // namespace talus
