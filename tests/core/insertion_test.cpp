// Claims about sources: nothing overlaps, rates and limits hold, sizes follow their distribution, state can be resumed.
#include "core/grains/insertion.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>

#include "core/base/error.hpp"
#include "core/base/rng.hpp"

namespace talus {
namespace {

constexpr double k_pi = 3.14159265358979323846;

#define EXPECT_CONTAINS(text, part) EXPECT_NE(std::string(text).find(part), std::string::npos) << text

Scene box_scene(Boundary side = Boundary::wall) {
  Scene s;
  s.domain.lower = {-1, 2, 0};
  s.domain.upper = {1, 4, 2};
  for (auto& axis : s.domain.boundary) axis = {side, side};
  s.materials = {{"glass", 2500, 0, 0}, {"steel", 7800, 0, 0}};
  s.pairs.assign(4, {});
  s.dt = 1e-3;
  return s;
}

Source make_source(Source::Kind kind, const Scene& scene, double diameter) {
  Source s;
  s.kind = kind;
  s.name = "test";
  s.region = {scene.domain.lower, scene.domain.upper, 0};
  s.size.diameter = diameter;
  return s;
}

/// Squared distance by minimum image on periodic axes.
double distance2(const Domain& d, Vec3 a, Vec3 b) {
  Vec3 e = a - b;
  for (int k = 0; k < 3; ++k) {
    const double length = d.upper[k] - d.lower[k];
    if (d.periodic(k)) e[k] -= length * std::round(e[k] / length);
  }
  return norm2(e);
}

/// Overlapping pairs by brute force; depth beyond `slack` of the sum of radii counts.
int overlaps(const Domain& d, const NewParticles& a, const NewParticles& b, bool same, double slack) {
  int count = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t j = same ? i + 1 : 0; j < b.size(); ++j) {
      const double sum = (a.r[i] + b.r[j]) * (1 - slack);
      count += distance2(d, a.x[i], b.x[j]) < sum * sum;
    }
  }
  return count;
}

bool within(const Region& g, const NewParticles& p, bool centres_only = false) {
  for (std::size_t i = 0; i < p.size(); ++i) {
    const double r = centres_only ? 0 : p.r[i];
    for (int k = 0; k < 3; ++k) {
      if (p.x[i][k] < g.lower[k] + r * (1 - 1e-9) || p.x[i][k] > g.upper[k] - r * (1 - 1e-9)) return false;
    }
    const double dx = p.x[i].x - 0.5 * (g.lower.x + g.upper.x), dy = p.x[i].y - 0.5 * (g.lower.y + g.upper.y);
    if (g.radius > 0 && std::hypot(dx, dy) > (g.radius - r) * (1 + 1e-9)) return false;
  }
  return true;
}

std::vector<double> rows_of(const Scene& s, const NewParticles& p) {
  std::vector<double> rows;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const Vec3 x = p.x[i] - s.domain.lower;
    rows.insert(rows.end(), {x.x, x.y, x.z, p.r[i]});
  }
  return rows;
}

std::string refusal(const std::function<void()>& act) {
  try {
    act();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::scene);
    return e.what();
  }
  return "accepted";
}

TEST(Insertion, HexagonalLatticeFillsTheBoxWithoutOverlap) {
  Scene s = box_scene();
  s.sources = {make_source(Source::Kind::lattice, s, 0.1)};
  s.sources[0].spacing = 1;
  const NewParticles p = Insertion(s).initial();
  EXPECT_EQ(overlaps(s.domain, p, p, true, 1e-9), 0);
  EXPECT_TRUE(within(s.sources[0].region, p));
  const double fraction = static_cast<double>(p.size()) * k_pi / 6 * 1e-3 / 8;
  EXPECT_GT(fraction, 0.62);  // 0.74 less what the walls cut off
  EXPECT_LT(fraction, 0.7405);
}

TEST(Insertion, CubicLatticeHasOneParticlePerCell) {
  Scene s = box_scene();
  s.sources = {make_source(Source::Kind::lattice, s, 0.1)};
  s.sources[0].lattice = Source::Lattice::cubic;
  s.sources[0].spacing = 1.25;
  const NewParticles p = Insertion(s).initial();
  EXPECT_EQ(p.size(), 16u * 16 * 16);
  EXPECT_EQ(overlaps(s.domain, p, p, true, 0), 0);
}

