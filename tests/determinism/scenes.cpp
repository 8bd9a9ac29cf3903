// The scenes of the trajectory tests.
#include "tests/determinism/scenes.hpp"

#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace talus::determinism {
namespace {

void set_boundary(Scene& s, int axis, Boundary lower, Boundary upper) {
  s.domain.boundary[static_cast<std::size_t>(axis)] = {lower, upper};
}

/// Linear law, one material: t_c/dt is about 12 for a pair of 2 mm grains of 2500 kg/m3.
Scene linear_scene(const char* title) {
  Scene s;
  s.title = title;
  s.seed = 7;
  s.dt = 2.5e-5;
  s.steps = k_steps;
  s.sort_every = k_sort_every;
  s.materials = {Material{"glass", 2500, 0, 0}};
  s.contact.normal_stiffness = 1000;
  s.contact.tangential_stiffness = 2.0 / 7.0 * 1000;
  s.contact.by_restitution = true;
  s.contact.tangential_damping = 50;
  s.pairs = {PairCoefficients{0.4, 0.7}};
  return s;
}

Source source(Source::Kind kind, const char* name, Vec3 lower, Vec3 upper, double d_min, double d_max) {
  Source q;
  q.kind = kind;
  q.name = name;
  q.region.lower = lower;
  q.region.upper = upper;
  q.size.kind = d_min == d_max ? SizeDistribution::Kind::constant : SizeDistribution::Kind::uniform;
  q.size.diameter = d_max;
  q.size.min = d_min;
  q.size.max = d_max;
  return q;
}

}  // namespace

std::string temporary_file(const std::string& name, const std::string& bytes) {
  struct Folder {
    std::filesystem::path path =
        std::filesystem::temp_directory_path() / ("talus_determinism_" + std::to_string(::getpid()));
    Folder() { std::filesystem::create_directories(path); }
    ~Folder() {
      std::error_code ignored;
      std::filesystem::remove_all(path, ignored);
    }
  };
  static const Folder folder;
  const auto path = folder.path / name;
  if (!bytes.empty()) std::ofstream(path, std::ios::binary) << bytes;
  return path.string();
}

std::string read_bytes(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream all;
  all << in.rdbuf();
  return all.str();
}

std::string bumpy_mesh(int n, double bump) {
  std::string s;
  char line[128];
  for (int y = 0; y <= n; ++y)
    for (int x = 0; x <= n; ++x) {
      const double height = bump * ((x * 7 + y * 5) % 4) / 3.0;
      std::snprintf(line, sizeof line, "v %.17g %.17g %.17g\n", 1.0 * x / n, 1.0 * y / n, height);
      s += line;
    }
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      const int a = y * (n + 1) + x + 1;
      std::snprintf(line, sizeof line, "f %d %d %d\nf %d %d %d\n", a, a + 1, a + n + 2, a, a + n + 2, a + n + 1);
      s += line;
    }
  return temporary_file("bumps_" + std::to_string(n) + "_" + std::to_string(bump) + ".obj", s);
}

Scene hopper() {
  Scene s = linear_scene("hopper");
  s.allow_unstable_step = true;  // above the limit of dense packings: a loose one that moves far between two lists
  s.domain.lower = {-0.02, -0.02, 0};
  s.domain.upper = {0.02, 0.02, 0.06};
  set_boundary(s, 2, Boundary::open, Boundary::wall);
  s.gravity = {0, 0, -9.81};
  Source fill =
      source(Source::Kind::random, "fill", {-0.0115, -0.0115, 0.014}, {0.0115, 0.0115, 0.048}, 1.6e-3, 2.4e-3);
  fill.region.radius = 0.0115;
  fill.number = 760;
  fill.velocity = {0, 0, -0.8};
  fill.velocity_jitter = 0.3;
  Source stream = source(Source::Kind::stream, "stream", {-0.008, -0.008, 0.05}, {0.008, 0.008, 0.058}, 1.2e-3, 2e-3);
  stream.number = 90;
  stream.number_rate = 3000;
  stream.interval = 3.1e-3;
  stream.start = 2.2e-3;
  stream.velocity = {0, 0, -1};
  stream.velocity_jitter = 0.2;
  s.sources = {fill, stream};
  WallSpec silo;
  silo.name = "silo";
  silo.shape = WallShape::cylinder;
  silo.point = {0, 0, 0.012};
  silo.axis = {0, 0, 1};
  silo.length = 0.048;
  silo.radius = 0.012;
  WallSpec funnel;
  funnel.name = "funnel";
  funnel.shape = WallShape::cone;
  funnel.point = {0, 0, 0.004};
  funnel.axis = {0, 0, 1};
  funnel.length = 0.008;
  funnel.radius = 0.007;
  funnel.radius_end = 0.012;
  WallSpec gate;
  gate.name = "gate";
  gate.shape = WallShape::box;
  gate.lower = {-0.008, -0.008, 0.0025};
  gate.upper = {0.008, 0.008, 0.0038};
  gate.motion.velocity = {1.5, 0, 0};
  gate.motion.start = 0.0081;
  gate.motion.end = 0.0181;
  s.walls = {silo, funnel, gate};
  return s;
}

