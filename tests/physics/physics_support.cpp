// Scenes and small measuring helpers of the physics tests; see physics_support.hpp.
#include "physics_support.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <stdexcept>

namespace talus::physics {
namespace {

/// One folder per process, removed at exit; ctest runs tests of this folder as separate processes at the same time.
class TempFolder {
 public:
  TempFolder() : path_(std::filesystem::temp_directory_path() / fmt::format("talus-physics-{}", getpid())) {
    std::filesystem::create_directories(path_);
  }
  ~TempFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  std::string next(const char* extension) { return (path_ / fmt::format("file-{}.{}", count_++, extension)).string(); }

 private:
  std::filesystem::path path_;
  int count_ = 0;
};

TempFolder& folder() {
  static TempFolder f;
  return f;
}

}  // namespace

Scene open_scene(Vec3 lower, Vec3 upper, double dt) {
  Scene s;
  s.domain.lower = lower;
  s.domain.upper = upper;
  for (auto& axis : s.domain.boundary) axis = {Boundary::open, Boundary::open};
  s.dt = dt;
  s.materials = {{"grain", 2500, 0, 0}};
  s.pairs.assign(1, {});
  s.contact.friction = false;
  return s;
}

void add_grains(Scene& scene, const std::vector<Grain>& grains) {
  const std::string path = folder().next("csv");
  std::FILE* out = std::fopen(path.c_str(), "w");
  ASSERT_NE(out, nullptr) << path;
  fmt::print(out, "x,y,z,radius,vx,vy,vz,wx,wy,wz,material,fixed\n");
  for (const Grain& g : grains) {
    fmt::print(out, "{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{},{}\n", g.x.x,
               g.x.y, g.x.z, g.r, g.v.x, g.v.y, g.v.z, g.w.x, g.w.y, g.w.z, g.material, g.fixed ? 1 : 0);
  }
  std::fclose(out);
  Source s;
  s.kind = Source::Kind::file;
  s.name = "grains";
  s.file = path;
  scene.sources.push_back(s);
}

void linear_law(Scene& scene, double kn, double gn, double kt, double gt, double mu) {
  scene.contact.model = ContactModel::linear;
  scene.contact.by_restitution = false;
  scene.contact.normal_stiffness = kn;
  scene.contact.normal_damping = gn;
  scene.contact.tangential_stiffness = kt;
  scene.contact.tangential_damping = gt;
  scene.contact.friction = kt > 0;
  for (PairCoefficients& p : scene.pairs) p = {mu, -1};
}

void linear_restitution(Scene& scene, double kn, double e, double kt, double mu) {
  linear_law(scene, kn, 0, kt, 0, mu);
  scene.contact.by_restitution = true;
  for (PairCoefficients& p : scene.pairs) p.restitution = e;
}

void hertz_law(Scene& scene, double e, double mu) {
  scene.contact.model = ContactModel::hertz_mindlin;
  scene.contact.by_restitution = true;
  scene.contact.friction = mu > 0;
  scene.pairs.assign(scene.materials.size() * scene.materials.size(), {mu, e});
}

WallSpec plane(const std::string& name, Vec3 point, Vec3 normal, int material) {
  WallSpec w;
  w.name = name;
  w.shape = WallShape::plane;
  w.point = point;
  w.normal = normal;
  w.material = material;
  return w;
}

std::string mesh_file(const std::vector<Vec3>& points, const std::vector<std::array<int, 3>>& facets) {
  std::string text;
  for (const Vec3 p : points) text += fmt::format("v {:.17g} {:.17g} {:.17g}\n", p.x, p.y, p.z);
  for (const auto& f : facets) text += fmt::format("f {} {} {}\n", f[0] + 1, f[1] + 1, f[2] + 1);
  const std::string path = folder().next("obj");
  std::FILE* out = std::fopen(path.c_str(), "w");
  if (out == nullptr) throw std::runtime_error("cannot write " + path);
  fmt::print(out, "{}", text);
  std::fclose(out);
  return path;
}

std::string flat_mesh(double x0, double x1, double y0, double y1, int nx, int ny) {
  std::string text;
  for (int y = 0; y <= ny; ++y)
    for (int x = 0; x <= nx; ++x)
      text += fmt::format("v {:.17g} {:.17g} 0\n", x0 + (x1 - x0) * x / nx, y0 + (y1 - y0) * y / ny);
  for (int y = 0; y < ny; ++y)
    for (int x = 0; x < nx; ++x) {
      const int a = y * (nx + 1) + x + 1, b = a + nx + 1;
      text += fmt::format("f {} {} {}\nf {} {} {}\n", a, a + 1, b + 1, a, b + 1, b);
    }
  const std::string path = folder().next("obj");
  std::FILE* out = std::fopen(path.c_str(), "w");
  if (out == nullptr) throw std::runtime_error("cannot write " + path);
  fmt::print(out, "{}", text);
  std::fclose(out);
  return path;
}

double sphere_mass(double density, double r) { return density * (4.0 / 3.0 * k_pi) * (r * r * r); }

RunOptions options() {
  RunOptions o;
  o.threads = 1;
  return o;
}

double quantile(std::vector<double> values, double q) {
  std::sort(values.begin(), values.end());
  const auto last = static_cast<double>(values.size() - 1);
  return values[static_cast<std::size_t>(std::lround(q * last))];
}

double log_slope(const std::vector<double>& x, const std::vector<double>& y) {
  double sx = 0, sy = 0, sxx = 0, sxy = 0;
  const auto n = static_cast<double>(x.size());
  for (std::size_t k = 0; k < x.size(); ++k) {
    const double a = std::log(x[k]), b = std::log(y[k]);
    sx += a;
    sy += b;
    sxx += a * a;
    sxy += a * b;
  }
  return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

void figure(const std::string& name, double value, const std::string& note) {
  std::printf("[figure] %-64s %12.5g %s\n", name.c_str(), value, note.c_str());
  std::fflush(stdout);
}

double uniform(std::uint64_t seed, std::uint64_t k) {
  std::uint64_t z = seed * 0x9e3779b97f4a7c15ULL + (k + 1) * 0xd1342543de82ef95ULL;  // splitmix64
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  z ^= z >> 31;
  return static_cast<double>(z >> 11) * 0x1.0p-53;
}

}  // namespace talus::physics
