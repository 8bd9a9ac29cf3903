// The table itself, and the help made from it.
#include "core/scene/scene_keys.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.hpp"
#include "core/scene/scene_suggest.hpp"

namespace talus {
namespace {

using T = KeyType;
constexpr double k_big = 1e30;     // beyond every physical quantity, still far from overflow of products
constexpr double k_length = 1e12;  // coordinates: cell indices of such a box still fit 64 bits
constexpr double k_count = 1e12;

constexpr SceneSection k_sections[] = {
    {"", false, "keys at the top of the file, before the first section"},
    {"domain", false, "computational box and what its sides do"},
    {"time", false, "time step and length of the run (steps or duration)"},
    {"damping", false, "background damping of all particles"},
    {"material", true, "a material; at least one"},
    {"contact", false, "contact law and its coefficients for all pairs of materials"},
    {"pair", true, "coefficients of one pair of materials, in place of those of [contact]"},
    {"source", true, "where particles come from"},
    {"source.region", false, "box, cylinder, sphere or inside of a mesh that a source fills"},
    {"source.size", false, "distribution of particle diameters of a source"},
    {"wall", true, "a rigid wall"},
    {"wall.motion", false, "motion of a wall within [start, end)"},
    {"group", true, "a named set of particles, for events"},
    {"group.region", false, "part of space that selects the group's particles at the time of an event"},
    {"event", true, "an action at a time"},
    {"list", false, "neighbour list; never changes a trajectory"},
    {"output", false, "what is written, and how often"},
    {"output.plane", true, "a plane through which passages of grains are counted in every step, in number and mass"},
    {"output.region", true, "a region over which averages are taken"},
    {"checks", false, "limits that warn or stop a run, and permissions to ignore them"},
    {"relax", false, "limited-velocity relaxation of initial overlaps; off unless steps is given"},
};

// Keys of every section that describes a part of space.
// clang-format off
#define TALUS_REGION_KEYS(section)                                                                                    \
  {section, "shape", T::choice, "", 0, 0, false, "box|cylinder|sphere|mesh", "\"box\"", "",                           \
   "box, cylinder about any axis, sphere, or the inside of a watertight mesh", "\"box\""},                            \
  {section, "lower", T::vector, "m", -k_length, k_length, false, "", "(required by box)", "shape=box",                 \
   "lower corner", "[0.1, 0.1, 0.1]"},                                                                                 \
  {section, "upper", T::vector, "m", -k_length, k_length, false, "", "(required by box)", "shape=box",                 \
   "upper corner", "[0.9, 0.9, 0.9]"},                                                                                 \
  {section, "radius", T::number, "m", 0, k_length, true, "", "(required by cylinder and sphere; a box needs none)",    \
   "shape=box|cylinder|sphere", "makes a box the upright cylinder about its middle", "0.3"},                           \
  {section, "point", T::vector, "m", -k_length, k_length, false, "", "(required by cylinder)", "shape=cylinder",       \
   "centre of the first end of the cylinder", "[0.5, 0.5, 0.5]"},                                                      \
  {section, "axis", T::vector, "-", -k_big, k_big, false, "", "[0, 0, 1]", "shape=cylinder",                           \
   "direction from the first end to the other", "[0, 1, 0]"},                                                          \
  {section, "length", T::number, "m", 0, k_length, true, "", "(this or end)", "shape=cylinder",                        \
   "distance of the two ends", "0.2"},                                                                                 \
  {section, "end", T::vector, "m", -k_length, k_length, false, "", "(this or axis and length)", "shape=cylinder",      \
   "centre of the other end", "[0.5, 0.5, 0.8]"},                                                                      \
  {section, "centre", T::vector, "m", -k_length, k_length, false, "", "(required by sphere)", "shape=sphere",          \
   "centre of the sphere", "[0.5, 0.5, 0.5]"},                                                                         \
  {section, "file", T::text, "", 0, 0, false, "", "(required by mesh)", "shape=mesh",                                  \
   "STL, OBJ or PLY file without holes, relative to the scene", "\"drum.stl\""},                                      \
  {section, "scale", T::number, "-", 0, k_big, true, "", "1", "shape=mesh", "factor on the file's coordinates",        \
   "0.001"},                                                                                                           \
  {section, "shift", T::vector, "m", -k_length, k_length, false, "", "[0, 0, 0]", "shape=mesh",                        \
   "added after scaling", "[0, 0, 0.1]"}
// clang-format on

// section, name, type, unit, low, high, low_open, choices, fallback, only, doc, example
constexpr SceneKey k_keys[] = {
    {"", "title", T::text, "", 0, 0, false, "", "\"\"", "", "a line for reports", "\"Hopper, 20k spheres\""},
    {"", "seed", T::integer, "-", 0, 9.2e18, false, "", "1", "", "seed of all random numbers", "42"},
    {"", "gravity", T::vector, "m/s2", -k_big, k_big, false, "", "[0, 0, 0]", "", "acceleration of gravity",
     "[0, 0, -9.81]"},
    {"", "integrator", T::choice, "", 0, 0, false, "velocity_verlet|leapfrog", "\"velocity_verlet\"", "",
     "time integration", "\"leapfrog\""},
    {"", "precision", T::choice, "", 0, 0, false, "exact|fast", "\"exact\"", "",
     "exact: same bits on every processor; fast: fused and estimated operations, bits depend on the instruction set",
     "\"fast\""},
    {"", "sort_every", T::integer, "steps", 1, k_count, false, "", "1000", "",
     "steps between two sorts of the storage order (part of the trajectory's definition)", "500"},

    {"domain", "lower", T::vector, "m", -k_length, k_length, false, "", "required", "", "lower corner of the box",
     "[0, 0, 0]"},
    {"domain", "upper", T::vector, "m", -k_length, k_length, false, "", "required", "",
     "upper corner of the box, above the lower one on every axis", "[1, 1, 2]"},
    {"domain", "boundary", T::boundary, "", 0, 0, false, "periodic|open|wall", "\"wall\"", "",
     "what the sides do: one word, or one entry per axis, each a word or a pair [lower, upper]; open deletes particles",
     "[\"periodic\", \"periodic\", [\"wall\", \"open\"]]"},
    {"domain", "wall_material", T::text, "", 0, 0, false, "", "(the first material)", "",
     "material of those sides that are walls", "\"steel\""},

    {"time", "step", T::number, "s", 0, k_big, true, "", "required", "", "time step", "1e-5"},
    {"time", "steps", T::integer, "steps", 0, k_count, false, "", "(from duration)", "",
     "length of the run in steps; either this or duration", "20000"},
    {"time", "duration", T::number, "s", 0, k_big, false, "", "(from steps)", "",
     "length of the run, rounded to whole steps; either this or steps", "0.5"},

    {"damping", "viscous", T::number, "1/s", 0, k_big, false, "", "0", "", "background drag c in a = -c v", "0.1"},
    {"damping", "local", T::number, "-", 0, 1, false, "", "0", "",
     "non-viscous damping: share of the force taken off where it speeds a particle up, added where it slows it down",
     "0.3"},

    {"material", "name", T::text, "", 0, 0, false, "", "required", "", "unique name", "\"glass\""},
    {"material", "density", T::number, "kg/m3", 0, k_big, true, "", "required", "", "density of the solid", "2500"},
    {"material", "young", T::number, "Pa", 0, k_big, true, "", "(required by the Hertz models)", "", "Young's modulus",
     "5e7"},
    {"material", "poisson", T::number, "-", 0, 0.5, false, "", "(required by the Hertz models)", "", "Poisson's ratio",
     "0.25"},

    {"contact", "model", T::choice, "", 0, 0, false, "linear|hertz_mindlin|hertz_tsuji|jkr", "\"linear\"", "",
     "linear: spring and dashpot; hertz_mindlin: restitution exact; hertz_tsuji: Tsuji's damping polynomial; jkr: "
     "adhesive hertz_mindlin",
     "\"linear\""},
    {"contact", "friction", T::number_or_none, "-", 0, 1e6, false, "", "\"none\"", "",
     "Coulomb coefficient; none or 0 for all pairs: no tangential force, history or rotation", "0.5"},
    {"contact", "restitution", T::number, "-", 0, 1, true, "", "(none; the Hertz models require it)", "",
     "normal restitution; either this or normal_damping", "0.8"},
    {"contact", "normal_stiffness", T::number, "N/m", 0, k_big, true, "", "(required by linear)", "model=linear",
     "spring in normal direction", "1e5"},
    {"contact", "tangential_stiffness", T::number, "N/m", 0, k_big, false, "", "(2/7 of normal_stiffness)",
     "model=linear", "spring in tangential direction", "3e4"},
    {"contact", "normal_damping", T::number, "1/s", 0, k_big, false, "", "0", "model=linear",
     "normal damping rate g: force = g m_eff v; either this or restitution", "50"},
    {"contact", "tangential_damping", T::number, "1/s", 0, k_big, false, "", "0", "model=linear",
     "tangential damping rate g: force = g m_eff v", "25"},
    {"contact", "dashpot", T::choice, "", 0, 0, false, "centred|pairwise|lagged", "\"centred\"", "",
     "velocity in the dashpot: centred in time (second order), the same with the forces of the pair alone (second "
     "order in impacts, soft at rest under load), or of the last half step (first order, as other codes)",
     "\"lagged\""},
    {"contact", "onset_correction", T::boolean, "", 0, 0, false, "", "true", "",
     "weigh the dashpot by the touching fraction of the first and last step of a contact", "false"},
    {"contact", "clip_tension", T::boolean, "", 0, 0, false, "", "false", "model=linear|hertz_mindlin",
     "the normal force never pulls (the dashpot would, towards the end of a contact); damping from a restitution is "
     "chosen so that clipped impacts have it",
     "true"},
    {"contact", "synchronised", T::boolean, "", 0, 0, false, "", "true", "",
     "tangential history in the mid-step frame: no sticking at large size ratios", "false"},
    {"contact", "lever", T::choice, "", 0, 0, false, "contact|radius", "\"contact\"", "",
     "lever of the tangential force: to the contact point (conserves angular momentum) or the full radius",
     "\"radius\""},
    {"contact", "sliding", T::choice, "", 0, 0, false, "series|balanced", "\"series\"", "model=linear",
     "tangential spring of a sliding contact; series: spring and dashpot side by side, in series with the slider "
     "(converges with the step, never yields energy); balanced: the scaled force less the dashpot (may load the spring "
     "backwards, as LAMMPS)",
     "\"balanced\""},
    {"contact", "friction_limit", T::choice, "", 0, 0, false, "elastic|total", "\"elastic\"", "",
     "normal force N in |F_t| <= mu N; elastic: without the dashpot's part, which sums to nothing over an impact, so "
     "that a sliding impact has the impulse J_t = mu J_n; total: max(F_n, 0), as other codes, which takes more than mu "
     "J_n where the dashpot pulls; with clip_tension always total",
     "\"total\""},
    {"contact", "partial_slip", T::boolean, "", 0, 0, false, "", "false", "model=hertz_mindlin|hertz_tsuji",
     "Mindlin's micro-slip: two rings of the contact area stick, slip and part each by itself, so that spins after "
     "impacts at small angles are within 10 % of finite elements (one spring for the whole contact, which shrinks with "
     "it: 45 %); needs friction; three more history columns per contact",
     "true"},
    {"contact", "rolling", T::choice, "", 0, 0, false, "none|cdt|epsd", "\"none\"", "",
     "rolling resistance; cdt: constant moment against the spin; epsd: spring, dashpot and slider (rests "
     "without creep)",
     "\"epsd\""},
    {"contact", "rolling_friction", T::number, "-", 0, 100, false, "", "0", "rolling=cdt|epsd",
     "mu_r in moment <= mu_r R* F_n", "0.1"},
    {"contact", "rolling_damping", T::number, "-", 0, 10, false, "", "0.3", "rolling=epsd",
     "damping ratio of the rolling spring; acts below the limit only", "0.5"},
    {"contact", "twisting_friction", T::number, "-", 0, 100, false, "", "0", "",
     "mu_t in moment about the normal <= mu_t R* F_n; 0 for all pairs: no twisting resistance", "0.05"},
    {"contact", "twisting_damping", T::number, "-", 0, 10, false, "", "0.3", "",
     "damping ratio of the twisting spring; acts below the limit only", "0.5"},
    {"contact", "cohesion", T::choice, "", 0, 0, false, "none|sjkr", "\"none\"",
     "model=linear|hertz_mindlin|hertz_tsuji", "sjkr: attraction = cohesion_energy * contact area, while in touch",
     "\"sjkr\""},
    {"contact", "cohesion_energy", T::number, "J/m3", 0, k_big, false, "", "0", "cohesion=sjkr",
     "cohesion energy density: attraction per contact area", "1e3"},
    {"contact", "work_of_adhesion", T::number, "J/m2", 0, k_big, false, "", "0", "model=jkr",
     "w of a pair of surfaces, 2 gamma of like ones; pull-off force 3/2 pi w R*", "0.05"},

    {"pair", "materials", T::text_pair, "", 0, 0, false, "", "required", "", "the two materials, in any order",
     "[\"glass\", \"steel\"]"},
    {"pair", "friction", T::number_or_none, "-", 0, 1e6, false, "", "(contact.friction)", "", "Coulomb coefficient",
     "0.3"},
    {"pair", "restitution", T::number, "-", 0, 1, true, "", "(contact.restitution)", "", "normal restitution", "0.7"},
    {"pair", "rolling_friction", T::number, "-", 0, 100, false, "", "(contact.rolling_friction)", "",
     "rolling friction; needs contact.rolling", "0.2"},
    {"pair", "rolling_damping", T::number, "-", 0, 10, false, "", "(contact.rolling_damping)", "",
     "damping ratio of the rolling spring; needs contact.rolling = epsd", "0.5"},
    {"pair", "twisting_friction", T::number, "-", 0, 100, false, "", "(contact.twisting_friction)", "",
     "twisting friction", "0.02"},
    {"pair", "twisting_damping", T::number, "-", 0, 10, false, "", "(contact.twisting_damping)", "",
     "damping ratio of the twisting spring", "0.5"},
    {"pair", "cohesion_energy", T::number, "J/m3", 0, k_big, false, "", "(contact.cohesion_energy)", "",
     "cohesion energy density; needs contact.cohesion = sjkr", "500"},
    {"pair", "work_of_adhesion", T::number, "J/m2", 0, k_big, false, "", "(contact.work_of_adhesion)", "",
     "work of adhesion; needs contact.model = jkr", "0.02"},

    {"source", "kind", T::choice, "", 0, 0, false, "file|lattice|random|stream", "required", "",
     "file: initial state; lattice or random: a pack at time start; stream: batches at a rate", "\"random\""},
    {"source", "name", T::text, "", 0, 0, false, "", "(source_0, source_1, ...)", "", "name for reports",
     "\"filling\""},
    {"source", "file", T::text, "", 0, 0, false, "", "(required by file)", "kind=file",
     "table whose header row names x, y, z, radius (or diameter) and optionally vx, vy, vz, wx, wy, wz, material, "
     "fixed; "
     "or LAMMPS data file (sphere); also gzip; relative to the scene",
     "\"state.csv.gz\""},
    {"source", "tile", T::cells, "-", 1, 10000, false, "", "[1, 1, 1]", "kind=file",
     "cuts the domain into so many equal boxes; the file fills the first, copies of it the others", "[4, 4, 1]"},
    {"source", "material", T::text, "", 0, 0, false, "", "(the first material)", "",
     "material of the particles; a material column of a file goes first", "\"glass\""},
    {"source", "velocity", T::vector, "m/s", -k_big, k_big, false, "", "[0, 0, 0]", "kind=lattice|random|stream",
     "initial velocity", "[0, 0, -1]"},
    {"source", "velocity_jitter", T::number, "m/s", 0, k_big, false, "", "0", "kind=lattice|random|stream",
     "each velocity component gets a uniform random part within +-jitter", "0.1"},
    {"source", "number", T::integer, "-", 0, k_count, false, "", "(no limit)", "kind=lattice|random|stream",
     "particles in total; random needs this or mass", "1000"},
    {"source", "mass", T::number, "kg", 0, k_big, false, "", "(no limit)", "kind=lattice|random|stream",
     "mass in total", "0.5"},
    {"source", "number_rate", T::number, "1/s", 0, k_big, true, "", "(this or mass_rate)", "kind=stream",
     "particles per time", "5000"},
    {"source", "mass_rate", T::number, "kg/s", 0, k_big, true, "", "(this or number_rate)", "kind=stream",
     "mass per time", "0.2"},
    {"source", "interval", T::number, "s", 0, k_big, true, "", "(required by stream)", "kind=stream",
     "time between two batches, at least one step", "0.01"},
    {"source", "spacing", T::number, "-", 1, 1e6, false, "", "1.05", "kind=lattice",
     "distance of neighbouring sites / largest diameter", "1.1"},
    {"source", "lattice", T::choice, "", 0, 0, false, "hexagonal|cubic", "\"hexagonal\"", "kind=lattice",
     "arrangement of the sites", "\"cubic\""},
    {"source", "start", T::number, "s", 0, k_big, false, "", "0", "kind=lattice|random|stream",
     "time of the pack, or of the first batch", "0.1"},
    {"source", "end", T::number, "s", 0, k_big, false, "", "(never)", "kind=stream", "no batches at or after this time",
     "2.0"},
    {"source", "group", T::text, "", 0, 0, false, "", "(none)", "", "group that the particles belong to", "\"bed\""},
    {"source", "allow_wall_overlap", T::boolean, "", 0, 0, false, "", "false", "kind=lattice|random|stream",
     "particles may be placed into walls and meshes, which then push them out; otherwise they keep clear of every wall "
     "that acts at that time, where it then is",
     "true"},
    {"source", "closed_walls", T::choice, "", 0, 0, false, "both|outside|inside", "\"both\"",
     "kind=lattice|random|stream",
     "side of closed walls (boxes and watertight meshes) on which particles are placed; both: solid or container "
     "alike, "
     "no particle cuts a surface",
     "\"outside\""},

    TALUS_REGION_KEYS("source.region"),

    {"source.size", "kind", T::choice, "", 0, 0, false, "constant|uniform|normal|lognormal|sieve", "\"constant\"", "",
     "distribution of diameters", "\"constant\""},
    {"source.size", "by", T::choice, "", 0, 0, false, "number|mass", "\"number\"",
     "kind=uniform|normal|lognormal|sieve", "the distribution counts particles or their mass", "\"mass\""},
    {"source.size", "diameter", T::number, "m", 0, k_length, true, "", "(required by constant)", "kind=constant",
     "the one diameter", "0.05"},
    {"source.size", "min", T::number, "m", 0, k_length, true, "", "(required)", "kind=uniform|normal|lognormal",
     "smallest diameter", "0.04"},
    {"source.size", "max", T::number, "m", 0, k_length, true, "", "(required)", "kind=uniform|normal|lognormal",
     "largest diameter", "0.06"},
    {"source.size", "mean", T::number, "m", 0, k_length, true, "", "(required)", "kind=normal|lognormal",
     "mean diameter before truncation", "0.05"},
    {"source.size", "stddev", T::number, "m", 0, k_length, true, "", "(required)", "kind=normal|lognormal",
     "standard deviation of the diameter before truncation", "0.005"},
    {"source.size", "edges", T::numbers, "m", 0, k_length, true, "", "(required by sieve)", "kind=sieve",
     "n + 1 ascending diameters that bound n sieve classes", "[0.03, 0.04, 0.06]"},
    {"source.size", "weights", T::numbers, "-", 0, k_big, false, "", "(required by sieve)", "kind=sieve",
     "share of each class (any common factor); uniform in diameter within a class", "[0.4, 0.6]"},

    {"wall", "name", T::text, "", 0, 0, false, "", "(wall_0, wall_1, ...)", "", "unique name", "\"gate\""},
    {"wall", "shape", T::choice, "", 0, 0, false, "plane|cylinder|cone|box|mesh", "required", "",
     "plane, lateral surface of a cylinder or cone, closed box, or triangle mesh; acts through periodic sides",
     "\"plane\""},
    {"wall", "material", T::text, "", 0, 0, false, "", "(the first material)", "", "material of the wall", "\"steel\""},
    {"wall", "point", T::vector, "m", -k_length, k_length, false, "", "[0, 0, 0]", "shape=plane|cylinder|cone",
     "a point of the plane; centre of the first end of a cylinder or cone", "[0, 0, 0.1]"},
    {"wall", "normal", T::vector, "-", -k_big, k_big, false, "", "[0, 0, 1]", "shape=plane",
     "direction of the particles' side; a plane must be parallel to every periodic axis", "[0, 1, 1]"},
    {"wall", "axis", T::vector, "-", -k_big, k_big, false, "", "[0, 0, 1]", "shape=cylinder|cone",
     "direction from the first end to the other", "[1, 0, 0]"},
    {"wall", "length", T::number, "m", 0, k_length, false, "", "(required)", "shape=cylinder|cone",
     "distance of the two ends; 0 makes a cone a flat ring or disc", "0.5"},
    {"wall", "radius", T::number, "m", 0, k_length, false, "", "(required)", "shape=cylinder|cone",
     "radius at the first end", "0.2"},
    {"wall", "radius_end", T::number, "m", 0, k_length, false, "", "(required by cone)", "shape=cone",
     "radius at the other end", "0.1"},
    {"wall", "lower", T::vector, "m", -k_length, k_length, false, "", "(required by box)", "shape=box",
     "lower corner of the box", "[0.1, 0.1, 0]"},
    {"wall", "upper", T::vector, "m", -k_length, k_length, false, "", "(required by box)", "shape=box",
     "upper corner of the box", "[0.2, 0.2, 0.1]"},
    {"wall", "file", T::text, "", 0, 0, false, "", "(required by mesh)", "shape=mesh",
     "STL, OBJ or PLY file, relative to the scene", "\"silo.stl\""},
    {"wall", "scale", T::number, "-", 0, k_big, true, "", "1", "shape=mesh", "factor on the file's coordinates",
     "0.001"},
    {"wall", "shift", T::vector, "m", -k_length, k_length, false, "", "[0, 0, 0]", "shape=mesh", "added after scaling",
     "[0, 0, 0.1]"},
    {"wall", "appear", T::number, "s", 0, k_big, false, "", "0", "", "the wall acts from this time", "0.1"},
    {"wall", "vanish", T::number, "s", 0, k_big, false, "", "(never)", "", "the wall is gone from this time", "0.5"},

    {"wall.motion", "velocity", T::vector, "m/s", -k_big, k_big, false, "", "[0, 0, 0]", "", "translation",
     "[0.1, 0, 0]"},
    {"wall.motion", "rotation_axis", T::vector, "-", -k_big, k_big, false, "", "[0, 0, 1]", "", "axis of rotation",
     "[0, 1, 0]"},
    {"wall.motion", "rotation_rate", T::number, "rad/s", -k_big, k_big, false, "", "0", "",
     "rate of rotation about the axis", "6.28"},
    {"wall.motion", "rotation_origin", T::vector, "m", -k_length, k_length, false, "", "[0, 0, 0]", "",
     "a point of the axis of rotation", "[0.5, 0.5, 0]"},
    {"wall.motion", "amplitude", T::vector, "m", -k_length, k_length, false, "", "[0, 0, 0]", "",
     "displacement amplitude of the vibration", "[0, 0, 0.0002]"},
    {"wall.motion", "frequency", T::number, "Hz", 0, k_big, false, "", "0", "", "frequency of the vibration", "50"},
    {"wall.motion", "phase", T::number, "turns", -1, 1, false, "", "0", "", "phase of the vibration at its start",
     "0.25"},
    {"wall.motion", "start", T::number, "s", 0, k_big, false, "", "0", "", "the motion begins", "0.1"},
    {"wall.motion", "end", T::number, "s", 0, k_big, false, "", "(never)", "", "the motion ends", "0.6"},

    {"group", "name", T::text, "", 0, 0, false, "", "required", "", "unique name", "\"bed\""},
    {"group", "fixed_in_file", T::boolean, "", 0, 0, false, "", "false", "",
     "takes the particles with fixed = 1 in the initial files", "true"},
    {"group", "ids", T::id_range, "-", 0, k_count, false, "", "(none)", "", "first and last particle id, both included",
     "[0, 99]"},

    TALUS_REGION_KEYS("group.region"),

    {"event", "time", T::number, "s", 0, k_big, false, "", "required", "", "when it happens", "0.2"},
    {"event", "action", T::choice, "", 0, 0, false, "freeze|release|set_velocity|remove|gravity|drive", "required", "",
     "what happens; drive moves the group with velocity and spin from then on", "\"freeze\""},
    {"event", "group", T::text, "", 0, 0, false, "", "(required except by gravity)",
     "action=freeze|release|set_velocity|remove|drive", "whom it concerns", "\"bed\""},
    {"event", "velocity", T::vector, "m/s", -k_big, k_big, false, "", "[0, 0, 0]", "action=set_velocity|drive",
     "the new velocity", "[0, 0, 0.5]"},
    {"event", "spin", T::vector, "rad/s", -k_big, k_big, false, "", "[0, 0, 0]", "action=set_velocity|drive",
     "the new angular velocity", "[0, 0, 10]"},
    {"event", "gravity", T::vector, "m/s2", -k_big, k_big, false, "", "(required by gravity)", "action=gravity",
     "the new acceleration of gravity", "[1, 0, -9.81]"},

    {"list", "policy", T::choice, "", 0, 0, false,
     "always|paper|local|uniform|two_largest|accumulated|global_velocity|neighbourhood|mean_subtracted|"
     "velocity_profile|displacement_history|outer_inner|fixed",
     "(velocity_profile where gravity drives a flow without walls along a periodic axis, else local)", "",
     "when and with which skins the list is rebuilt; all exact but fixed", "\"paper\""},
    {"list", "verlet_k", T::number_or_auto, "steps", 0, 1e9, false, "", "\"auto\"", "",
     "K in skin = K |v| step; \"auto\": K and floor follow the run, never its results", "200"},
    {"list", "interval", T::integer, "steps", 0, k_count, false, "", "0", "",
     "policy fixed: steps between two rebuilds; contacts that form in between may be missed", "20"},
    {"list", "floor", T::number, "-", 0, 10, false, "", "(0.02; policy paper: 0)", "",
     "smallest skin / particle diameter; 0 switches the floor off", "0.05"},
    {"list", "acceleration", T::boolean, "", 0, 0, false, "", "(true; policy paper: false)", "",
     "acceleration term of the skin", "false"},
    {"list", "cap", T::boolean, "", 0, 0, false, "", "true", "", "upper bound of the skin", "false"},
    {"list", "uniform_skin", T::number, "-", 0, 100, false, "", "1", "",
     "skin of the policies with one skin for all / smallest radius", "0.6"},
    {"list", "outer", T::number, "-", 1, 100, false, "", "3", "",
     "policy outer_inner: skins of the outer list / those of the inner one", "4"},
    {"list", "cell_factor", T::number, "-", 0, 100, false, "", "0", "",
     "cell edge / smallest admissible edge; 0: chosen by the policy", "1.25"},

    {"output", "particles_every", T::number, "s", 0, k_big, false, "", "0", "",
     "simulated time between particle frames; 0: none", "0.01"},
    {"output", "vtp", T::boolean, "", 0, 0, false, "", "true", "",
     "particle frames as one .vtp file each, listed in a .pvd: any ParaView and VTK 9 open it", "false"},
    {"output", "vtkhdf", T::boolean, "", 0, 0, false, "", "false", "",
     "particle frames in one VTKHDF file (ParaView 5.12 or newer)", "true"},
    {"output", "csv_every", T::number, "s", 0, k_big, false, "", "0", "",
     "simulated time between rows of the time series; 0: none", "0.001"},
    {"output", "checkpoint_wall", T::number, "s", 0, k_big, false, "", "300", "",
     "wall time between checkpoints, of which the newest two are kept, so that a killed run loses no more; 0: only at "
     "the end; changes no result",
     "60"},
    {"output", "energies", T::boolean, "", 0, 0, false, "", "false", "", "energy terms and balance", "true"},
    {"output", "contacts", T::boolean, "", 0, 0, false, "", "false", "", "contacts of every frame", "true"},
    {"output", "coordination", T::boolean, "", 0, 0, false, "", "false", "", "contacts per particle", "true"},
    {"output", "stress", T::boolean, "", 0, 0, false, "", "false", "", "stress per particle", "true"},
    {"output", "grid", T::cells, "-", 1, 10000, false, "", "(none)", "", "averages on a grid of this many cells",
     "[10, 10, 20]"},

    {"output.plane", "name", T::text, "", 0, 0, false, "", "required", "", "unique name", "\"outlet\""},
    {"output.plane", "point", T::vector, "m", -k_length, k_length, false, "", "required", "",
     "a point of the plane, which has to meet the domain; a grain passes with its centre, and on the plane exactly it "
     "is "
     "on the side of larger coordinates; across a periodic axis a plane counts once per round, at either end too",
     "[0, 0, 0.1]"},
    {"output.plane", "normal", T::vector, "-", -k_big, k_big, false, "", "[0, 0, 1]", "",
     "direction in which passages count as positive, against it as negative", "[0, 0, -1]"},

    {"output.region", "name", T::text, "", 0, 0, false, "", "required", "", "unique name", "\"core\""},
    TALUS_REGION_KEYS("output.region"),

    {"checks", "max_overlap", T::number, "-", 0, 1, true, "", "0.5", "", "overlap / smaller radius that stops the run",
     "0.2"},
    {"checks", "allow_initial_overlap", T::boolean, "", 0, 0, false, "", "false", "",
     "accept initial overlaps up to max_overlap (otherwise 0.05)", "true"},
    {"checks", "allow_unstable_step", T::boolean, "", 0, 0, false, "", "false", "",
     "accept a time step above the packing limit, up to which the densest packing of such contacts is stable", "true"},
    {"checks", "warn_overlap", T::number, "-", 0, k_big, true, "", "0.1", "", "overlap / smaller radius that warns",
     "0.05"},
    {"checks", "warn_travel", T::number, "-", 0, k_big, true, "", "0.1", "",
     "travel of a particle or wall in one step / radius that warns", "0.05"},
    {"checks", "max_travel", T::number, "-", 0, k_big, true, "", "1", "",
     "travel in one step / radius that stops the run: beyond 1 a wall can be crossed unseen", "0.5"},
    {"checks", "warn_stiffness", T::number, "-", 0, k_big, true, "", "2", "",
     "step^2 times (sum of the stiffnesses of a particle's contacts / its mass) that warns, with what dashpots and "
     "tangential springs add; surely stable up to 2. Normal springs alone are surely unstable from 12 on, which stops",
     "1"},
    {"checks", "warn_energy", T::number, "-", 0, k_big, true, "", "0.1", "",
     "energy balance residual / energy turned over that warns (with output.energies)", "0.01"},
    {"checks", "max_energy", T::number, "-", 0, k_big, true, "", "(never)", "",
     "energy balance residual / energy turned over that stops the run (with output.energies)", "0.5"},

    {"relax", "steps", T::integer, "steps", 0, k_count, false, "", "0", "",
     "first steps in which particles only leave their overlaps: no gravity, friction or inertia; initial velocities "
     "are dropped, and overlaps of any depth are accepted",
     "2000"},
    {"relax", "displacement", T::number, "-", 0, 0.5, true, "", "0.02", "",
     "largest displacement of a particle per relaxing step / its radius", "0.01"},
};

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  while (!text.empty()) {
    const std::size_t at = text.find(separator);
    parts.push_back(text.substr(0, at));
    text = at == std::string_view::npos ? std::string_view{} : text.substr(at + 1);
  }
  return parts;
}

std::string join_choices(std::string_view choices) {
  std::string s;
  for (std::string_view c : split(choices, '|')) s += (s.empty() ? "" : ", ") + std::string(c);
  return s;
}

std::string range_text(const SceneKey& k) {
  const bool bounded_low = k.low > -k_length, bounded_high = k.high < k_length;
  if (bounded_low && bounded_high) return fmt::format("in {}{:g}, {:g}]", k.low_open ? '(' : '[', k.low, k.high);
  if (bounded_low) return fmt::format("{} {:g}", k.low_open ? ">" : ">=", k.low);
  return "finite";
}

std::string unit_text(const SceneKey& k) { return k.unit.empty() ? "" : fmt::format(" [{}]", k.unit); }

std::string default_text(const SceneKey& k) {
  if (k.fallback == "required") return "required";
  if (k.fallback.starts_with("(required")) return std::string(k.fallback.substr(1, k.fallback.size() - 2));
  return "default " + std::string(k.fallback);
}

std::string header_text(const SceneSection& s) {
  if (s.name.empty()) return "top of the file";
  return s.repeated ? fmt::format("[[{}]]", s.name) : fmt::format("[{}]", s.name);
}

std::string one_line(const SceneKey& k) {
  return fmt::format("  {:<32} {}; {}\n", full_name(k), allowed_text(k), default_text(k));
}

std::string full_text(const SceneKey& k) {
  std::string s = fmt::format("{}\n  {}\n  value:   {}\n  default: {}\n", full_name(k), k.doc, allowed_text(k),
                              k.fallback.starts_with('(') ? k.fallback.substr(1, k.fallback.size() - 2) : k.fallback);
  if (!k.only.empty()) {
    const std::size_t at = k.only.find('=');
    s += fmt::format("  only for: {} = {}\n", k.only.substr(0, at), join_choices(k.only.substr(at + 1)));
  }
  const SceneSection* section = find_scene_section(k.section);
  s += "  example:\n";
  if (!k.section.empty()) s += fmt::format("    {}\n", header_text(*section));
  return s + fmt::format("    {} = {}\n", k.name, k.example);
}

// --- examples: the smallest valid scene, with the sections that a key needs switched to the variant it belongs to.

struct Line {
  std::string_view name, value;
};

/// Required lines of a section for the given variant of its deciding key.
std::vector<Line> minimal_section(std::string_view section, std::string_view variant) {
  if (section == "domain") return {{"lower", "[0, 0, 0]"}, {"upper", "[1, 1, 2]"}};
  if (section == "time") return {{"step", "1e-5"}, {"steps", "100"}};
  if (section == "source") {
    if (variant == "file") return {{"kind", "\"file\""}, {"file", "\"state.csv\""}};
    if (variant == "lattice") return {{"kind", "\"lattice\""}};
    if (variant == "stream") return {{"kind", "\"stream\""}, {"number_rate", "1000"}, {"interval", "0.01"}};
    return {{"kind", "\"random\""}, {"number", "20"}};
  }
  if (section.ends_with("region")) {
    std::vector<Line> lines = {{"lower", "[0.1, 0.1, 0.1]"}, {"upper", "[0.9, 0.9, 0.9]"}};
    if (variant == "cylinder")
      lines = {{"shape", "\"cylinder\""}, {"point", "[0.5, 0.5, 0.5]"}, {"length", "0.2"}, {"radius", "0.3"}};
    if (variant == "sphere") lines = {{"shape", "\"sphere\""}, {"centre", "[0.5, 0.5, 0.5]"}, {"radius", "0.3"}};
    if (variant == "mesh") lines = {{"shape", "\"mesh\""}, {"file", "\"drum.stl\""}};
    if (section == "output.region") lines.insert(lines.begin(), {"name", "\"core\""});
    return lines;
  }
  if (section == "source.size") {
    if (variant == "uniform") return {{"kind", "\"uniform\""}, {"min", "0.04"}, {"max", "0.06"}};
    if (variant == "normal" || variant == "lognormal")
      return {{"kind", variant == "normal" ? "\"normal\"" : "\"lognormal\""},
              {"min", "0.04"},
              {"max", "0.06"},
              {"mean", "0.05"},
              {"stddev", "0.005"}};
    if (variant == "sieve") return {{"kind", "\"sieve\""}, {"edges", "[0.03, 0.04, 0.06]"}, {"weights", "[1, 1]"}};
    return {{"diameter", "0.05"}};
  }
  if (section == "wall") {
    if (variant == "cylinder") return {{"shape", "\"cylinder\""}, {"radius", "0.4"}, {"length", "1"}};
    if (variant == "cone") return {{"shape", "\"cone\""}, {"radius", "0.4"}, {"radius_end", "0.2"}, {"length", "1"}};
    if (variant == "box") return {{"shape", "\"box\""}, {"lower", "[0.1, 0.1, 0]"}, {"upper", "[0.2, 0.2, 0.1]"}};
    if (variant == "mesh") return {{"shape", "\"mesh\""}, {"file", "\"silo.stl\""}};
    return {{"shape", "\"plane\""}};
  }
  if (section == "pair") return {{"materials", "[\"glass\", \"steel\"]"}};
  if (section == "group") return {{"name", "\"bed\""}};
  if (section == "event") {
    if (variant == "gravity") return {{"time", "0.1"}, {"action", "\"gravity\""}, {"gravity", "[0, 0, -1]"}};
    if (variant == "set_velocity") return {{"time", "0.1"}, {"action", "\"set_velocity\""}, {"group", "\"bed\""}};
    return {{"time", "0.1"}, {"action", "\"freeze\""}, {"group", "\"bed\""}};
  }
  if (section == "output.plane") return {{"name", "\"outlet\""}, {"point", "[0, 0, 0.1]"}};
  return {};
}

/// Lines of [contact], for which the key (of this section or of [[pair]]) decides what else must be there.
std::vector<Line> contact_section(const SceneKey& key) {
  const Line stiffness{"normal_stiffness", "1e5"}, friction{"friction", "0.5"}, rolling{"rolling_friction", "0.1"};
  const bool asked = key.section == "contact" || key.section == "pair";
  if (asked && key.name == "rolling") return {stiffness, friction, rolling};
  if (asked && key.name == "rolling_friction") return {stiffness, friction, {"rolling", "\"cdt\""}};
  if (asked && key.name == "rolling_damping") return {stiffness, friction, {"rolling", "\"epsd\""}, rolling};
  if (asked && key.name == "twisting_friction") return {stiffness, friction};
  if (asked && key.name == "twisting_damping") return {stiffness, friction, {"twisting_friction", "0.05"}};
  if (asked && key.name == "cohesion") return {stiffness, {"cohesion_energy", "1e3"}};
  if (asked && key.name == "cohesion_energy") return {stiffness, {"cohesion", "\"sjkr\""}};
  if (asked && key.name == "work_of_adhesion") return {{"model", "\"jkr\""}, {"restitution", "0.8"}};
  return {stiffness};
}

std::string section_text(std::string_view section, std::string_view variant, const SceneKey& key) {
  std::string s;
  if (!section.empty()) s = header_text(*find_scene_section(section)) + "\n";
  bool placed = section != key.section;
  for (const Line& line : section == "contact" ? contact_section(key) : minimal_section(section, variant)) {
    const bool same = section == key.section && line.name == key.name;
    // steps and duration, number_rate and mass_rate, length and end exclude each other
    if (section == key.section &&
        ((line.name == "steps" && key.name == "duration") || (line.name == "number_rate" && key.name == "mass_rate") ||
         (line.name == "length" && key.name == "end")))
      continue;
    s += fmt::format("{} = {}\n", line.name, same ? key.example : line.value);
    placed = placed || same;
  }
  if (!placed) s += fmt::format("{} = {}\n", key.name, key.example);
  return s;
}

}  // namespace

