// Worlds for the microbenchmarks: a real dense bed (settle32 cut down to 4k grains or tiled to 512k) and grains resting
// on a wall of each kind. Who calls it: perf/kernels*.cpp. Invariants: made by the engine itself from a scene and run
// for some steps, so that storage order, lists, masks and history are those of a run; then the time step is set so
// small that history does not drift into sliding over millions of repetitions of the same step.
#pragma once

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "core/base/error.hpp"
#include "core/tables/particle_file.hpp"
#include "core/scene/scene_file.hpp"
#include "paths.hpp"
#include "scheduler/simulation.hpp"
#include "scheduler/step/world.hpp"

namespace talus::perf {

inline const std::string k_source = TALUS_SOURCE_DIR;

/// A CSV file for a scene's source, gone with this object.
class StateFile {
 public:
  StateFile() : path_(std::filesystem::temp_directory_path() / ("talus-perf-" + std::to_string(::getpid()) + ".csv")) {
    text_ = "x,y,z,radius,vx,vy,vz,wx,wy,wz,fixed\n";
  }
  StateFile(const StateFile&) = delete;
  StateFile& operator=(const StateFile&) = delete;
  ~StateFile() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  void add(Vec3 x, double r, Vec3 v = {}, Vec3 w = {}, bool fixed = false) {
    for (const double q : {x.x, x.y, x.z, r, v.x, v.y, v.z, w.x, w.y, w.z}) {
      char digits[40];
      const auto end = std::to_chars(digits, digits + sizeof digits, q).ptr;
      text_.append(digits, end).push_back(',');
    }
    text_ += fixed ? "1\n" : "0\n";
  }
  std::string write() {
    std::ofstream out(path_);
    out << text_;
    if (!out) throw Error(ErrorCode::io, "cannot write a state", path_.string());
    return path_.string();
  }

 private:
  std::filesystem::path path_;
  std::string text_;
};

inline std::string vector_text(Vec3 a) { return fmt::format("[{}, {}, {}]", a.x, a.y, a.z); }

/// The marks' scene (perf/scenes/settle32.toml) in an open box with other grains and, where asked for, a wall.
inline std::unique_ptr<Simulation> simulate(StateFile& state, Vec3 size, Vec3 gravity, const std::string& wall,
                                            std::int64_t steps) {
  const std::string text = fmt::format(
      "gravity = {}\n[domain]\nlower = [0, 0, 0]\nupper = {}\nboundary = \"open\"\n"
      "[time]\nstep = 1e-4\nsteps = 1000\n"
      "[[material]]\nname = \"grain\"\ndensity = 1.909859317102744\n"
      "[contact]\nnormal_stiffness = 2e5\ntangential_stiffness = 57142.857142857145\n"
      "normal_damping = 50\ntangential_damping = 25\nfriction = 0.5\n{}"
      "[[source]]\nkind = \"file\"\nfile = \"{}\"\n[[group]]\nname = \"base\"\nfixed_in_file = true\n"
      "[checks]\nallow_initial_overlap = true\n",
      vector_text(gravity), vector_text(size), wall, state.write());
  RunOptions options;
  options.threads = 1;
  auto sim = std::make_unique<Simulation>(parse_scene(text, "perf", k_source), options);
  sim->run(steps);
  sim->world().law_args.dt = 1e-9;
  return sim;
}

/// The dense bed, made on first use. `contacts` counts evaluations: a pair across a chunk border is evaluated by both.
struct Bed {
  std::unique_ptr<Simulation> sim;
  World& w;
  double particles = 0, candidates = 0, contacts = 0;

  explicit Bed(bool large) : sim(make(large)), w(sim->world()) {
    particles = static_cast<double>(w.alive);
    for (const auto& c : w.chunks) {
      for (const std::int64_t pairs : c->pairs) candidates += static_cast<double>(pairs);
      contacts += static_cast<double>(c->contact_end[2]);
    }
  }

  static Bed& get(bool large) {
    static std::array<std::unique_ptr<Bed>, 2> beds;
    auto& bed = beds[large ? 1 : 0];
    if (!bed) bed = std::make_unique<Bed>(large);
    return *bed;
  }

