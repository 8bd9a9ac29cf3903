// Scene: everything that determines a trajectory, as parsed and validated from a scene file. Plain data, SI units
// (any consistent unit system works). Filled by core/scene/scene_file.cpp or by tests; read by scheduler/ and cases/.
// Invariant: a trajectory is a function of this struct alone, except for the members of RunOptions (DESIGN 1).
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/box.hpp"
#include "core/base/types.hpp"
#include "core/base/words.hpp"
#include "core/scene/conversion.hpp"
#include "core/scene/gas_settings.hpp"
#include "core/scene/heat.hpp"

namespace talus {

inline constexpr double k_never = std::numeric_limits<double>::infinity();

TALUS_WORDS(Boundary, periodic, open, wall)
TALUS_WORDS(ContactModel, linear, hertz_mindlin, hertz_tsuji, jkr)
TALUS_WORDS(Rolling, none, cdt, epsd)
TALUS_WORDS(Cohesion, none, sjkr)
/// Velocity in the dashpot: that at n with the forces of all contacts, that at n with the force of the pair alone, that
/// at n-1/2 (kernels/models/linear.hpp).
TALUS_WORDS(Dashpot, centred, pairwise, lagged)
TALUS_WORDS(Lever, contact, radius)
TALUS_WORDS(Sliding, series, balanced)
/// Normal force in Coulomb's limit: its elastic part, or all of it where it pushes.
TALUS_WORDS(FrictionLimit, elastic, total)
TALUS_WORDS(Integrator, velocity_verlet, leapfrog)
/// exact: the same bits on every instruction set. fast: fused multiply-add and estimated reciprocals; the bits depend
/// on the instruction set and on whether energies are summed (another kernel, fused otherwise), on nothing else.
TALUS_WORDS(Precision, exact, fast)
TALUS_WORDS(ListPolicy, always, paper, local, uniform, two_largest, accumulated, global_velocity, neighbourhood,
            mean_subtracted, velocity_profile, displacement_history, outer_inner, fixed)
enum class Isa : std::uint8_t { automatic, scalar, sse2, avx2, avx512 };

/// Computational box [m]; a periodic axis has both sides periodic.
struct Domain {
  Vec3 lower{0, 0, 0}, upper{1, 1, 1};
  std::array<std::array<Boundary, 2>, 3> boundary{
      {{Boundary::wall, Boundary::wall}, {Boundary::wall, Boundary::wall}, {Boundary::wall, Boundary::wall}}};
  int wall_material = 0;
  bool periodic(int axis) const noexcept { return boundary[axis][0] == Boundary::periodic; }
  Box box() const noexcept { return {upper - lower, {periodic(0), periodic(1), periodic(2)}}; }
};

struct Material {
  std::string name;
  double density = 2500;          ///< [kg/m3]
  double young = 0, poisson = 0;  ///< [Pa], [-]; Hertz models only
};

/// Coefficients of one (unordered) material pair; scene.pair(a, b) is symmetric.
struct PairCoefficients {
  double friction = 0;           ///< Coulomb coefficient [-]
  double restitution = -1;       ///< normal restitution in (0, 1]; -1 where the damping rate is given instead
  double rolling_friction = 0;   ///< mu_r [-]: moment <= mu_r R* F_n
  double rolling_damping = 0;    ///< eta_r [-]: share of critical damping of the rolling spring (epsd)
  double twisting_friction = 0;  ///< mu_t [-]: moment about the normal <= mu_t R* F_n
  double twisting_damping = 0;   ///< share of critical damping of the twisting spring
  double cohesion_energy = 0;    ///< sjkr: energy density [J/m3]
  double work_of_adhesion = 0;   ///< jkr: w = 2 gamma of like surfaces [J/m2]
};

/// Contact law of the scene. Linear: stiffnesses [N/m] with either damping rates [1/s] (force = rate*m_eff*v, as LAMMPS
/// gran/hooke/history) or restitution. Hertz-Mindlin: elastic constants come from the materials.
struct ContactLaw {
  ContactModel model = ContactModel::linear;
  bool friction = true;             ///< false: no tangential force, no history, no rotation
  double normal_stiffness = 0;      ///< linear [N/m]
  double tangential_stiffness = 0;  ///< linear [N/m]
  bool by_restitution = false;      ///< linear: damping from pair restitution instead of rates
  double normal_damping = 0;        ///< linear [1/s]
  double tangential_damping = 0;    ///< linear [1/s]
  Dashpot dashpot = Dashpot::centred;
  bool onset_correction = true;  ///< weigh the linear dashpot by the touching fraction of the first and last step
  bool clip_tension = false;     ///< the normal force never pulls; restitution is that of clipped impacts
  bool synchronised = true;      ///< tangential history in the mid-step frame (VERIFICATION 3.8)
  Lever lever = Lever::contact;
  Sliding sliding = Sliding::series;  ///< what the spring of a sliding contact keeps (kernels/models/linear.hpp)
  FrictionLimit friction_limit = FrictionLimit::elastic;
  bool partial_slip = false;           ///< Hertz: rings of the contact area slide on their own; needs friction
  Rolling rolling = Rolling::none;     ///< needs friction (grains must rotate)
  bool twisting = false;               ///< some pair has twisting friction; needs friction
  Cohesion cohesion = Cohesion::none;  ///< on top of linear or Hertz
};

/// Size distribution of spheres, always stated in diameters [m].
struct SizeDistribution {
  TALUS_MEMBER_WORDS(Kind, constant, uniform, normal, lognormal, sieve)
  Kind kind = Kind::constant;
  bool by_mass = false;              ///< weights count mass, not number
  double diameter = 0;               ///< constant
  double min = 0, max = 0;           ///< uniform; truncation of normal and lognormal
  double mean = 0, stddev = 0;       ///< normal: of d; lognormal: mean and standard deviation of d (not of ln d)
  std::vector<double> edges;         ///< sieve: n+1 ascending diameters
  std::vector<double> weights;       ///< sieve: n class weights
  double smallest() const noexcept;  ///< lower bound of the support [m]
  double largest() const noexcept;   ///< upper bound of the support [m]
};

class ClosedSurface;

/// Part of space within the box [lower, upper] [m]; what lies in it is decided in core/grains/region.hpp. box: all of
/// the box or, where radius > 0, the upright cylinder about its middle. cylinder: of the radius about the line from
/// `point` to `point + length * axis`. sphere: of the radius about `point`. mesh: what the surface encloses.
struct Region {
  TALUS_MEMBER_WORDS(Shape, box, cylinder, sphere, mesh)
  Vec3 lower, upper;  ///< bounds of every shape
  double radius = 0;
  Shape shape = Shape::box;
  Vec3 point{}, axis{0, 0, 1};  ///< axis: unit
  double length = 0;
  std::string file{};  ///< mesh: STL, OBJ, PLY; scaled and shifted like that of a wall
  double scale = 1;
  Vec3 shift{};
  std::shared_ptr<const ClosedSurface> surface{};  ///< mesh: set when the file is read (load_region)
};

struct BodyShape;

/// A body that is no sphere. clump: spheres that move as one; where they overlap, its matter counts once. superquadric:
/// (|x/a|^n2 + |y/b|^n2)^(n1/n2) + |z/c|^n1 = 1. Lengths at scale 1; a source says how large its bodies are.
struct ShapeSpec {
  TALUS_MEMBER_WORDS(Kind, clump, superquadric)
  Kind kind = Kind::clump;
  std::string name;
  std::vector<double> spheres;            ///< x, y, z, radius of each [m]; empty: file
  std::string file;                       ///< table of particles
  Vec3 axes;                              ///< semi-axes a, b, c of a superquadric [m]
  std::vector<double> exponents;          ///< n1, n2; empty: 2, 2
  double density = 0;                     ///< [kg/m3]; 0: that of the material
  double mass = 0;                        ///< [kg]; 0: density
  Vec3 centre;                            ///< of mass [m], where it is given
  bool off_centre = false;                ///< it is
  std::vector<double> inertia;            ///< about it: xx, yy, zz, xy, xz, yz [kg m2]; empty: of the union
  std::shared_ptr<const BodyShape> body;  ///< set by load_shapes()
};

/// Source of particles. file: at step 0. lattice/random: once at time `start`. stream: batches every `interval` from
/// start to end, number or mass rate given. Batches are non-overlapping with everything present.
struct Source {
  TALUS_MEMBER_WORDS(Kind, file, lattice, random, stream)
  Kind kind = Kind::random;
  std::string name;
  std::string file;                  ///< CSV (optionally .gz) or LAMMPS data file
  std::array<int, 3> tile{1, 1, 1};  ///< the file fills the first of so many equal parts of the domain and is repeated
  Region region;
  SizeDistribution size;
  int material = 0;
  Vec3 velocity;                          ///< [m/s]
  double tracer = 0;                      ///< of its grains (scheduler/parts/tracer.cpp) [-]
  double velocity_jitter = 0;             ///< uniform random in [-j, j] per axis [m/s]
  std::int64_t number = 0;                ///< particles in total (0: not limited by number)
  double mass = 0;                        ///< in total [kg] (0: not limited by mass)
  double number_rate = 0, mass_rate = 0;  ///< stream [1/s], [kg/s]
  double interval = 0;                    ///< stream: time between batches [s]
  double spacing = 1.05;                  ///< lattice: pitch / largest diameter
  TALUS_MEMBER_WORDS(Lattice, hexagonal, cubic)
  Lattice lattice = Lattice::hexagonal;
  double start = 0, end = k_never;  ///< [s]
  int group = -1;                   ///< index into groups, or -1
  bool allow_wall_overlap = false;  ///< grains may be placed into walls
  /// Where grains go with respect to closed walls (boxes and watertight meshes).
  TALUS_MEMBER_WORDS(ClosedWalls, both, outside, inside)
  ClosedWalls closed_walls = ClosedWalls::both;
  int shape = -1;  ///< index into shapes; -1: spheres
  /// How its bodies lie when they come. random: all turns alike; aligned: the z axis of the shape along
  /// orientation_axis; axis: the same, turned about it at random.
  TALUS_MEMBER_WORDS(Orientation, random, aligned, axis)
  Orientation orientation = Orientation::random;
  Vec3 orientation_axis{0, 0, 1};  ///< unit
};

TALUS_WORDS(WallShape, plane, cylinder, cone, box, mesh)

/// Rigid motion of a wall within [start, end): velocity, rotation about `origin`, sinusoidal vibration. The pose is a
/// function of the step number, never accumulated (DESIGN I4).
struct WallMotion {
  Vec3 velocity;  ///< [m/s]
  Vec3 rotation_axis{0, 0, 1};
  double rotation_rate = 0;  ///< [rad/s]
  Vec3 rotation_origin;
  Vec3 amplitude;                   ///< vibration displacement amplitude [m]
  double frequency = 0;             ///< [Hz]
  double phase = 0;                 ///< [turns]
  double start = 0, end = k_never;  ///< [s]
  bool any() const noexcept {
    return norm2(velocity) > 0 || rotation_rate != 0 || (norm2(amplitude) > 0 && frequency != 0);
  }
};

/// plane: point, normal (pointing to the particle side; two-sided contact). cylinder: lateral surface between `point`
/// and `point + length*axis`, radius. cone: radius at point, radius_end at the other end. box: six faces as a closed
/// surface, lower/upper. mesh: file (STL, OBJ, PLY) scaled and shifted, then seen from `corner`.
struct WallSpec {
  std::string name;
  WallShape shape = WallShape::plane;
  int material = 0;
  Vec3 point, normal{0, 0, 1};
  Vec3 axis{0, 0, 1};
  double length = 0, radius = 0, radius_end = 0;
  Vec3 lower, upper;
  std::string file;
  double scale = 1;
  Vec3 shift;
  Vec3 corner;  ///< of the frame of the stored positions (in_stored_frame); not a key of the scene
  WallMotion motion;
  double appear = 0, vanish = k_never;  ///< the wall acts within [appear, vanish) [s]
};

/// Named set of particles: by source, region at step 0, id range or a `fixed` flag of the initial file.
struct GroupSpec {
  std::string name;
  bool fixed_in_file = false;
  std::optional<Region> region;                  ///< selects at the time of the event
  std::optional<std::array<ParticleId, 2>> ids;  ///< inclusive
};

/// Action at a time, executed before the drift of step round(time/step).
struct Event {
  TALUS_MEMBER_WORDS(Action, freeze, release, set_velocity, remove, gravity, drive)
  Action action = Action::freeze;
  double time = 0;
  int group = -1;
  Vec3 vector;  ///< set_velocity, drive [m/s]; gravity [m/s2]
  Vec3 spin;    ///< drive, set_velocity [rad/s]
};

/// List parameters; none of them changes the trajectory (but for policy fixed, which may miss contacts).
struct ListSettings {
  ListPolicy policy = ListPolicy::local;
  double verlet_k = 200;      ///< K in skin = K |v| dt; does not count where the run chooses K
  bool automatic = true;      ///< K and floor are chosen while the run goes (scheduler/lists/tuner.hpp)
  std::int64_t interval = 0;  ///< policy fixed: steps between rebuilds
  bool floor_on = true, acceleration_on = true, cap_on = true;
  double floor = 0.02;        ///< of the particle diameter
  double uniform_skin = 1.0;  ///< of the smallest radius
  double outer = 3;           ///< policy outer_inner: skins of the outer list / those of the inner one
  double cell_factor = 0;     ///< cell edge / minimum; 0 = chosen by policy
};

/// Levels of the run-time monitor (scheduler/nodes/monitor.hpp). A warning changes nothing; a stop is a function of the
/// trajectory, like everything else that ends a run.
struct MonitorSettings {
  double warn_overlap = 0.1;    ///< overlap / smaller radius
  double warn_travel = 0.1;     ///< travel per step / radius
  double max_travel = 1;        ///< the same, stops: beyond it a wall can be crossed unseen
  double warn_stiffness = 6;    ///< dt^2 * (sum of the stiffnesses of its contacts / mass) of a particle, and more
  double warn_energy = 0.1;     ///< |energy balance residual| / energy turned over so far; needs output.energies
  double max_energy = k_never;  ///< the same, stops
};

/// Limited-velocity relaxation of an overlapping start: in the first `steps` steps (0: off) particles follow their
/// contact forces without gravity, friction or inertia, each by at most `displacement` of its radius per step.
struct RelaxSettings {
  std::int64_t steps = 0;
  double displacement = 0.02;
};

struct OutputSettings {
  double particles_every = 0;  ///< [s] of simulated time; 0 = off
  bool vtkhdf = false, vtp = true;
  double csv_every = 0;          ///< [s]; 0 = off
  double checkpoint_wall = 300;  ///< wall time between checkpoints [s]; 0 = only at the end
  bool energies = false;
  bool contacts = false;  ///< contact file per frame
  bool coordination = false, stress = false;
  struct Grid {
    bool on = false;
    std::array<int, 3> cells{0, 0, 0};
  } grid;
  struct Plane {
    std::string name;
    Vec3 point, normal{0, 0, 1};
  };
  std::vector<Plane> flux_planes;
  struct Average {
    std::string name;
    Region region;
  };
  std::vector<Average> regions;
};

struct Scene {
  std::string title, file, directory;  ///< directory: base for relative paths
  std::uint64_t seed = 1;
  Domain domain;
  double dt = 0;  ///< [s]
  std::int64_t steps = 0;
  Vec3 gravity;  ///< [m/s2]
  Integrator integrator = Integrator::velocity_verlet;
  Precision precision = Precision::exact;
  double viscous_damping = 0;  ///< background, 1/s: a = -c v
  double local_damping = 0;    ///< non-viscous (Cundall) coefficient [-]
  std::vector<Material> materials;
  ContactLaw contact;
  std::vector<PairCoefficients> pairs;  ///< n*n, symmetric
  std::vector<ShapeSpec> shapes;
  std::vector<Source> sources;
  std::vector<WallSpec> walls;
  std::vector<GroupSpec> groups;
  std::vector<Event> events;
  ListSettings list;
  OutputSettings output;
  std::int64_t sort_every = 1000;      ///< steps between sort epochs (part of the trajectory, DESIGN I3)
  double max_overlap = 0.5;            ///< of the smaller radius; more stops the run (I9)
  bool allow_initial_overlap = false;  ///< accept initial overlaps up to max_overlap
  bool allow_unstable_step = false;
  MonitorSettings monitor;
  RelaxSettings relax;
  double tracer_rate = -1;  ///< at which a contact mixes the tracer [1/s]; negative: no tracer
  ConversionScene conversion;
  HeatScene heat;
  GasSettings gas;  ///< in the voids between the grains (scheduler/parts/gas.cpp)

  const PairCoefficients& pair(int a, int b) const { return pairs[a * materials.size() + b]; }
  /// List policy for a scene that names none: velocity_profile where gravity has a component along a periodic axis,
  /// some axis is open and there is no wall (a dense flow shares its mean velocity: 6 to 8 % of the run time), else
  /// local (perf/policies.md).
  ListPolicy fitting_policy() const noexcept;
};

/// Radii of grains change while they move.
inline bool changes_sizes(const Scene& s) {
  for (const MatterHeat& m : s.heat.matter)
    if (m.expansion != 0) return true;
  return s.conversion.on && s.conversion.resize;
}

/// How a scene is executed; never changes a result (DESIGN I8).
struct RunOptions {
  int threads = 0;  ///< 0: all cores the process may use
  Isa isa = Isa::automatic;
  int chunk = 0;  ///< particles per chunk; 0: by N and threads
  bool profile = false;
  bool audit = false;  ///< brute-force check of the list at every step (small N)
};

}  // namespace talus