TEST(Insertion, LatticeClosesOverPeriodicFaces) {
  for (auto lattice : {Source::Lattice::hexagonal, Source::Lattice::cubic}) {
    Scene s = box_scene(Boundary::periodic);
    s.sources = {make_source(Source::Kind::lattice, s, 0.13)};
    s.sources[0].lattice = lattice;
    const NewParticles p = Insertion(s).initial();
    EXPECT_GT(p.size(), 1000u);
    EXPECT_EQ(overlaps(s.domain, p, p, true, 1e-9), 0);
    EXPECT_TRUE(within(s.sources[0].region, p, true));
  }
}

TEST(Insertion, RandomPackDoesNotOverlapOverPeriodicFaces) {
  Scene s = box_scene(Boundary::periodic);
  Source source = make_source(Source::Kind::random, s, 0);
  source.size.kind = SizeDistribution::Kind::uniform;
  source.size.min = 0.05;
  source.size.max = 0.3;
  source.number = 600;
  source.group = 3;
  source.material = 1;
  s.sources = {source};
  const NewParticles p = Insertion(s).initial();
  ASSERT_EQ(p.size(), 600u);
  EXPECT_EQ(overlaps(s.domain, p, p, true, 0), 0);
  EXPECT_TRUE(within(source.region, p, true));
  int across = 0;
  for (std::size_t i = 0; i < p.size(); ++i) across += p.x[i].z < p.r[i] || p.x[i].z > 2 - p.r[i];
  EXPECT_GT(across, 20);  // some stick out through the face
  EXPECT_EQ(p.group[5], 3);
  EXPECT_EQ(p.material[5], 1);
}

TEST(Insertion, SourcesShareTheRoomAndTheCylinderHolds) {
  Scene s = box_scene();
  s.sources = {make_source(Source::Kind::lattice, s, 0.2), make_source(Source::Kind::random, s, 0.05)};
  s.sources[0].number = 300;
  s.sources[1].number = 1500;
  s.sources[1].region.radius = 0.9;
  const NewParticles p = Insertion(s).initial();
  ASSERT_EQ(p.size(), 1800u);
  EXPECT_EQ(overlaps(s.domain, p, p, true, 0), 0);
  NewParticles second;
  second.x.assign(p.x.begin() + 300, p.x.end());
  second.r.assign(p.r.begin() + 300, p.r.end());
  EXPECT_TRUE(within(s.sources[1].region, second));
}

TEST(Insertion, PackThatDoesNotFitSaysHowManyFitted) {
  Scene s = box_scene();
  s.sources = {make_source(Source::Kind::random, s, 0.4)};
  s.sources[0].number = 150;
  const std::string m = refusal([&] { Insertion(s).initial(); });
  EXPECT_CONTAINS(m, "source 'test': only ");
  EXPECT_CONTAINS(m, " of 150 particles fitted at random (solid fraction 0.");
  s.sources.push_back(make_source(Source::Kind::lattice, s, 0.4));  // among what the first has placed
  s.sources[0].number = 40;
  s.sources[1].number = 80;
  EXPECT_CONTAINS(refusal([&] { Insertion(s).initial(); }), "particles fitted on the lattice, 80 were asked for");
  s.sources.pop_back();
  s.sources[0].size.diameter = 3;
  EXPECT_CONTAINS(refusal([&] { Insertion{s}; }), "the region is 2 m wide, the largest particle 3 m");
}

TEST(Insertion, MassLimitIsMetToHalfAParticle) {
  Scene s = box_scene();
  s.sources = {make_source(Source::Kind::random, s, 0)};
  s.sources[0].size.kind = SizeDistribution::Kind::uniform;
  s.sources[0].size.min = 0.04;
  s.sources[0].size.max = 0.08;
  s.sources[0].mass = 300;
  const NewParticles p = Insertion(s).initial();
  double mass = 0;
  for (double r : p.r) mass += 2500 * 4.0 / 3.0 * k_pi * r * r * r;
  EXPECT_NEAR(mass, 300, 0.5 * 2500 * k_pi / 6 * 0.08 * 0.08 * 0.08);
}