Scene sheared_bed() {
  Scene s = linear_scene("sheared bed");
  s.domain.lower = {0.5, -0.25, 0};
  s.domain.upper = {0.524, -0.234, 0.032};
  set_boundary(s, 0, Boundary::periodic, Boundary::periodic);
  set_boundary(s, 1, Boundary::periodic, Boundary::periodic);
  s.gravity = {0, 0, -9.81};
  Source bed = source(Source::Kind::lattice, "bed", s.domain.lower, {0.524, -0.234, 0.0215}, 1.8e-3, 2e-3);
  bed.spacing = 1.02;
  bed.number = 900;
  bed.velocity_jitter = 0.3;
  s.sources = {bed};
  GroupSpec bottom{"bottom", false, Region{s.domain.lower, {0.524, -0.234, 0.0016}, 0}, std::nullopt};
  GroupSpec top{"top", false, Region{{0.5, -0.25, 0.0165}, {0.524, -0.234, 0.032}, 0}, std::nullopt};
  s.groups = {bottom, top};
  Event freeze, drive, stop, tilt;
  freeze.action = Event::Action::freeze;
  freeze.group = 0;
  drive.action = Event::Action::drive;
  drive.group = 1;
  drive.vector = {0.6, 0.05, -0.01};
  drive.time = 0.004;
  tilt.action = Event::Action::gravity;
  tilt.time = 0.02;
  tilt.vector = {2, 0, -9.6};
  stop.action = Event::Action::release;
  stop.group = 1;
  stop.time = 0.04;
  s.events = {freeze, drive, tilt, stop};
  return s;
}

Scene gas() {
  Scene s = linear_scene("gas");
  s.domain.upper = {0.02, 0.02, 0.025};
  for (int k = 0; k < 3; ++k) set_boundary(s, k, Boundary::periodic, Boundary::periodic);
  s.contact.friction = false;
  s.contact.tangential_stiffness = s.contact.tangential_damping = 0;
  s.pairs = {PairCoefficients{0, 1}};
  Source fill = source(Source::Kind::lattice, "gas", s.domain.lower, s.domain.upper, 2e-3, 2e-3);
  fill.spacing = 1.06;
  fill.velocity_jitter = 1;
  s.sources = {fill};
  return s;
}

Scene pile_on_mesh() {
  Scene s = linear_scene("pile on a mesh");
  s.domain.upper = {0.03, 0.024, 0.06};
  set_boundary(s, 1, Boundary::periodic, Boundary::periodic);
  s.gravity = {0, 0, -9.81};
  s.contact.by_restitution = false;
  s.contact.normal_damping = 900;
  s.contact.tangential_damping = 450;
  s.dt = 1e-5;  // grains of 0.8 mm are 16 times lighter than those of 2 mm
  s.output.energies = true;
  Source fill = source(Source::Kind::random, "fill", {0.001, 0, 0.004}, {0.029, 0.024, 0.03}, 0.8e-3, 3.2e-3);
  fill.size.kind = SizeDistribution::Kind::lognormal;
  fill.size.mean = 1.7e-3;
  fill.size.stddev = 0.6e-3;
  fill.number = 1000;
  fill.velocity = {0, 0, -1.5};
  fill.velocity_jitter = 0.5;
  s.sources = {fill};
  WallSpec floor;
  floor.name = "floor";
  floor.shape = WallShape::mesh;
  floor.file = bumpy_mesh(6, 0.05);
  floor.scale = 0.036;  // four squares of the pattern are one period in y: the surface continues across the border
  floor.shift = {-0.003, -0.006, 0.0015};
  floor.motion.rotation_axis = {0, 1, 0};
  floor.motion.rotation_origin = {0.015, 0, 0.0015};
  floor.motion.rotation_rate = 4;
  floor.motion.start = 0.004;
  floor.motion.end = 0.012;
  s.walls = {floor};
  return s;
}