 private:
  static std::unique_ptr<Simulation> make(bool large) {
    const Material grain{"grain", 1.909859317102744, 0, 0};
    const ParticleFile bed =
        read_particle_file(k_source + "/perf/states/settle32.csv.gz", std::span<const Material>(&grain, 1));
    const Vec3 box{40, 20, 45};
    const int tiles = large ? 4 : 1;
    const double share = large ? 1 : 0.3536;  // of each horizontal axis: an eighth of the grains
    StateFile state;
    for (int tx = 0; tx < tiles; ++tx)
      for (int ty = 0; ty < tiles; ++ty)
        for (std::size_t k = 0; k < bed.size(); ++k)
          if (bed.x[k].x < share * box.x && bed.x[k].y < share * box.y)
            state.add(bed.x[k] + Vec3{tx * box.x, ty * box.y, 0}, bed.r[k], bed.v[k], bed.w[k],
                      !bed.fixed.empty() && bed.fixed[k] != 0);
    return simulate(state, {tiles * share * box.x, tiles * share * box.y, box.z}, {0, 0, -1}, "", large ? 6 : 20);
  }
};

/// A wall and how the grains stand on it.
struct WallCase {
  const char* name;
  const char* text;     ///< scene section
  double offset = 0.5;  ///< of a grain's diameter, along the surface's normal
};
inline constexpr double k_wall_radius = 0.25;
inline constexpr WallCase k_wall_cases[] = {
    {"plane", "shape = \"plane\"\npoint = [0, 0, 8]\nnormal = [0, 0, 1]\n", 0.49},
    {"cylinder", "shape = \"cylinder\"\npoint = [16, 16, 4]\naxis = [0, 0, 1]\nlength = 20\nradius = 12\n", 0.49},
    {"cone", "shape = \"cone\"\npoint = [16, 16, 4]\naxis = [0, 0, 1]\nlength = 20\nradius = 4\nradius_end = 14\n",
     0.49},
    {"mesh", nullptr, 0.49},
    {"mesh_far", nullptr, 6.0},  // nothing within reach: what a grain in the bulk pays
};

/// Up to 4096 grains that touch the wall and not each other.
inline std::unique_ptr<Simulation> make_wall_world(const WallCase& c) {
  const Vec3 size{32, 32, 32};
  std::string wall = "[[wall]]\nname = \"wall\"\n";
  if (c.text != nullptr)
    wall += c.text;
  else  // the 20k hopper's silo: 288 facets, in proportion to the grains
    wall += "shape = \"mesh\"\nfile = \"" + k_source +
            "/cases/hopper/meshes/cone-silo.stl\"\nscale = 90\nshift = [16, 16, 1]\n";
  StateFile probe;
  probe.add({1, 1, 31}, k_wall_radius);
  const auto bare = simulate(probe, size, {}, wall, 0);
  const WallSurface surface = bare->world().walls.surfaces().at(0);
  std::vector<double> area;  // cumulative
  for (const auto& t : surface.triangles) {
    const Vec3 a = surface.points[static_cast<std::size_t>(t[0])];
    const Vec3 n =
        cross(surface.points[static_cast<std::size_t>(t[1])] - a, surface.points[static_cast<std::size_t>(t[2])] - a);
    area.push_back((area.empty() ? 0 : area.back()) + norm(n));
  }
  StateFile state;
  std::vector<Vec3> placed;
  std::uint64_t draw = 0;
  const auto random = [&] {
    std::uint64_t z = ++draw * 0x9e3779b97f4a7c15ULL;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ z >> 27) * 0x94d049bb133111ebULL;
    return static_cast<double>((z ^ z >> 31) >> 11) * 0x1p-53;
  };
  const double edge = 2 * k_wall_radius;
  for (int tries = 0; tries < 60000 && placed.size() < 4096; ++tries) {
    const auto t =
        static_cast<std::size_t>(std::lower_bound(area.begin(), area.end(), random() * area.back()) - area.begin());
    const auto corner = [&](std::size_t k) {
      return surface.points[static_cast<std::size_t>(surface.triangles[t][k])];
    };
    double u = random(), v = random();
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const Vec3 a = corner(0), e = corner(1) - a, f = corner(2) - a, n = cross(e, f);
    const double side = c.offset > 1 && random() < 0.5 ? -1 : 1;
    const Vec3 x = a + u * e + v * f + (side * c.offset * edge / norm(n)) * n;
    bool free = true;
    for (int k = 0; k < 3; ++k) free = free && x[k] > edge && x[k] < size[k] - edge;
    for (std::size_t k = 0; free && k < placed.size(); ++k) free = norm2(placed[k] - x) > edge * edge;
    if (!free) continue;
    placed.push_back(x);
    state.add(x, k_wall_radius);
  }
  return simulate(state, size, {}, wall, 3);
}

}  // namespace talus::perf
