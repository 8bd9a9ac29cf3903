// Fills the Scene section by section from checked tables, and refuses what only several keys together make wrong.
#include "core/scene/scene_file.hpp"

#include <fmt/format.h>

#include "core/base/count.hpp"
#include "core/base/error.hpp"
#include "core/frame/plane_count.hpp"
#include "core/grains/region.hpp"
#include "core/io/input_file.hpp"
#include "core/scene/scene_table.hpp"

namespace talus {
namespace {

constexpr std::uint64_t k_most_bytes = std::uint64_t{1} << 20;

void check_box(const SceneTable& r, Vec3 lower, Vec3 upper) {
  for (int k = 0; k < 3; ++k) {
    if (!(lower[k] < upper[k])) r.fail("upper", "must be above 'lower' on every axis");
  }
}

void read_cylinder(const SceneTable& r, Region& region) {
  region.point = r.vector("point");
  if (!r.has("end")) {
    r.require("length", "(or end) by shape = cylinder");
    region.axis = r.direction("axis");
    region.length = r.number("length");
    return;
  }
  r.exclusive("length", "end");
  r.exclusive("axis", "end");
  region.axis = r.vector("end") - region.point;
  region.length = norm(region.axis);
  if (!(region.length > 0)) r.fail("end", "must differ from 'point'");
}

/// Everything but the surface of a mesh, which load_scene() reads when the scene has been found valid.
Region read_region(const SceneTable& r) {
  Region region;
  region.shape = r.choice<Region::Shape>("shape");
  const std::string why = "by shape = " + r.text("shape");
  const auto require = [&](std::initializer_list<std::string_view> names) {
    for (const std::string_view name : names) r.require(name, why);
  };
  switch (region.shape) {
    case Region::Shape::box:
      require({"lower", "upper"});
      region.lower = r.vector("lower");
      region.upper = r.vector("upper");
      check_box(r, region.lower, region.upper);
      break;
    case Region::Shape::cylinder:
      require({"point", "radius"});
      read_cylinder(r, region);
      break;
    case Region::Shape::sphere:
      require({"centre", "radius"});
      region.point = r.vector("centre");
      break;
    case Region::Shape::mesh:
      require({"file"});
      region.file = r.text("file");
      if (region.file.empty()) r.fail("file", "must not be empty");
      region.scale = r.number("scale");
      region.shift = r.vector("shift");
      return region;
  }
  region.radius = r.number_or("radius", 0);
  if (region.shape != Region::Shape::box) set_bounds(region);
  return region;
}

/// A region that only counts where it meets the domain.
Region read_region(const SceneTable& r, const Domain& domain, bool within) {
  const Region region = read_region(r);
  if (region.shape == Region::Shape::mesh) return region;
  if (const auto fault = region_fault(domain, region, within)) r.fail(fault->key, fault->text);
  return region;
}

/// Names must be unique, since other sections refer to them.
std::string unique_name(const SceneTable& r, const std::string& fallback, std::vector<std::string>& names) {
  const std::string name = r.has("name") ? r.text("name") : fallback;
  for (const std::string& other : names) {
    if (other != name) continue;
    if (r.has("name")) r.fail("name", "this name is taken; names must be unique");
    return unique_name(r, fallback + "_", names);
  }
  if (r.has("name") && name.empty()) r.fail("name", "must not be empty");
  names.push_back(name);
  return name;
}

void read_domain(const SceneTable& r, Scene& scene, const std::vector<std::string>& materials) {
  Domain& d = scene.domain;
  d.lower = r.vector("lower");
  d.upper = r.vector("upper");
  check_box(r, d.lower, d.upper);
  const auto words = r.boundary("boundary");
  const auto side_of = [](const std::string& s) {
    return s == "periodic" ? Boundary::periodic : s == "open" ? Boundary::open : Boundary::wall;
  };
  for (std::size_t k = 0; k < 3; ++k) {
    d.boundary[k] = {side_of(words[k][0]), side_of(words[k][1])};
    if ((d.boundary[k][0] == Boundary::periodic) != (d.boundary[k][1] == Boundary::periodic))
      r.fail("boundary", "an axis is periodic on both sides or on none");
  }
  if (r.has("wall_material")) d.wall_material = r.index("wall_material", materials, "material");
}

void read_time(const SceneTable& r, Scene& scene) {
  scene.dt = r.number("step");
  r.exclusive("steps", "duration");
  if (r.has("steps")) {
    scene.steps = r.integer("steps");
  } else if (r.has("duration")) {
    const double steps = r.number("duration") / scene.dt;
    if (!(steps < 1e15)) r.fail("duration", "is more than 1e15 steps");
    scene.steps = count_nearest(steps);
  } else {
    r.missing("steps", "(or time.duration)");
  }
}

std::vector<std::string> read_materials(const std::vector<SceneTable>& list, Scene& scene, const SceneTable& root) {
  if (list.empty()) root.missing("material", "([[material]] with name and density)");
  if (list.size() > 255) root.fail("material", "at most 255 materials are allowed");
  std::vector<std::string> names;
  for (const SceneTable& r : list) {
    Material m;
    m.name = unique_name(r, "", names);
    m.density = r.number("density");
    m.young = r.number_or("young", 0);
    m.poisson = r.number_or("poisson", 0);
    scene.materials.push_back(m);
  }
  return names;
}

/// Friction of a section: absent -> fallback, "none" -> 0.
double read_friction(const SceneTable& r, double fallback) {
  return r.has("friction") ? r.number_or_text("friction").value_or(0) : fallback;
}

/// Coefficients of a section for what is added to the contact law: rolling, twisting, cohesion, adhesion.
void read_add_ons(const SceneTable& r, PairCoefficients& k) {
  k.rolling_friction = r.number_or("rolling_friction", k.rolling_friction);
  k.rolling_damping = r.number_or("rolling_damping", k.rolling_damping);
  k.twisting_friction = r.number_or("twisting_friction", k.twisting_friction);
  k.twisting_damping = r.number_or("twisting_damping", k.twisting_damping);
  k.cohesion_energy = r.number_or("cohesion_energy", k.cohesion_energy);
  k.work_of_adhesion = r.number_or("work_of_adhesion", k.work_of_adhesion);
}

/// What an addition needs of the law, and that it does something.
void check_add_ons(const SceneTable& r, const std::vector<SceneTable>& pairs, Scene& scene) {
  ContactLaw& c = scene.contact;
  double rolling = 0, twisting = 0, cohesion = 0, adhesion = 0;
  for (const PairCoefficients& k : scene.pairs) {
    rolling = fmax2(rolling, k.rolling_friction);
    twisting = fmax2(twisting, k.twisting_friction);
    cohesion = fmax2(cohesion, k.cohesion_energy);
    adhesion = fmax2(adhesion, k.work_of_adhesion);
  }
  c.twisting = twisting > 0;
  if (c.rolling != Rolling::none && !c.friction)
    r.fail("rolling", "needs contact.friction > 0: without friction no grain rotates");
  if (c.twisting && !c.friction) {
    const char* why = "needs contact.friction > 0: without friction no grain rotates";
    if (r.has("twisting_friction")) r.fail("twisting_friction", why);
    for (const SceneTable& p : pairs)
      if (p.has("twisting_friction")) p.fail("twisting_friction", why);
  }
  if (!c.twisting && r.has("twisting_damping"))
    r.fail("twisting_damping", "has no effect without twisting_friction > 0");
  if (c.rolling != Rolling::none && rolling == 0)
    r.missing("rolling_friction", "(> 0 for some pair) by contact.rolling");
  if (c.cohesion != Cohesion::none && cohesion == 0)
    r.missing("cohesion_energy", "(> 0 for some pair) by contact.cohesion");
  if (c.model == ContactModel::jkr && adhesion == 0)
    r.missing("work_of_adhesion", "(> 0 for some pair) by contact.model = jkr");
  for (const SceneTable& p : pairs) {
    if (p.has("rolling_friction") && c.rolling == Rolling::none)
      p.fail("rolling_friction", "has no effect without contact.rolling");
    if (p.has("rolling_damping") && c.rolling != Rolling::epsd)
      p.fail("rolling_damping", "has no effect without contact.rolling = epsd");
    if (p.has("twisting_damping") && !c.twisting)
      p.fail("twisting_damping", "has no effect without twisting_friction > 0");
    if (p.has("cohesion_energy") && c.cohesion == Cohesion::none)
      p.fail("cohesion_energy", "has no effect without contact.cohesion");
    if (p.has("work_of_adhesion") && c.model != ContactModel::jkr)
      p.fail("work_of_adhesion", "has no effect without contact.model = jkr");
  }
}

void read_contact(const SceneTable& r, const std::vector<SceneTable>& pairs, const std::vector<SceneTable>& materials,
                  const std::vector<std::string>& names, Scene& scene) {
  ContactLaw& c = scene.contact;
  c.model = r.choice<ContactModel>("model");
  c.dashpot = r.choice<Dashpot>("dashpot");
  c.lever = r.choice<Lever>("lever");
  c.sliding = r.choice<Sliding>("sliding");
  c.friction_limit = r.choice<FrictionLimit>("friction_limit");
  c.onset_correction = r.boolean("onset_correction");
  c.clip_tension = r.boolean("clip_tension");
  c.partial_slip = r.boolean("partial_slip");
  c.synchronised = r.boolean("synchronised");

  const std::size_t n = names.size();
  c.rolling = r.choice<Rolling>("rolling");
  c.cohesion = r.choice<Cohesion>("cohesion");
  PairCoefficients general{read_friction(r, 0), r.number_or("restitution", -1)};
  general.rolling_damping = c.rolling == Rolling::epsd ? r.number("rolling_damping") : 0;
  general.twisting_damping = r.number("twisting_damping");
  read_add_ons(r, general);
  scene.pairs.assign(n * n, general);
  bool any_restitution = r.has("restitution");
  std::vector<char> seen(n * n);
  for (const SceneTable& p : pairs) {
    const auto a = static_cast<std::size_t>(p.index("materials", names, "material", 0));
    const auto b = static_cast<std::size_t>(p.index("materials", names, "material", 1));
    if (seen[a * n + b]) p.fail("materials", "this pair is given twice");
    seen[a * n + b] = seen[b * n + a] = 1;
    PairCoefficients& k = scene.pairs[a * n + b];
    k.friction = read_friction(p, k.friction);
    k.restitution = p.number_or("restitution", k.restitution);
    any_restitution = any_restitution || p.has("restitution");
    read_add_ons(p, k);
    if (p.has("restitution") && r.has("normal_damping"))
      p.fail("restitution", "contradicts 'contact.normal_damping'; give one of the two");
    scene.pairs[b * n + a] = k;
  }
  c.friction = false;
  for (const PairCoefficients& k : scene.pairs) c.friction = c.friction || k.friction > 0;
  check_add_ons(r, pairs, scene);
  if (c.partial_slip && !c.friction) r.fail("partial_slip", "has no effect without contact.friction > 0");
  if (c.clip_tension && (c.model == ContactModel::jkr || c.cohesion != Cohesion::none))
    r.fail("clip_tension", "contradicts adhesion and cohesion, which pull");
  if (c.clip_tension && c.model == ContactModel::hertz_tsuji)
    r.fail("clip_tension",
           "Tsuji's polynomial holds for contacts that end with their overlap: use model = hertz_mindlin");

  if (c.model == ContactModel::linear) {
    r.require("normal_stiffness", "by contact.model = linear");
    r.exclusive("restitution", "normal_damping");
    c.normal_stiffness = r.number("normal_stiffness");
    c.tangential_stiffness = r.number_or("tangential_stiffness", 2.0 / 7.0 * c.normal_stiffness);
    c.normal_damping = r.number("normal_damping");
    c.tangential_damping = r.number("tangential_damping");
    c.by_restitution = any_restitution;
  } else {
    for (const SceneTable& m : materials) {
      m.require("young", "by the Hertz models");
      m.require("poisson", "by the Hertz models");
    }
  }
  if (c.model != ContactModel::linear || c.by_restitution) {
    for (const PairCoefficients& k : scene.pairs) {
      if (k.restitution < 0) r.missing("restitution", "because some pair of materials has none of its own");
    }
  }
}

SizeDistribution read_size(const SceneTable& r) {
  SizeDistribution s;
  using Kind = SizeDistribution::Kind;
  s.kind = r.choice<Kind>("kind");
  const std::string why = "by kind = " + r.text("kind");
  s.by_mass = r.text("by") == "mass";
  switch (s.kind) {
    case Kind::constant:
      r.require("diameter", why);
      s.diameter = r.number("diameter");
      break;
    case Kind::normal:
    case Kind::lognormal:
      r.require("mean", why);
      r.require("stddev", why);
      s.mean = r.number("mean");
      s.stddev = r.number("stddev");
      [[fallthrough]];
    case Kind::uniform:
      r.require("min", why);
      r.require("max", why);
      s.min = r.number("min");
      s.max = r.number("max");
      if (!(s.min <= s.max)) r.fail("max", "must not be below 'min'");
      if (s.kind != Kind::uniform && (s.mean + 6 * s.stddev < s.min || s.mean - 6 * s.stddev > s.max))
        r.fail("mean", "lies more than 6 standard deviations outside [min, max]");
      break;
    case Kind::sieve: {
      r.require("edges", why);
      r.require("weights", why);
      s.edges = r.numbers("edges");
      s.weights = r.numbers("weights");
      if (s.weights.empty() || s.edges.size() != s.weights.size() + 1)
        r.fail("edges", fmt::format("must have one entry more than 'weights' ({})", s.weights.size()));
      double sum = 0;
      for (std::size_t i = 0; i < s.weights.size(); ++i) {
        if (!(s.edges[i] < s.edges[i + 1])) r.fail("edges", "must ascend");
        sum += s.weights[i];
      }
      if (!(sum > 0)) r.fail("weights", "must not all be 0");
      break;
    }
  }
  return s;
}

Source read_source(const SceneTable& r, const Scene& scene, const std::vector<std::string>& materials,
                   const std::vector<std::string>& groups, std::vector<std::string>& names) {
  Source s;
  using Kind = Source::Kind;
  s.kind = r.choice<Kind>("kind");
  s.name = unique_name(r, fmt::format("source_{}", names.size()), names);
  if (r.has("material")) s.material = r.index("material", materials, "material");
  if (r.has("group")) s.group = r.index("group", groups, "group");
  if (s.kind == Kind::file) {
    r.require("file", "by kind = file");
    s.file = r.text("file");
    if (s.file.empty()) r.fail("file", "must not be empty");
    for (std::string_view unused : {"region", "size"}) {
      if (r.has(unused)) r.fail(unused, "has no effect with kind = file");
    }
    if (r.has("tile")) {
      const std::vector<std::int64_t> tile = r.integers("tile");
      for (std::size_t k = 0; k < 3; ++k) s.tile[k] = static_cast<int>(tile[k]);
    }
    return s;
  }
  const std::string why = "by kind = " + r.text("kind");
  r.require("region", why);
  r.require("size", why);
  s.region = read_region(r.section("region"), scene.domain, true);
  s.size = read_size(r.section("size"));
  s.velocity = r.vector("velocity");
  s.velocity_jitter = r.number("velocity_jitter");
  if (r.has("number")) s.number = r.integer("number");
  if (r.has("mass")) s.mass = r.number("mass");
  if (r.has("number") && s.number == 0) r.fail("number", "must be 1 or more; leave the key out for no limit");
  if (r.has("mass") && s.mass == 0) r.fail("mass", "must be > 0; leave the key out for no limit");
  s.spacing = r.number("spacing");
  s.lattice = r.choice<Source::Lattice>("lattice");
  s.start = r.number("start");
  s.end = r.number_or("end", k_never);
  if (!(s.end > s.start)) r.fail("end", "must be after 'start'");
  s.allow_wall_overlap = r.boolean("allow_wall_overlap");
  s.closed_walls = r.choice<Source::ClosedWalls>("closed_walls");
  if (s.kind == Kind::random && s.number == 0 && s.mass == 0) r.missing("number", "(or mass) by kind = random");
  if (s.kind == Kind::stream) {
    r.exclusive("number_rate", "mass_rate");
    if (!r.has("number_rate") && !r.has("mass_rate")) r.missing("number_rate", "(or mass_rate) by kind = stream");
    s.number_rate = r.number_or("number_rate", 0);
    s.mass_rate = r.number_or("mass_rate", 0);
    r.require("interval", why);
    s.interval = r.number("interval");
    if (s.interval < scene.dt) r.fail("interval", fmt::format("must be at least one time step ({:g})", scene.dt));
  }
  return s;
}

WallMotion read_motion(const SceneTable& r) {
  WallMotion m;
  m.velocity = r.vector("velocity");
  m.rotation_axis = r.direction("rotation_axis");
  m.rotation_rate = r.number("rotation_rate");
  m.rotation_origin = r.vector("rotation_origin");
  m.amplitude = r.vector("amplitude");
  m.frequency = r.number("frequency");
  m.phase = r.number("phase");
  m.start = r.number("start");
  m.end = r.number_or("end", k_never);
  if (!(m.end > m.start)) r.fail("end", "must be after 'start'");
  return m;
}

WallSpec read_wall(const SceneTable& r, const std::vector<std::string>& materials, std::vector<std::string>& names) {
  WallSpec w;
  w.name = unique_name(r, fmt::format("wall_{}", names.size()), names);
  w.shape = r.choice<WallShape>("shape");
  const std::string why = "by shape = " + r.text("shape");
  if (r.has("material")) w.material = r.index("material", materials, "material");
  w.point = r.vector("point");
  w.normal = r.direction("normal");
  w.axis = r.direction("axis");
  if (w.shape == WallShape::cylinder || w.shape == WallShape::cone) {
    r.require("length", why);
    r.require("radius", why);
    w.length = r.number("length");
    w.radius = r.number("radius");
    w.radius_end = w.radius;
    if (w.shape == WallShape::cylinder && w.radius == 0) r.fail("radius", "must be > 0 for a cylinder");
    if (w.shape == WallShape::cylinder && w.length == 0) r.fail("length", "must be > 0 for a cylinder");
  }
  if (w.shape == WallShape::cone) {
    r.require("radius_end", why);
    w.radius_end = r.number("radius_end");
    if (w.radius == 0 && w.radius_end == 0) r.fail("radius_end", "one of the two radii must be > 0");
    if (w.length == 0 && w.radius == w.radius_end)
      r.fail("radius_end", "a flat ring (length 0) needs two different radii");
  }
  if (w.shape == WallShape::box) {
    r.require("lower", why);
    r.require("upper", why);
    w.lower = r.vector("lower");
    w.upper = r.vector("upper");
    check_box(r, w.lower, w.upper);
  }
  if (w.shape == WallShape::mesh) {
    r.require("file", why);
    w.file = r.text("file");
    if (w.file.empty()) r.fail("file", "must not be empty");
    w.scale = r.number("scale");
    w.shift = r.vector("shift");
  }
  if (r.has("motion")) w.motion = read_motion(r.section("motion"));
  w.appear = r.number("appear");
  w.vanish = r.number_or("vanish", k_never);
  if (!(w.vanish > w.appear)) r.fail("vanish", "must be after 'appear'");
  return w;
}

GroupSpec read_group(const SceneTable& r, std::vector<std::string>& names) {
  GroupSpec g;
  g.name = unique_name(r, "", names);
  g.fixed_in_file = r.boolean("fixed_in_file");
  if (r.has("region")) g.region = read_region(r.section("region"));
  if (r.has("ids")) {
    const std::vector<std::int64_t> ids = r.integers("ids");
    g.ids = {ids[0], ids[1]};
  }
  if (g.ids && (g.region || g.fixed_in_file)) r.fail("ids", "a group has one rule: ids, region or fixed_in_file");
  if (g.region && g.fixed_in_file) r.fail("fixed_in_file", "a group has one rule: ids, region or fixed_in_file");
  return g;
}

Event read_event(const SceneTable& r, const std::vector<std::string>& groups) {
  Event e;
  e.time = r.number("time");
  e.action = r.choice<Event::Action>("action");
  const std::string why = "by action = " + r.text("action");
  if (e.action == Event::Action::gravity) {
    r.require("gravity", why);
    e.vector = r.vector("gravity");
    return e;
  }
  r.require("group", why);
  e.group = r.index("group", groups, "group");
  e.vector = r.vector("velocity");
  e.spin = r.vector("spin");
  return e;
}

ListSettings read_list(const SceneTable& r, const Scene& scene) {
  ListSettings l;
  l.policy = r.has("policy") ? r.choice<ListPolicy>("policy") : scene.fitting_policy();
  const bool paper = l.policy == ListPolicy::paper;
  const std::optional<double> k = r.number_or_text("verlet_k");
  l.automatic = !k.has_value();
  l.verlet_k = k.value_or(l.verlet_k);
  l.interval = r.integer("interval");
  if (l.policy == ListPolicy::fixed && l.interval < 1)
    r.fail("interval", "policy fixed needs the number of steps between two rebuilds");
  l.floor = r.number_or("floor", paper ? 0 : l.floor);
  l.floor_on = l.floor > 0;
  l.acceleration_on = r.has("acceleration") ? r.boolean("acceleration") : !paper;
  l.cap_on = r.boolean("cap");
  l.uniform_skin = r.number("uniform_skin");
  l.outer = r.number("outer");
  l.cell_factor = r.number("cell_factor");
  if (l.cell_factor != 0 && l.cell_factor < 1) r.fail("cell_factor", "must be 0 (chosen by the policy) or at least 1");
  return l;
}

OutputSettings read_output(const SceneTable& r, const Domain& domain) {
  OutputSettings o;
  o.particles_every = r.number("particles_every");
  o.vtkhdf = r.boolean("vtkhdf");
  o.vtp = r.boolean("vtp");
  o.csv_every = r.number("csv_every");
  o.checkpoint_wall = r.number("checkpoint_wall");
  o.energies = r.boolean("energies");
  o.contacts = r.boolean("contacts");
  o.coordination = r.boolean("coordination");
  o.stress = r.boolean("stress");
  if (r.has("grid")) {
    o.grid.on = true;
    const std::vector<std::int64_t> cells = r.integers("grid");
    for (std::size_t k = 0; k < 3; ++k) o.grid.cells[k] = static_cast<int>(cells[k]);
  }
  std::vector<std::string> names;
  for (const SceneTable& p : r.sections("plane")) {
    o.flux_planes.push_back({unique_name(p, "", names), p.vector("point"), p.direction("normal")});
    if (!CountedPlane(domain, o.flux_planes.back()).meets())
      p.fail("point", "the plane lies outside of the domain, where grains never are");
  }
  names.clear();
  for (const SceneTable& p : r.sections("region"))
    o.regions.push_back({unique_name(p, "", names), read_region(p, domain, false)});
  return o;
}

}  // namespace

Scene parse_scene(std::string_view text, std::string name, std::string directory,
                  const std::vector<std::string>& overrides) {
  Scene scene;
  const SceneTable root = SceneTable::parse(text, name, overrides);
  scene.file = std::move(name);
  scene.directory = std::move(directory);
  scene.title = root.text("title");
  scene.seed = static_cast<std::uint64_t>(root.integer("seed"));
  scene.gravity = root.vector("gravity");
  scene.integrator = root.choice<Integrator>("integrator");
  scene.precision = root.choice<Precision>("precision");
  scene.sort_every = root.integer("sort_every");

  read_time(root.section("time"), scene);
  const std::vector<SceneTable> materials = root.sections("material");
  const std::vector<std::string> material_names = read_materials(materials, scene, root);
  read_domain(root.section("domain"), scene, material_names);
  const SceneTable damping = root.section("damping");
  scene.viscous_damping = damping.number("viscous");
  scene.local_damping = damping.number("local");
  read_contact(root.section("contact"), root.sections("pair"), materials, material_names, scene);

  std::vector<std::string> group_names, names;
  for (const SceneTable& r : root.sections("group")) scene.groups.push_back(read_group(r, group_names));
  for (const SceneTable& r : root.sections("source"))
    scene.sources.push_back(read_source(r, scene, material_names, group_names, names));
  names.clear();
  for (const SceneTable& r : root.sections("wall")) scene.walls.push_back(read_wall(r, material_names, names));
  for (const SceneTable& r : root.sections("event")) scene.events.push_back(read_event(r, group_names));
  scene.list = read_list(root.section("list"), scene);
  scene.output = read_output(root.section("output"), scene.domain);
  const SceneTable checks = root.section("checks");
  scene.max_overlap = checks.number("max_overlap");
  scene.allow_initial_overlap = checks.boolean("allow_initial_overlap");
  scene.allow_unstable_step = checks.boolean("allow_unstable_step");
  MonitorSettings& monitor = scene.monitor;
  monitor.warn_overlap = checks.number("warn_overlap");
  monitor.warn_travel = checks.number("warn_travel");
  monitor.max_travel = checks.number("max_travel");
  monitor.warn_stiffness = checks.number("warn_stiffness");
  monitor.warn_energy = checks.number("warn_energy");
  if (checks.has("max_energy")) monitor.max_energy = checks.number("max_energy");
  const SceneTable relax = root.section("relax");
  scene.relax.steps = relax.integer("steps");
  scene.relax.displacement = relax.number("displacement");
  return scene;
}

std::string read_scene_file(const std::string& path) {
  return read_input_text(path, {ErrorCode::scene, "scene file", k_most_bytes, "give the path of a TOML scene file"});
}

std::string scene_directory(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  return slash == std::string::npos ? "." : path.substr(0, slash + 1);
}

Scene load_scene(const std::string& path, const std::vector<std::string>& overrides) {
  Scene scene = parse_scene(read_scene_file(path), path, scene_directory(path), overrides);
  load_regions(scene);
  return scene;
}

}  // namespace talus