Scene hertz_drum() {
  Scene s = linear_scene("Hertz drum");
  s.allow_unstable_step = true;  // above the limit of dense packings: a loose one that moves far between two lists
  s.domain.lower = {-0.016, 0, -0.016};
  s.domain.upper = {0.016, 0.02, 0.016};
  s.gravity = {0, 0, -9.81};
  s.dt = 2e-5;
  s.materials = {Material{"glass", 2500, 4e6, 0.25}, Material{"rubber", 1200, 1e6, 0.4}};
  s.contact = ContactLaw{};
  s.contact.model = ContactModel::hertz_mindlin;
  s.pairs = {PairCoefficients{0.3, 0.9}, PairCoefficients{0.5, 0.6}, PairCoefficients{0.5, 0.6},
             PairCoefficients{0.8, 0.4}};
  Source light = source(Source::Kind::random, "rubber", {-0.0085, 0, -0.0115}, {0.0085, 0.02, 0}, 1.6e-3, 2.4e-3);
  light.number = 260;
  light.material = 1;
  light.velocity = {0, 0, -0.5};
  light.velocity_jitter = 0.4;
  Source heavy = source(Source::Kind::random, "glass", {-0.0085, 0, 0}, {0.0085, 0.02, 0.0115}, 1.5e-3, 1.9e-3);
  heavy.number = 420;
  heavy.velocity = {0, 0, -1};
  heavy.velocity_jitter = 0.4;
  s.sources = {light, heavy};
  WallSpec drum;
  drum.name = "drum";
  drum.shape = WallShape::cylinder;
  drum.material = 1;
  drum.point = {0, -0.001, 0};
  drum.axis = {0, 1, 0};
  drum.length = 0.022;
  drum.radius = 0.0145;
  drum.motion.rotation_axis = {0, 1, 0};
  drum.motion.rotation_rate = 30;
  WallSpec plane;
  plane.name = "shaker";
  plane.point = {0, 0, -0.0135};
  plane.normal = {0, 0, 1};
  plane.motion.amplitude = {0, 0, 3e-4};
  plane.motion.frequency = 80;
  s.walls = {drum, plane};
  return s;
}

Scene sticky_drum() {
  // JKR necks, rolling springs and twisting between grains, on a turning cylinder and on a shaken plane.
  Scene s = hertz_drum();
  s.title = "sticky drum";
  s.dt = 1e-5;
  s.contact.model = ContactModel::jkr;
  s.contact.rolling = Rolling::epsd;
  s.contact.twisting = true;
  for (PairCoefficients& p : s.pairs) {
    p.rolling_friction = 0.2;
    p.rolling_damping = 0.3;
    p.twisting_friction = 0.1;
    p.twisting_damping = 0.2;
    p.work_of_adhesion = 0.02 * p.restitution;
  }
  return s;
}

Scene slipping_drum() {
  // The widest history: partial slip, the dashpot's prediction, rolling and twisting springs.
  Scene s = hertz_drum();
  s.title = "slipping drum";
  s.output.energies = true;
  s.contact.partial_slip = true;
  s.contact.rolling = Rolling::epsd;
  s.contact.twisting = true;
  for (PairCoefficients& p : s.pairs) {
    p.rolling_friction = 0.2;
    p.rolling_damping = 0.3;
    p.twisting_friction = 0.1;
    p.twisting_damping = 0.2;
  }
  return s;
}

Scene cohesive_pile() {
  // Attraction by contact area and constant rolling moments on a turning mesh, with the energy ledger.
  Scene s = pile_on_mesh();
  s.title = "cohesive pile";
  s.contact.rolling = Rolling::cdt;
  s.contact.cohesion = Cohesion::sjkr;
  s.pairs[0].rolling_friction = 0.1;
  s.pairs[0].cohesion_energy = 2e4;
  return s;
}

