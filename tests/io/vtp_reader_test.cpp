// Frames read back from .vtp and .pvd: every bit, every column; damaged files are refused.
#include "core/io/vtp_reader.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "core/base/error.hpp"
#include "core/io/particle_frames.hpp"
#include "core/io/vtkhdf.hpp"
#include "core/io/vtp.hpp"
#include "tests/io/output_frames.hpp"

namespace talus {
namespace {

using test::make_frame;
using test::TemporaryFolder;

const ParticleColumns k_all = ParticleColumns::all();

void expect_same(const Frame& a, const Frame& b) {
  EXPECT_EQ(a.step, b.step);
  EXPECT_EQ(a.time, b.time);
  EXPECT_TRUE(a.id == b.id && a.r == b.r && a.material == b.material && a.fixed == b.fixed);
  EXPECT_TRUE(a.coordination == b.coordination && a.stress == b.stress);
  ASSERT_EQ(a.x.size(), b.x.size());
  ASSERT_EQ(a.w.size(), b.w.size());
  for (std::size_t i = 0; i < a.x.size(); ++i) {
    EXPECT_EQ(norm2(a.x[i] - b.x[i]), 0);
    EXPECT_EQ(norm2(a.v[i] - b.v[i]), 0);
    EXPECT_EQ(norm2(a.w[i] - b.w[i]), 0);
  }
}

std::string refusal(const std::string& path) {
  try {
    read_vtp(path);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(VtpReader, ReturnsEveryColumnOfTheFrameThatWasWritten) {
  TemporaryFolder folder;
  for (const int n : {0, 1, 57}) {
    const Frame f = make_frame(8, n);
    const std::string path = folder / "particles-000000000008.vtp";
    write_vtp(path, particle_poly(f, k_all), f.time);
    expect_same(read_vtp(path), f);
  }
}

TEST(VtpReader, BothFormatsKeepTheColumnsOfParts) {
  TemporaryFolder folder;
  Frame f = make_frame(8, 3);
  f.extra = {{"temperature", "K", {300.5, 1e-300, 0.1}}, {"tracer", "", {1, 0, 0.25}}};
  const ParticleColumns columns = ParticleColumns::of(f);
  write_vtp(folder / "particles-000000000008.vtp", particle_poly(f, columns), f.time);
  VtkHdfWriter(folder / "particles.vtkhdf", columns).append(f);
  for (const char* name : {"particles-000000000008.vtp", "particles.vtkhdf"}) {
    const Frame back = ParticleFrames(folder / name).frame(0);
    ASSERT_EQ(back.extra.size(), 2U) << name;
    for (std::size_t k = 0; k < 2; ++k) {
      EXPECT_EQ(back.extra[k].name, f.extra[k].name);
      EXPECT_EQ(back.extra[k].values, f.extra[k].values);
    }
  }
}

TEST(VtpReader, BothFormatsOfARunGiveTheSameFrames) {
  TemporaryFolder folder;
  const auto write = [&](const std::vector<int>& hdf_steps, const std::vector<int>& vtp_steps) {
    VtkHdfWriter hdf(folder / "particles.vtkhdf", k_all);
    for (const int step : hdf_steps) hdf.append(make_frame(step, 30 - step));
    PvdCollection pvd(folder.path(), "particles");
    for (const int step : vtp_steps) {
      const Frame f = make_frame(step, 30 - step);
      write_vtp(pvd.path(step), particle_poly(f, k_all), f.time);
      pvd.add(step, f.time);
    }
  };
  write({0, 4, 9}, {0, 4, 9});
  const ParticleFrames a(folder / "particles.vtkhdf"), b(folder / "particles.pvd");
  ASSERT_EQ(a.steps().size(), 3u);
  ASSERT_EQ(b.steps().size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(a.steps()[k].step, b.steps()[k].step);
    EXPECT_EQ(a.steps()[k].time, b.steps()[k].time);
    expect_same(a.frame(k), b.frame(k));
  }
}

TEST(VtpReader, OfTwoFormatsTheOneThatGoesOnLongerCounts) {
  TemporaryFolder folder;
  EXPECT_FALSE(ParticleFrames::find(folder.path()));
  {
    VtkHdfWriter hdf(folder / "particles.vtkhdf", k_all);
    hdf.append(make_frame(4, 3));
  }
  EXPECT_EQ(ParticleFrames::find(folder.path()), folder / "particles.vtkhdf");
  PvdCollection pvd(folder.path(), "particles");
  for (const int step : {4, 9}) {
    write_vtp(pvd.path(step), particle_poly(make_frame(step, 3), k_all), step);
    pvd.add(step, step);
    EXPECT_EQ(ParticleFrames::find(folder.path()), folder / "particles.pvd");
  }
  auto hdf = VtkHdfWriter::resume(folder / "particles.vtkhdf", k_all, VtkHdfWriter::Content::particles, 4);
  hdf.append(make_frame(12, 3));
  EXPECT_EQ(ParticleFrames::find(folder.path()), folder / "particles.vtkhdf");
}

TEST(VtpReader, DamagedAndForeignFilesAreRefusedWithTheReason) {
  TemporaryFolder folder;
  const std::string path = folder / "p-4.vtp";
  write_vtp(path, particle_poly(make_frame(4, 20), k_all), 1);
  const std::string good = test::slurp(path);
  ASSERT_EQ(refusal(path), "");
  for (const std::size_t size : {std::size_t{0}, std::size_t{10}, good.size() / 2, good.size() - 1}) {
    test::spill(path, good.substr(0, size));
    EXPECT_NE(refusal(path), "") << size;
  }
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    test::spill(path, text.replace(at, from.size(), to));
    return refusal(path);
  };
  EXPECT_NE(with("NumberOfPoints=\"20\"", "NumberOfPoints=\"21\"").find("another length"), std::string::npos);
  EXPECT_NE(with("NumberOfPoints=\"20\"", "NumberOfPoints=\"-1\""), "");
  EXPECT_NE(with("NumberOfPoints=\"20\"", "NumberOfPoints=\"99999999999999999999\""), "");
  EXPECT_NE(with("Name=\"radius\"", "Name=\"rad_us\"").find("'radius'"), std::string::npos);
  EXPECT_NE(with("UInt64", "UInt32").find("another program"), std::string::npos);
  EXPECT_NE(with("offset=\"0\"", "offset=\"9999999\""), "");
}

TEST(PvdReaderTest, ListsThatNameMissingFilesOrAreCutAreRefused) {
  TemporaryFolder folder;
  PvdCollection pvd(folder.path(), "particles");
  for (const int step : {0, 4}) {
    write_vtp(pvd.path(step), particle_poly(make_frame(step, 3), k_all), step);
    pvd.add(step, step);
  }
  const std::string list = folder / "particles.pvd", text = test::slurp(list);
  EXPECT_EQ(PvdReader(list).steps().size(), 2u);
  test::spill(list, text.substr(0, text.size() - 4));
  EXPECT_THROW(PvdReader{list}, Error);
  test::spill(list, text);
  std::filesystem::remove(pvd.path(4));
  EXPECT_THROW(PvdReader{list}, Error);
}

}  // namespace
}  // namespace talus