TEST(Insertion, VelocityJitterIsUniformAboutTheVelocity) {
  Scene s = box_scene();
  s.sources = {make_source(Source::Kind::random, s, 0.02)};
  s.sources[0].number = 5000;
  s.sources[0].velocity = {1, 0, -2};
  s.sources[0].velocity_jitter = 0.5;
  const NewParticles p = Insertion(s).initial();
  Vec3 mean, low = p.v[0], high = p.v[0];
  for (const Vec3& v : p.v) {
    mean = mean + (1.0 / 5000) * v;
    for (int k = 0; k < 3; ++k) low[k] = std::min(low[k], v[k]), high[k] = std::max(high[k], v[k]);
  }
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(mean[k], s.sources[0].velocity[k], 0.02);
    EXPECT_NEAR(high[k] - low[k], 1, 0.01);
    EXPECT_LE(high[k], s.sources[0].velocity[k] + 0.5);
  }
}

// --- streams

Scene stream_scene() {
  Scene s = box_scene(Boundary::periodic);
  s.domain.boundary[2] = {Boundary::wall, Boundary::open};
  Source source = make_source(Source::Kind::stream, s, 0);
  source.region.lower.z = 1;
  source.size.kind = SizeDistribution::Kind::uniform;
  source.size.min = 0.05;
  source.size.max = 0.1;
  source.number_rate = 1500;
  source.interval = 0.0123;
  source.start = 0.05;
  s.sources = {source};
  return s;
}

TEST(InsertionStream, BatchesComeOnTimeAtTheRateWithoutOverlap) {
  Scene s = stream_scene();
  s.sources[0].end = 0.05 + 10 * 0.0123;
  Insertion insertion(s);
  EXPECT_EQ(insertion.initial().size(), 0u);
  NewParticles all;
  std::int64_t n = 0, batches = 0;
  while ((n = insertion.next_step(n)) != INT64_MAX) {
    EXPECT_EQ(n, std::llround((0.05 + batches * 0.0123) / 1e-3));
    std::vector<double> rows = rows_of(s, all);
    rows.insert(rows.end(), {1e200, 0, 0, 0.5});  // a dead row blocks nothing
    const NewParticles p = insertion.batch(n, {rows});
    EXPECT_EQ(overlaps(s.domain, p, p, true, 0), 0);
    EXPECT_EQ(overlaps(s.domain, p, all, false, 1e-12), 0);
    all.x.insert(all.x.end(), p.x.begin(), p.x.end());
    all.r.insert(all.r.end(), p.r.begin(), p.r.end());
    ++batches;
    ++n;
  }
  EXPECT_EQ(batches, 10);
  EXPECT_EQ(all.size(), static_cast<std::size_t>(1500 * 0.123));
  EXPECT_EQ(insertion.inserted(), static_cast<std::int64_t>(all.size()));
}

// rate (end - start), whatever share of an interval the end leaves to the last batch
TEST(InsertionStream, BringsWhatIsDueBetweenItsStartAndItsEnd) {
  for (const double time : {0.003, 0.0123, 0.02, 0.0877, 0.123}) {
    Scene s = stream_scene();
    s.sources[0].end = 0.05 + time;
    s.sources[0].size = {};
    s.sources[0].size.diameter = 0.02;
    Insertion insertion(s);
    std::int64_t n = 0;
    while ((n = insertion.next_step(n)) != INT64_MAX) insertion.batch(n++, {});
    EXPECT_EQ(insertion.inserted(), static_cast<std::int64_t>(1500 * time + 1e-6)) << time;
  }
}

TEST(InsertionStream, MassRateAndLimitsHold) {
  Scene s = stream_scene();
  s.sources[0].number_rate = 0;
  s.sources[0].mass_rate = 500;
  s.sources[0].mass = 40;
  Insertion insertion(s);
  double mass = 0;
  std::int64_t n = 0;
  int batches = 0;
  while ((n = insertion.next_step(n)) != INT64_MAX && batches < 100) {
    for (double r : insertion.batch(n, {}).r) mass += 2500 * 4.0 / 3.0 * k_pi * r * r * r;
    ++batches, ++n;
    EXPECT_LE(mass, 500 * 0.0123 * batches + 1e-9);
    if (batches < 7) {
      EXPECT_GT(mass, 500 * 0.0123 * batches - 1.4);
    }
  }
  EXPECT_EQ(batches, 7);  // 6.15 kg each
  EXPECT_NEAR(mass, 40, 0.5 * 2500 * k_pi / 6 * 1e-3);
}