std::span<const SceneKey> scene_keys() noexcept { return k_keys; }
std::span<const SceneSection> scene_sections() noexcept { return k_sections; }

const SceneKey* find_scene_key(std::string_view section, std::string_view name) noexcept {
  for (const SceneKey& k : k_keys) {
    if (k.section == section && k.name == name) return &k;
  }
  return nullptr;
}

const SceneSection* find_scene_section(std::string_view name) noexcept {
  for (const SceneSection& s : k_sections) {
    if (s.name == name) return &s;
  }
  return nullptr;
}

std::string full_name(const SceneKey& key) {
  return key.section.empty() ? std::string(key.name) : fmt::format("{}.{}", key.section, key.name);
}

std::string allowed_text(const SceneKey& k) {
  const std::string unit = unit_text(k);
  switch (k.type) {
    case KeyType::number:
      return "a number " + range_text(k) + unit;
    case KeyType::number_or_none:
      return "a number " + range_text(k) + unit + " or \"none\"";
    case KeyType::number_or_auto:
      return "a number " + range_text(k) + unit + " or \"auto\"";
    case KeyType::integer:
      return "an integer " + range_text(k) + unit;
    case KeyType::boolean:
      return "true or false";
    case KeyType::text:
      return "a text of one line in quotes, without control characters";
    case KeyType::choice:
      return "one of " + join_choices(k.choices);
    case KeyType::vector:
      return "[x, y, z], 3 numbers, each " + range_text(k) + unit;
    case KeyType::numbers:
      return "a list of numbers, each " + range_text(k) + unit;
    case KeyType::cells:
      return "[nx, ny, nz], 3 integers, each " + range_text(k);
    case KeyType::text_pair:
      return "[\"a\", \"b\"], 2 texts of one line";
    case KeyType::id_range:
      return "[first, last], 2 ascending integers, each " + range_text(k);
    case KeyType::boundary:
      return "one of " + join_choices(k.choices) + "; or 3 entries, each such a word or a pair [lower, upper] of words";
  }
  return {};
}

