// Checkpoint container: round trip, and every kind of damage is an Error.
#include "core/io/checkpoint.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <limits>

#include "tests/io/output_frames.hpp"

namespace talus {
namespace {

using test::slurp;
using test::spill;
using test::TemporaryFolder;

CheckpointWriter example() {
  CheckpointWriter w;
  const double x[] = {1.5, -0.0, std::numeric_limits<double>::denorm_min(), 1e300};
  const std::int32_t ids[] = {7, -1, 3};
  w.add_array("particles/x", x, 4);
  w.add_array("ids", ids, 3);
  w.add("empty", {});
  w.add_value("step", std::int64_t{123456789012});
  return w;
}

void expect_error(const std::string& path, const std::string& why) {
  try {
    CheckpointReader r(path);
    ADD_FAILURE() << "accepted: " << why;
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::io) << why;
    EXPECT_NE(std::string(e.what()).find(path), std::string::npos) << why;
  }
}

TEST(Checkpoint, RoundTripKeepsEveryBit) {
  TemporaryFolder folder;
  const std::string path = folder / "c.tcp";
  example().commit(path);
  CheckpointReader r(path);
  std::vector<double> x;
  r.read_array<double>("particles/x", x);
  ASSERT_EQ(x.size(), 4u);
  EXPECT_EQ(x[0], 1.5);
  EXPECT_TRUE(std::signbit(x[1]));
  EXPECT_EQ(x[2], std::numeric_limits<double>::denorm_min());
  EXPECT_EQ(x[3], 1e300);
  std::vector<std::int32_t> ids;
  r.read_array<std::int32_t>("ids", ids);
  EXPECT_EQ(ids, (std::vector<std::int32_t>{7, -1, 3}));
  EXPECT_TRUE(r.has("empty"));
  EXPECT_TRUE(r.section("empty").empty());
  EXPECT_EQ(r.read_value<std::int64_t>("step"), 123456789012);
  EXPECT_FALSE(r.has("absent"));
  EXPECT_THROW(r.section("absent"), Error);
  EXPECT_THROW(r.read_value<std::int32_t>("step"), Error);
  EXPECT_THROW(r.read_array<double>("ids", x), Error);
}

TEST(Checkpoint, SectionsStayReadableAfterMovingTheReader) {
  TemporaryFolder folder;
  example().commit(folder / "c.tcp");
  CheckpointReader a(folder / "c.tcp");
  CheckpointReader b(std::move(a));
  EXPECT_EQ(b.read_value<std::int64_t>("step"), 123456789012);
}

TEST(Checkpoint, SameSectionsGiveSameBytes) {
  TemporaryFolder folder;
  example().commit(folder / "a.tcp");
  example().commit(folder / "b.tcp");
  EXPECT_EQ(slurp(folder / "a.tcp"), slurp(folder / "b.tcp"));
  EXPECT_EQ(slurp(folder / "a.tcp").substr(0, 8), "TALUSCP1");
}

TEST(Checkpoint, EveryFlippedBitIsAnError) {
  TemporaryFolder folder;
  const std::string path = folder / "c.tcp";
  example().commit(path);
  const std::string good = slurp(path);
  ASSERT_LT(good.size(), 400u);
  for (std::size_t i = 0; i < good.size(); ++i)
    for (int bit = 0; bit < 8; ++bit) {
      std::string bad = good;
      bad[i] = static_cast<char>(bad[i] ^ (1 << bit));
      spill(path, bad);
      expect_error(path, "bit " + std::to_string(bit) + " of byte " + std::to_string(i));
    }
}

TEST(Checkpoint, EveryByteValueInEveryHeaderByteIsAnError) {
  TemporaryFolder folder;
  const std::string path = folder / "c.tcp";
  example().commit(path);
  const std::string good = slurp(path);
  // Magic, count, and the header of the first section (name length, name, size, checksum).
  for (std::size_t i = 0; i < 8 + 4 + 2 + 11 + 8 + 8; ++i)
    for (int value : {0x00, 0x01, 0x7f, 0x80, 0xff}) {
      std::string bad = good;
      if (bad[i] == static_cast<char>(value)) continue;
      bad[i] = static_cast<char>(value);
      spill(path, bad);
      expect_error(path, "value " + std::to_string(value) + " in byte " + std::to_string(i));
    }
}

TEST(Checkpoint, EveryTruncationIsAnError) {
  TemporaryFolder folder;
  const std::string path = folder / "c.tcp";
  example().commit(path);
  const std::string good = slurp(path);
  for (std::size_t n = 0; n < good.size(); ++n) {
    spill(path, good.substr(0, n));
    expect_error(path, "cut to " + std::to_string(n));
  }
  spill(path, good + "x");
  expect_error(path, "one byte more");
}

TEST(Checkpoint, MissingFileFolderAndOtherVersionsAreErrors) {
  TemporaryFolder folder;
  expect_error(folder / "none.tcp", "missing");
  expect_error(folder.path(), "a folder");
  CheckpointWriter().commit(folder / "c.tcp");
  EXPECT_NO_THROW(CheckpointReader(folder / "c.tcp"));
  std::string other = slurp(folder / "c.tcp");
  other[7] = '2';
  spill(folder / "c.tcp", other);
  try {
    CheckpointReader r(folder / "c.tcp");
    FAIL() << "accepted";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("version"), std::string::npos) << e.what();
  }
}

TEST(Checkpoint, DuplicateAndUnnamedSectionsAreRefused) {
  CheckpointWriter w;
  w.add("a", {1});
  EXPECT_THROW(w.add("a", {2}), Error);
  EXPECT_THROW(w.add("", {2}), Error);
  EXPECT_THROW(w.add(std::string(70000, 'n'), {2}), Error);
}

TEST(Checkpoint, KilledWriterLeavesAWholeFile) {
  TemporaryFolder folder;
  const std::string path = folder / "c.tcp";
  for (int round = 0; round < 15; ++round) {
    std::filesystem::remove(path);
    std::vector<std::int64_t> body(50000, 0);
    CheckpointWriter first;
    first.add_array("body", body.data(), body.size());
    first.commit(path);
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      for (std::int64_t n = 1;; ++n) {
        std::fill(body.begin(), body.end(), n);
        CheckpointWriter w;
        w.add_array("body", body.data(), body.size());
        w.commit(path);
      }
    }
    usleep(static_cast<useconds_t>(500 + 1700 * round));
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    CheckpointReader r(path);
    std::vector<std::int64_t> got;
    r.read_array<std::int64_t>("body", got);
    ASSERT_EQ(got.size(), body.size());
    EXPECT_EQ(got.front(), got.back());
  }
}

}  // namespace
}  // namespace talus