TEST(InsertionStream, BlockedStreamDeliversLater) {
  Scene s = stream_scene();
  s.sources[0].size = {};
  s.sources[0].size.diameter = 0.1;
  s.sources[0].number_rate = 1000;
  Insertion insertion(s);
  const std::int64_t n = insertion.next_step(0);
  // A huge sphere fills the region, then is gone.
  const std::vector<double> block = {1, 1, 1.5, 1.8};
  const std::size_t blocked = insertion.batch(n, {block}).size();
  EXPECT_EQ(blocked, 0u);
  EXPECT_EQ(insertion.batch(insertion.next_step(n + 1), {}).size(), 24u);
}

TEST(InsertionStream, SavedStateContinuesBitForBit) {
  Scene s = stream_scene();
  s.sources[0].velocity_jitter = 1;
  Insertion whole(s), first(s);
  std::int64_t n = 0;
  for (int k = 0; k < 4; ++k, ++n) {
    n = whole.next_step(n);
    whole.batch(n, {});
    first.batch(n, {});
  }
  Insertion second(s);
  second.load(first.save());
  EXPECT_EQ(second.inserted(), whole.inserted());
  for (int k = 0; k < 4; ++k, ++n) {
    n = whole.next_step(n);
    ASSERT_EQ(second.next_step(n), n);
    const NewParticles a = whole.batch(n, {}), b = second.batch(n, {});
    ASSERT_EQ(a.size(), b.size());
    ASSERT_GT(a.size(), 0u);
    for (std::size_t i = 0; i < a.size(); ++i) {
      EXPECT_EQ(a.x[i].x, b.x[i].x);
      EXPECT_EQ(a.v[i].z, b.v[i].z);
      EXPECT_EQ(a.r[i], b.r[i]);
    }
  }
  try {
    second.load(std::vector<std::uint8_t>(7));
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::io);
  }
}

TEST(Insertion, LatePackComesOnceBesideWhatIsThere) {
  Scene s = box_scene();
  s.sources = {make_source(Source::Kind::lattice, s, 0.2)};
  s.sources[0].start = 0.5;
  Insertion insertion(s);
  EXPECT_EQ(insertion.initial().size(), 0u);
  EXPECT_EQ(insertion.next_step(0), 500);
  EXPECT_EQ(insertion.next_step(501), INT64_MAX);
  const std::vector<double> row = {1, 1, 1, 0.5};
  const NewParticles p = insertion.batch(500, {row});
  EXPECT_GT(p.size(), 300u);
  for (std::size_t i = 0; i < p.size(); ++i)
    EXPECT_GE(norm2(p.x[i] - s.domain.lower - Vec3{1, 1, 1}), 0.6 * 0.6 * (1 - 1e-8));
  EXPECT_EQ(insertion.next_step(0), INT64_MAX);
}

// --- size distributions

struct Moments {
  double mean_by_number = 0, mean_by_mass = 0, low = 1e9, high = 0;
};

Moments moments(const SizeDistribution& size) {
  const SizeSampler sampler(size);
  Moments m;
  double mass = 0;
  constexpr int n = 200000;  // stratified: u = (i + 1/2) / n
  for (int i = 0; i < n; ++i) {
    const double d = sampler.diameter((i + 0.5) / n);
    m.mean_by_number += d / n;
    m.mean_by_mass += d * d * d * d;
    mass += d * d * d;
    m.low = std::min(m.low, d);
    m.high = std::max(m.high, d);
  }
  m.mean_by_mass /= mass;
  return m;
}