std::string scene_help(std::string_view key) {
  std::string text;
  if (key.empty()) {
    for (const SceneSection& s : k_sections) {
      text += fmt::format("{}: {}\n", header_text(s), s.doc);
      for (const SceneKey& k : k_keys) {
        if (k.section == s.name) text += one_line(k);
      }
      text += '\n';
    }
    return text;
  }
  for (const SceneKey& k : k_keys)
    if (full_name(k) == key) return full_text(k);
  for (const SceneSection& s : k_sections) {
    if (s.name.empty() || s.name != key) continue;
    text = fmt::format("{}: {}\n\n", header_text(s), s.doc);
    for (const SceneKey& k : k_keys) {
      if (k.section == s.name) text += full_text(k) + "\n";
    }
    for (const SceneSection& inner : k_sections) {
      if (inner.name.starts_with(std::string(s.name) + "."))
        text += fmt::format("{}: {} (see '{}')\n", header_text(inner), inner.doc, inner.name);
    }
    return text;
  }
  for (const SceneKey& k : k_keys)
    if (k.name == key) text += (text.empty() ? "" : "\n") + full_text(k);
  if (!text.empty()) return text;
  throw Error(ErrorCode::usage, fmt::format("no scene key or section '{}'{}", key, key_hint(key, false)), "",
              "'talus help scene' lists all keys");
}

