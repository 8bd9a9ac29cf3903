// [[source]] and [source.size].
#include "core/scene/sections/sections.hpp"

namespace talus {
namespace {

constexpr std::string_view k_delivered = "the source has begun under it";
constexpr std::string_view k_made = "kind=lattice|random|stream";
constexpr std::string_view k_diameters = "sizes are diameters";

const Keys<Source> k_source(
    {"source", true, "where particles come from"}, fixed_by(k_delivered),
    {
        key("kind", &Source::kind,
            "file: initial state; lattice or random: a pack at time start; stream: batches at a rate", "\"random\"")
            .required()
            .also({{"type", "source"}})
            .meaning({{"csv", "file"},
                      {"data", "file"},
                      {"grid", "lattice"},
                      {"regular", "lattice"},
                      {"hcp", "lattice"},
                      {"pack", "random"},
                      {"fill", "random"},
                      {"rain", "stream"},
                      {"inlet", "stream"},
                      {"flow", "stream"},
                      {"continuous", "stream"},
                      {"factory", "stream"}}),
        text_key<Source>("name", "name for reports", "\"filling\"").absent("(source_0, source_1, ...)").free(),
        key("file", &Source::file,
            "table whose header row names x, y, z, radius (or diameter) and optionally vx, vy, vz, wx, wy, wz, "
            "material, fixed, and of bodies shape, scale, qw, qx, qy, qz (cases/shapes); or LAMMPS data file (sphere); "
            "also gzip; relative to the scene",
            "\"state.csv.gz\"")
            .only("kind=file")
            .needed("file", "(required by file)"),
        key("tile", &Source::tile, "-", {1, 10000},
            "cuts the domain into so many equal boxes; the file fills the first, copies of it the others", "[4, 4, 1]")
            .only("kind=file"),
        text_key<Source>("material", "material of the particles; a material column of a file goes first", "\"glass\"")
            .absent("(the first material)"),
        key("velocity", &Source::velocity, "m/s", k_finite, "initial velocity", "[0, 0, -1]").only(k_made).acts(),
        key("velocity_jitter", &Source::velocity_jitter, "m/s", k_not_negative,
            "each velocity component gets a uniform random part within +-jitter", "0.1")
            .only(k_made)
            .acts(),
        key("number", &Source::number, "-", k_counted, "particles in total; random needs this or mass", "1000")
            .only(k_made)
            .absent("(no limit)")
            .usual("random", "")
            .acts()
            .also({{"count", "source"}, {"n", "source"}, {"particles", "source"}}),
        key("mass", &Source::mass, "kg", k_not_negative, "mass in total", "0.5")
            .only(k_made)
            .absent("(no limit)")
            .acts(),
        key("number_rate", &Source::number_rate, "1/s", k_positive, "particles per time", "5000")
            .only("kind=stream")
            .absent("(this or mass_rate)")
            .usual("stream", "mass_rate")
            .acts()
            .also({{"rate", "source"}}),
        key("mass_rate", &Source::mass_rate, "kg/s", k_positive, "mass per time", "0.2")
            .only("kind=stream")
            .absent("(this or number_rate)")
            .acts()
            .also({{"mass_flow", "source"}}),
        key("interval", &Source::interval, "s", k_positive, "time between two batches, at least one step", "0.01")
            .only("kind=stream")
            .needed("stream", "(required by stream)")
            .also({{"every", "source"}}),
        key("spacing", &Source::spacing, "-", {1, 1e6}, "distance of neighbouring sites / largest diameter", "1.1")
            .only("kind=lattice"),
        key("lattice", &Source::lattice, "arrangement of the sites", "\"cubic\"")
            .only("kind=lattice")
            .meaning({{"hcp", "hexagonal"}, {"close_packed", "hexagonal"}, {"sc", "cubic"}, {"square", "cubic"}}),
        key("start", &Source::start, "s", k_not_negative, "time of the pack, or of the first batch", "0.1")
            .only(k_made),
        key("end", &Source::end, "s", k_not_negative,
            "no batches at or after this time; the last one brings what is due until then", "2.0")
            .only("kind=stream")
            .absent("(never)")
            .acts(),
        text_key<Source>("group", "group that the particles belong to", "\"bed\"").absent("(none)"),
        key("allow_wall_overlap", &Source::allow_wall_overlap,
            "particles may be placed into walls and meshes, which then push them out; otherwise they keep clear of "
            "every wall that acts at that time, where it then is",
            "true")
            .only(k_made),
        key("closed_walls", &Source::closed_walls,
            "side of closed walls (boxes and watertight meshes) on which particles are placed; both: solid or "
            "container alike, no particle cuts a surface",
            "\"outside\"")
            .only(k_made),
    });

const Keys<SizeDistribution> k_size_keys(
    {"source.size", false, "distribution of particle diameters of a source"},
    fixed_by("the grains that are there have sizes of it"),
    {
        key("kind", &SizeDistribution::kind, "distribution of diameters", "\"constant\"")
            .meaning({{"single", "constant"},
                      {"mono", "constant"},
                      {"monodisperse", "constant"},
                      {"fixed", "constant"},
                      {"equal", "constant"},
                      {"same", "constant"},
                      {"gauss", "normal"},
                      {"gaussian", "normal"},
                      {"flat", "uniform"},
                      {"range", "uniform"},
                      {"random", "uniform"},
                      {"psd", "sieve"},
                      {"histogram", "sieve"},
                      {"classes", "sieve"},
                      {"table", "sieve"},
                      {"discrete", "sieve"}}),
        other_key<SizeDistribution>("by", KeyType::choice, "", {0, 0},
                                    "the distribution counts particles or their mass", "\"mass\"")
            .choices("number, mass")
            .absent("\"number\"")
            .only("kind=uniform|normal|lognormal|sieve"),
        key("diameter", &SizeDistribution::diameter, "m", k_size, "the one diameter", "0.05")
            .only("kind=constant")
            .needed("constant", "(required by constant)")
            .also({{"radius", "source", k_diameters},
                   {"radius", "size", k_diameters},
                   {"radius", "", k_diameters},
                   {"particle_radius", "", k_diameters},
                   "d",
                   "particle_diameter"}),
        key("min", &SizeDistribution::min, "m", k_size, "smallest diameter", "0.04")
            .only("kind=uniform|normal|lognormal")
            .needed("uniform|normal|lognormal", "(required by uniform, normal and lognormal)")
            .also({{"min_radius", "", k_diameters}}),
        key("max", &SizeDistribution::max, "m", k_size, "largest diameter", "0.06")
            .only("kind=uniform|normal|lognormal")
            .needed("uniform|normal|lognormal", "(required by uniform, normal and lognormal)")
            .also({{"max_radius", "", k_diameters}}),
        key("mean", &SizeDistribution::mean, "m", k_size, "mean diameter before truncation", "0.05")
            .only("kind=normal|lognormal")
            .needed("normal|lognormal", "(required by normal and lognormal)"),
        key("stddev", &SizeDistribution::stddev, "m", k_size, "standard deviation of the diameter before truncation",
            "0.005")
            .only("kind=normal|lognormal")
            .needed("normal|lognormal", "(required by normal and lognormal)")
            .also({{"sigma", "size"}, {"std", "size"}, {"deviation", "size"}, {"standard_deviation", "size"}}),
        key("edges", &SizeDistribution::edges, "m", k_size, "n + 1 ascending diameters that bound n sieve classes",
            "[0.03, 0.04, 0.06]")
            .only("kind=sieve")
            .needed("sieve", "(required by sieve)"),
        key("weights", &SizeDistribution::weights, "-", k_not_negative,
            "share of each class (any common factor); uniform in diameter within a class", "[0.4, 0.6]")
            .only("kind=sieve")
            .needed("sieve", "(required by sieve)"),
    });

void check_sieve(const SceneTable& r, const SizeDistribution& s) {
  if (s.weights.empty() || s.edges.size() != s.weights.size() + 1)
    r.fail("edges", fmt::format("must have one entry more than 'weights' ({})", s.weights.size()));
  double sum = 0;
  for (std::size_t i = 0; i < s.weights.size(); ++i) {
    if (!(s.edges[i] < s.edges[i + 1])) r.fail("edges", "must ascend");
    sum += s.weights[i];
  }
  if (!(sum > 0)) r.fail("weights", "must not all be 0");
}

SizeDistribution read_size(const SceneTable& r) {
  using Kind = SizeDistribution::Kind;
  SizeDistribution s;
  k_size_keys.read(r, s);
  s.by_mass = r.text("by") == "mass";
  if (s.kind == Kind::sieve) check_sieve(r, s);
  if (s.kind == Kind::constant || s.kind == Kind::sieve) return s;
  if (!(s.min <= s.max)) r.fail("max", "must not be below 'min'");
  if (s.kind != Kind::uniform && (s.mean + 6 * s.stddev < s.min || s.mean - 6 * s.stddev > s.max))
    r.fail("mean", "lies more than 6 standard deviations outside [min, max]");
  return s;
}

/// What the keys of a source that makes its grains have to be together.
void check_made(const SceneTable& r, const Source& s, double dt) {
  if (r.has("number") && s.number == 0) r.fail("number", "must be 1 or more; leave the key out for no limit");
  if (r.has("mass") && s.mass == 0) r.fail("mass", "must be > 0; leave the key out for no limit");
  if (!(s.end > s.start)) r.fail("end", "must be after 'start'");
  if (s.kind == Source::Kind::random && s.number == 0 && s.mass == 0) r.missing("number", "(or mass) by kind = random");
  if (s.kind != Source::Kind::stream) return;
  r.exclusive("number_rate", "mass_rate");
  if (!r.has("number_rate") && !r.has("mass_rate")) r.missing("number_rate", "(or mass_rate) by kind = stream");
  if (s.interval < dt) r.fail("interval", fmt::format("must be at least one time step ({:g})", dt));
}

Source read_source(const SceneTable& r, const Scene& scene, const std::vector<std::string>& materials,
                   const std::vector<std::string>& groups, std::vector<std::string>& names) {
  Source s;
  k_source.read(r, s);
  s.name = unique_name(r, fmt::format("source_{}", names.size()), names);
  if (r.has("material")) s.material = r.index("material", materials, "material");
  if (r.has("group")) s.group = r.index("group", groups, "group");
  if (s.kind == Source::Kind::file) {
    if (s.file.empty()) r.fail("file", "must not be empty");
    for (std::string_view unused : {"region", "size"}) {
      if (r.has(unused)) r.fail(unused, "has no effect with kind = file");
    }
    return s;
  }
  const std::string why = "by kind = " + r.text("kind");
  r.require("region", why);
  if (!r.has("shape")) r.require("size", why);
  s.region = read_region(r.section("region"), RegionOf::source, scene.domain, true);
  if (r.has("size")) s.size = read_size(r.section("size"));
  check_made(r, s, scene.dt);
  return s;
}

}  // namespace

const SectionKeys& source_keys() { return k_source; }
const SectionKeys& source_size_keys() { return k_size_keys; }

void read_sources(const std::vector<SceneTable>& list, const std::vector<std::string>& materials,
                  const std::vector<std::string>& groups, Scene& scene) {
  std::vector<std::string> names;
  for (const SceneTable& r : list) scene.sources.push_back(read_source(r, scene, materials, groups, names));
}

}  // namespace talus