TEST(SizeSampler, UniformMeanIsTheMiddleByNumberAndByMass) {
  SizeDistribution s;
  s.kind = SizeDistribution::Kind::uniform;
  s.min = 1, s.max = 3;
  EXPECT_NEAR(moments(s).mean_by_number, 2, 1e-6);
  s.by_mass = true;
  EXPECT_NEAR(moments(s).mean_by_mass, 2, 1e-5);
  EXPECT_NEAR(moments(s).low, 1, 1e-4);
  EXPECT_NEAR(moments(s).high, 3, 1e-3);
}

TEST(SizeSampler, NormalHasItsMeanAndWidth) {
  SizeDistribution s;
  s.kind = SizeDistribution::Kind::normal;
  s.mean = 2, s.stddev = 0.1, s.min = 1, s.max = 3;
  const SizeSampler sampler(s);
  EXPECT_NEAR(moments(s).mean_by_number, 2, 1e-6);
  EXPECT_NEAR(sampler.diameter(0.841344746), 2.1, 1e-5);  // one sigma
  EXPECT_NEAR(sampler.diameter(0.022750132), 1.8, 1e-5);  // two sigma
  s.by_mass = true;
  EXPECT_NEAR(moments(s).mean_by_mass, 2, 1e-5);
  EXPECT_LT(moments(s).mean_by_number, 1.99);
  s.by_mass = false;
  s.max = 2;  // half of the bell: mean = 2 - 0.1 sqrt(2 / pi)
  EXPECT_NEAR(moments(s).mean_by_number, 2 - 0.1 * std::sqrt(2 / k_pi), 1e-5);
  EXPECT_LE(moments(s).high, 2);
}

TEST(SizeSampler, LognormalHasItsMeanAndDeviationOfTheDiameter) {
  SizeDistribution s;
  s.kind = SizeDistribution::Kind::lognormal;
  s.mean = 1, s.stddev = 0.3, s.min = 0.05, s.max = 20;
  EXPECT_NEAR(moments(s).mean_by_number, 1, 2e-5);
  const SizeSampler sampler(s);
  double variance = 0;
  for (int i = 0; i < 100000; ++i) variance += std::pow(sampler.diameter((i + 0.5) / 100000) - 1, 2) / 100000;
  EXPECT_NEAR(std::sqrt(variance), 0.3, 1e-3);
  s.by_mass = true;
  EXPECT_NEAR(moments(s).mean_by_mass, 1, 1e-4);
}

TEST(SizeSampler, SieveClassesHoldTheirShareOfNumberOrMass) {
  SizeDistribution s;
  s.kind = SizeDistribution::Kind::sieve;
  s.edges = {1, 2, 3, 5};
  s.weights = {1, 0, 3};
  for (bool by_mass : {false, true}) {
    s.by_mass = by_mass;
    const SizeSampler sampler(s);
    double low = 0, all = 0;
    constexpr int n = 100000;
    for (int i = 0; i < n; ++i) {
      const double d = sampler.diameter((i + 0.5) / n);
      EXPECT_TRUE(d <= 2 || d >= 3);
      const double share = by_mass ? d * d * d : 1;
      all += share;
      low += d <= 2 ? share : 0;
    }
    EXPECT_NEAR(low / all, 0.25, 1e-4) << by_mass;
  }
}

TEST(SizeSampler, ConstantAndDegenerateRangesGiveOneSize) {
  SizeDistribution s;
  s.diameter = 0.7;
  EXPECT_EQ(SizeSampler(s).diameter(0.3), 0.7);
  s.kind = SizeDistribution::Kind::lognormal;
  s.min = s.max = s.mean = 0.4;
  s.stddev = 0.1;
  EXPECT_EQ(SizeSampler(s).diameter(0.9), 0.4);
}

// --- files

class FileSource : public ::testing::Test {
 protected:
  FileSource() : path_(std::filesystem::temp_directory_path() / fmt::format("talus_insertion_{}.csv", getpid())) {}
  ~FileSource() override { std::filesystem::remove(path_); }
  Scene scene(const std::string& rows, Boundary side = Boundary::wall) {
    std::ofstream(path_) << "x,y,z,r,vx,vy,vz,wx,wy,wz,fixed\n" << rows;
    Scene s = box_scene(side);
    s.sources = {make_source(Source::Kind::file, s, 0)};
    s.sources[0].file = path_;
    s.sources[0].material = 1;
    return s;
  }
  std::filesystem::path path_;
};