std::string scene_key_example(const SceneKey& key) {
  std::string_view variant;
  if (!key.only.empty()) variant = split(key.only.substr(key.only.find('=') + 1), '|').front();
  const auto variant_of = [&](std::string_view section) { return section == key.section ? variant : ""; };
  std::string s;
  if (key.section.empty()) s = section_text("", "", key);
  s += section_text("domain", "", key) + section_text("time", "", key);
  s += "[[material]]\nname = \"glass\"\ndensity = 2500\n";
  if (key.section == "material" && key.name != "name" && key.name != "density")
    s += fmt::format("{} = {}\n", key.name, key.example);
  const std::string elastic = key.name == "work_of_adhesion" ? "young = 5e7\npoisson = 0.25\n" : "";
  s += elastic + "[[material]]\nname = \"steel\"\ndensity = 7800\n" + elastic;
  s += section_text("contact", "", key);
  if (key.section == "pair" && key.name == "restitution") s += "restitution = 0.8\n";
  s += section_text("source", variant_of("source"), key);
  if (variant_of("source") != "file") {
    s += section_text("source.region", variant_of("source.region"), key);
    s += section_text("source.size", variant_of("source.size"), key);
  }
  s += section_text("group", "", key);
  const std::string_view parent = key.section.substr(0, key.section.find('.'));
  constexpr std::string_view always[] = {"", "domain", "time", "material", "contact", "source", "group"};
  if (std::find(std::begin(always), std::end(always), parent) == std::end(always))
    s += section_text(parent, variant_of(parent), key);
  if (parent != key.section && parent != "source") s += section_text(key.section, variant, key);
  return s;
}

}  // namespace talus