Scene crossing_walls() {
  Scene s = linear_scene("crossing walls");
  s.domain.lower = {0.1, 0, -0.2};
  s.domain.upper = {0.13, 0.024, -0.17};
  for (int k = 0; k < 3; ++k) set_boundary(s, k, Boundary::periodic, Boundary::periodic);
  s.gravity = {0, 0, -9.81};
  s.contact.rolling = Rolling::epsd;
  s.allow_unstable_step = true;
  s.contact.normal_stiffness = 1500;
  s.pairs[0].rolling_friction = 0.1;
  s.pairs[0].rolling_damping = 0.3;
  Source fill = source(Source::Kind::lattice, "fill", {0.1, 0, -0.193}, {0.13, 0.024, -0.1795}, 1.6e-3, 2e-3);
  fill.spacing = 1.15;
  fill.number = 750;
  fill.velocity = {0, 0, -1};
  fill.velocity_jitter = 0.6;
  s.sources = {fill};
  // Ends in the side, and goes round twice. All walls and their images keep a grain's diameter apart:
  // nothing is crushed between them.
  WallSpec belt;
  belt.name = "belt";
  belt.shape = WallShape::box;
  belt.lower = {0.119, 0.0105, -0.1975};
  belt.upper = {0.13, 0.015, -0.195};
  belt.motion.velocity = {1.2, 0, 0};
  // Its middle is a corner of the domain.
  WallSpec paddle;
  paddle.name = "paddle";
  paddle.shape = WallShape::box;
  paddle.lower = {0.098, -0.003, -0.201};
  paddle.upper = {0.102, 0.003, -0.199};
  paddle.motion.rotation_axis = {1, 2, 1};
  paddle.motion.rotation_rate = 50;
  paddle.motion.rotation_origin = {0.1, 0, -0.2};
  // Crosses one side along its axis and another one with its lateral surface.
  WallSpec bar;
  bar.name = "bar";
  bar.shape = WallShape::cone;
  bar.point = {0.111, 0.015, -0.1715};
  bar.axis = {0, 1, 0};
  bar.length = 0.016;
  bar.radius = 0.0015;
  bar.radius_end = 0.001;
  bar.motion.amplitude = {0, 5e-4, 3e-4};
  bar.motion.frequency = 90;
  // As wide as the period in y, and beyond it in x.
  WallSpec floor;
  floor.name = "floor";
  floor.shape = WallShape::mesh;
  floor.file = bumpy_mesh(4, 0.04);
  floor.scale = 0.024;
  floor.shift = {0.114, 0, -0.177};
  s.walls = {belt, paddle, bar, floor};
  return s;
}

const std::vector<NamedScene>& scenes() {
  static const std::vector<NamedScene> all = {{"hopper", hopper},
                                              {"sheared_bed", sheared_bed},
                                              {"gas", gas},
                                              {"pile_on_mesh", pile_on_mesh},
                                              {"hertz_drum", hertz_drum},
                                              {"sticky_drum", sticky_drum},
                                              {"slipping_drum", slipping_drum},
                                              {"cohesive_pile", cohesive_pile},
                                              {"crossing_walls", crossing_walls}};
  return all;
}

std::string checkpoint_bytes(const Simulation& sim) {
  const std::string path = temporary_file("bytes.checkpoint");
  CheckpointWriter out;
  sim.save(out);
  out.commit(path);
  return read_bytes(path);
}

Scene heated(Scene s) {
  HeatScene& h = s.heat;
  h.on = true;
  h.every = 25;
  h.temperature = 300;
  h.friction = true;
  for (std::size_t k = 0; k < s.materials.size(); ++k) {
    MatterHeat m;
    m.capacity = {{700, 0.4}, 273, 250, 2000, {}, {}};
    m.conductivity = {{}, 0, 0, 0, {300, 900}, {20.0 + 5 * static_cast<double>(k), 40}};
    h.matter.push_back(m);
  }
  for (std::size_t k = 0; k < s.sources.size(); ++k) h.sources.push_back({k == 0 ? 350.0 : 900.0, k == 1});
  for (const WallSpec& w : s.walls) {
    WallHeat wall;
    wall.wall = w.name;
    if (h.walls.empty())
      wall.flux = TimeTable::constant(2e4);
    else
      wall.temperature = {{0, 0.02}, {300, 700}};
    h.walls.push_back(wall);
  }
  h.gas.on = true;
  h.gas.temperature = TimeTable::constant(600);
  h.gas.velocity = {0, 0, 1};
  h.gas.law = NusseltLaw::gunn;
  h.gap.conductivity = 0.05;
  h.radiation.grains = true;
  h.radiation.enclosure = TimeTable::constant(1100);
  return s;
}

}  // namespace talus::determinism