TEST_F(FileSource, RowsBecomeParticlesOfTheGroupOfTheSource) {
  Scene s = scene("0,3,0.5,0.1,1,2,3,4,5,6,0\n0,3,1,0.2,0,0,0,0,0,0,1\n");
  s.groups.resize(2);
  s.groups[1].fixed_in_file = true;
  s.sources[0].group = 0;
  Insertion insertion(s);
  EXPECT_EQ(insertion.smallest_radius(), 0.1);
  EXPECT_EQ(insertion.largest_radius(), 0.2);
  const NewParticles p = insertion.initial();
  ASSERT_EQ(p.size(), 2u);
  EXPECT_EQ(p.v[0].z, 3);
  EXPECT_EQ(p.w[0].x, 4);
  EXPECT_EQ(p.material[0], 1);
  EXPECT_EQ(p.fixed[0], 0);
  EXPECT_EQ(p.fixed[1], 1);
  EXPECT_EQ(p.group[0], 0);
  EXPECT_EQ(p.group[1], 0);  // a group of what is fixed in its file takes nobody away
  EXPECT_EQ(insertion.next_step(0), INT64_MAX);
}

TEST_F(FileSource, TilesRepeatTheFileInEqualPartsOfTheDomain) {
  Scene s = scene("0,2.25,0.5,0.1,1,2,3,4,5,6,1\n0,2.75,0.5,0.2,0,0,0,0,0,0,0\n", Boundary::periodic);
  s.groups.resize(1);
  s.groups[0].fixed_in_file = true;
  s.sources[0].tile = {1, 2, 1};
  Insertion insertion(s);
  const NewParticles p = insertion.initial();
  ASSERT_EQ(p.size(), 4u);
  EXPECT_EQ(insertion.inserted(), 4);
  for (std::size_t i = 2; i < 4; ++i) {
    EXPECT_EQ(p.x[i].y, p.x[i - 2].y + 1);  // the domain is 2 wide in y
    EXPECT_EQ(p.x[i].x, p.x[i - 2].x);
    EXPECT_EQ(p.x[i].z, p.x[i - 2].z);
    EXPECT_EQ(p.v[i].y, p.v[i - 2].y);
    EXPECT_EQ(p.w[i].z, p.w[i - 2].z);
    EXPECT_EQ(p.r[i], p.r[i - 2]);
    EXPECT_EQ(p.material[i], 1);
    EXPECT_EQ(p.fixed[i], p.fixed[i - 2]);
    EXPECT_EQ(p.group[i], p.group[i - 2]);
  }
}

TEST_F(FileSource, FileBeyondTheFirstTileIsRefusedByRow) {
  Scene s = scene("0,2.5,0.5,0.1,0,0,0,0,0,0,0\n0,3.25,1,0.1,0,0,0,0,0,0,0\n");
  s.sources[0].tile = {1, 2, 1};
  const std::string m = refusal([&] { Insertion{s}; });
  EXPECT_CONTAINS(m, path_.string() + ":3: y = 3.25 lies outside the first tile (allowed: 2 to 3)");
}

TEST_F(FileSource, OverlapAcrossTilesNamesBothTiles) {
  // free in one tile, but the copies meet at the tile's face
  Scene s = scene("0,2.05,0.5,0.1,0,0,0,0,0,0,0\n0,2.95,0.5,0.1,0,0,0,0,0,0,0\n");
  Insertion{s}.initial();
  s.sources[0].tile = {1, 2, 1};
  const std::string m = refusal([&] { Insertion{s}.initial(); });
  EXPECT_CONTAINS(m, path_.string() + ":3 (tile 0, 0, 0) and " + path_.string() + ":2 (tile 0, 1, 0) by 0.1 m");
}

TEST_F(FileSource, TooManyTilesAreRefused) {
  Scene s = scene("0,2.0001,0.5,0.1,0,0,0,0,0,0,0\n");
  s.sources[0].tile = {10000, 10000, 10000};
  const std::string m = refusal([&] { Insertion{s}; });
  EXPECT_CONTAINS(m, "1000000000000 tiles of 1 particles are too many");
}

TEST_F(FileSource, RelativePathsStartAtTheScenesDirectory) {
  Scene s = scene("0,3,0.5,0.1,0,0,0,0,0,0,0\n");
  s.directory = path_.parent_path();
  s.sources[0].file = path_.filename();
  EXPECT_EQ(Insertion(s).initial().size(), 1u);
}

TEST_F(FileSource, ParticleOutsideTheDomainIsRefusedByRow) {
  Scene s = scene("0,3,0.5,0.1,0,0,0,0,0,0,0\n0,4.5,1,0.1,0,0,0,0,0,0,0\n");
  const std::string m = refusal([&] { Insertion{s}; });
  EXPECT_CONTAINS(m, path_.string() + ":3: y = 4.5 lies outside the domain (allowed: 2 to 4)");
}

TEST_F(FileSource, DeepInitialOverlapsAreListedByRow) {
  const std::string rows =
      "0,3,1,0.1,0,0,0,0,0,0,0\n0.199,3,1,0.1,0,0,0,0,0,0,0\n"  // 1 % of the radius: a static overlap
      "0,3,0.5,0.1,0,0,0,0,0,0,0\n0.19,3,0.5,0.1,0,0,0,0,0,0,0\n";
  Scene s = scene(rows);
  const std::string m = refusal([&] { Insertion(s).initial(); });
  EXPECT_CONTAINS(m, "1 initial overlaps deeper than 0.05");
  EXPECT_CONTAINS(m, ":4 and " + path_.string() + ":5 by 0.01 m (0.1 of the smaller radius)");
  s.allow_initial_overlap = true;
  EXPECT_EQ(Insertion(s).initial().size(), 4u);
  s.max_overlap = 0.08;
  EXPECT_CONTAINS(refusal([&] { Insertion(s).initial(); }), "deeper than 0.08");
}

TEST_F(FileSource, OverlapsOverPeriodicFacesAndCoincidentCentresAreFound) {
  Scene s = scene("-0.95,3,1,0.1,0,0,0,0,0,0,0\n0.95,3,1,0.1,0,0,0,0,0,0,0\n", Boundary::periodic);
  EXPECT_CONTAINS(refusal([&] { Insertion(s).initial(); }), "1 initial overlaps");
  std::string same;
  for (int i = 0; i < 5000; ++i) same += "0,3,1,0.1,0,0,0,0,0,0,0\n";
  Scene heap = scene(same);
  EXPECT_CONTAINS(refusal([&] { Insertion(heap).initial(); }), "at least 1000 initial overlaps");
}

TEST_F(FileSource, EveryOverlapOfARandomMixIsFound) {
  const CounterRng rng(3, 1);
  std::string rows;
  NewParticles p;
  for (int i = 0; i < 300; ++i) {
    const double r = i % 10 == 0 ? 0.2 : 0.004 + 0.04 * rng.uniform(4 * i + 3);
    p.x.push_back({rng.uniform(4 * i, -1, 1), rng.uniform(4 * i + 1, 2, 4), rng.uniform(4 * i + 2, 0, 2)});
    p.r.push_back(r);
    rows += fmt::format("{},{},{},{},0,0,0,0,0,0,0\n", p.x[i].x, p.x[i].y, p.x[i].z, r);
  }
  Scene s = scene(rows, Boundary::periodic);
  s.max_overlap = 1e-12;
  const int expected = overlaps(s.domain, p, p, true, 0);
  ASSERT_GT(expected, 5);
  EXPECT_CONTAINS(refusal([&] { Insertion(s).initial(); }), fmt::format(": {} initial overlaps", expected));
}

TEST(Insertion, HalfAMillionParticlesArePackedInSeconds) {
  Scene s = box_scene();
  s.sources = {make_source(Source::Kind::random, s, 0.017)};
  s.sources[0].number = 500000;  // solid fraction 0.16
  const auto start = std::chrono::steady_clock::now();
  const std::size_t size = Insertion(s).initial().size();
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  EXPECT_EQ(size, 500000u);
  EXPECT_LT(seconds, 20);  // a loose bound: quadratic work would take hours
  RecordProperty("seconds", std::to_string(seconds));
}

}  // namespace
}  // namespace talus
