// The output folder: whole or absent, never over somebody's files, two checkpoints.
#include "core/io/run_folder.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>

#include "core/io/atomic_file.hpp"
#include "tests/io/output_frames.hpp"

namespace talus {
namespace {

namespace fs = std::filesystem;
using test::slurp;
using test::spill;
using test::TemporaryFolder;

std::size_t entries(const std::string& dir) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(dir), fs::directory_iterator()));
}

ErrorCode refusal(const std::string& dir, bool overwrite = false) {
  try {
    RunFolder::create(dir, "new", overwrite);
  } catch (const Error& e) {
    return e.code();
  }
  ADD_FAILURE() << "accepted " << dir;
  return ErrorCode::scene;
}

TEST(RunFolder, AppearsWithTheSceneAndItsLockAndNothingElse) {
  TemporaryFolder t;
  const auto f = RunFolder::create(t / "a/b/out/", "title = 1\n");
  EXPECT_EQ(f.dir(), t / "a/b/out");
  EXPECT_EQ(slurp(t / "a/b/out/scene.toml"), "title = 1\n");
  EXPECT_EQ(entries(t / "a/b"), 1u);
  EXPECT_EQ(entries(t / "a/b/out"), 2u);  // and its lock
  EXPECT_EQ(RunFolder::open(t / "a/b/out").series(), t / "a/b/out/series.csv");
}

TEST(RunFolder, RefusesContentUnlessAskedAndForeignFilesAlways) {
  TemporaryFolder t;
  { RunFolder::create(t / "out", "old"); }
  spill(t / "out/series.csv", "data");
  EXPECT_EQ(refusal(t / "out"), ErrorCode::usage);
  EXPECT_EQ(slurp(t / "out/series.csv"), "data");
  spill(t / "out/thesis.tex", "mine");
  EXPECT_EQ(refusal(t / "out", true), ErrorCode::usage);
  EXPECT_EQ(slurp(t / "out/thesis.tex"), "mine");
  EXPECT_EQ(slurp(t / "out/scene.toml"), "old");
  fs::remove(t / "out/thesis.tex");
  RunFolder::create(t / "out", "new", true);
  EXPECT_EQ(slurp(t / "out/scene.toml"), "new");
  EXPECT_EQ(entries(t / "out"), 2u);
  EXPECT_EQ(entries(t.path()), 1u);  // no scratch
  spill(t / "file", "x");
  EXPECT_EQ(refusal(t / "file"), ErrorCode::usage);
  EXPECT_EQ(refusal("", true), ErrorCode::usage);
}

TEST(RunFolder, EmptyFolderIsUsedInPlace) {
  TemporaryFolder t;
  fs::create_directory(t / "out");
  auto f = RunFolder::create(t / "out", "s");
  EXPECT_EQ(slurp(t / "out/scene.toml"), "s");
  f.discard();
  EXPECT_TRUE(fs::is_empty(t / "out"));
}

/// Every write fails.
class NoSpace : public FileCalls {
 public:
  ssize_t write(int, const void*, std::size_t) override {
    errno = ENOSPC;
    return -1;
  }
};

TEST(RunFolder, NothingRemainsAfterAnError) {
  TemporaryFolder t;
  RunFolder::create(t / "old", "old");
  NoSpace disk;
  ScopedFileCalls scope(disk);
  EXPECT_EQ(refusal(t / "out"), ErrorCode::io);
  EXPECT_EQ(refusal(t / "old", true), ErrorCode::io);
  EXPECT_EQ(slurp(t / "old/scene.toml"), "old");
  EXPECT_EQ(entries(t.path()), 1u);
}

TEST(RunFolder, DiscardRemovesOnlyWhatThisRunCreated) {
  TemporaryFolder t;
  auto f = RunFolder::create(t / "out", "s");
  auto again = RunFolder::open(t / "out");
  again.discard();
  EXPECT_TRUE(fs::exists(t / "out/scene.toml"));
  f.discard();
  EXPECT_FALSE(fs::exists(t / "out"));
}

TEST(RunFolder, OpenRefusesWhatIsNoRun) {
  TemporaryFolder t;
  EXPECT_THROW(RunFolder::open(t / "none"), Error);
  EXPECT_THROW(RunFolder::open(t.path()), Error);
}

TEST(RunFolder, IsLockedAsLongAsSomebodyWritesIntoIt) {
  TemporaryFolder t;
  {
    const auto f = RunFolder::create(t / "out", "s");
    const auto copy = f;
    EXPECT_FALSE(FolderLock::holder(t / "out").empty());
    EXPECT_THROW(RunFolder::resume(t / "out"), Error);
    EXPECT_EQ(refusal(t / "out", true), ErrorCode::io);
    EXPECT_EQ(RunFolder::open(t / "out").dir(), t / "out") << "reading needs no lock";
  }
  EXPECT_EQ(FolderLock::holder(t / "out"), "");
  const auto again = RunFolder::resume(t / "out");
  EXPECT_NE(FolderLock::holder(t / "out").find(std::to_string(getpid())), std::string::npos);
}

TEST(RunFolder, ResumeRemovesMarkedScratchAndNothingThatLooksLikeIt) {
  TemporaryFolder t;
  { RunFolder::create(t / "out", "s"); }
  for (const char* name :
       {".talus-0123456789abcdef", "a.tmp", "summary.json.tmp", ".talus-notes", ".talus-0123456789ABCDEF"})
    spill(t / "out/" + name, "x");
  RunFolder::resume(t / "out");
  EXPECT_FALSE(fs::exists(t / "out/.talus-0123456789abcdef"));
  EXPECT_EQ(entries(t / "out"), 6u);
}

TEST(RunFolder, OverwritingKeepsTheFolderWhereSomethingElseIsInIt) {
  TemporaryFolder t;
  { RunFolder::create(t / "out", "old"); }
  fs::create_directory(t / "out/vtp");
  spill(t / "out/vtp/particles-000000000001.vtp", "frame");
  spill(t / "out/vtp/notes.vtp", "mine");
  EXPECT_EQ(refusal(t / "out", true), ErrorCode::usage);
  fs::remove(t / "out/vtp/notes.vtp");
  spill(t / "out/other.pvd", "mine");
  EXPECT_EQ(refusal(t / "out", true), ErrorCode::usage);
  fs::remove(t / "out/other.pvd");
  RunFolder::create(t / "out", "new", true);
  EXPECT_FALSE(fs::exists(t / "out/vtp"));
  EXPECT_EQ(entries(t.path()), 1u);
}

TEST(RunFolder, NamesAsideAreNewAndBelongToTheRun) {
  TemporaryFolder t;
  {
    const auto f = RunFolder::create(t / "out", "s");
    spill(f.series(), "one");
    EXPECT_EQ(f.set_aside(f.series(), 40), t / "out/series-until-40.csv");
    spill(f.series(), "two");
    EXPECT_EQ(f.set_aside(f.series(), 40), t / "out/series-until-40-2.csv");
    EXPECT_EQ(slurp(t / "out/series-until-40.csv"), "one");
  }
  EXPECT_NO_THROW(RunFolder::check(t / "out", true));
  spill(t / "out/thesis-until-40.csv", "mine");
  EXPECT_THROW(RunFolder::check(t / "out", true), Error);
}

TEST(RunFolder, KeepsTheTwoNewestCheckpoints) {
  TemporaryFolder t;
  const auto f = RunFolder::create(t / "out", "s");
  EXPECT_FALSE(f.newest_checkpoint().has_value());
  for (std::int64_t step : {90, 100, 1000, 1100}) {
    CheckpointWriter w;
    w.add_value("step", step);
    f.save_checkpoint(w, step);
  }
  EXPECT_EQ(f.checkpoints(), (std::vector<std::int64_t>{1000, 1100}));
  EXPECT_EQ(f.newest_checkpoint()->reader.read_value<std::int64_t>("step"), 1100);
}

TEST(RunFolder, DamagedNewestCheckpointFallsBackToTheOneBefore) {
  TemporaryFolder t;
  const auto f = RunFolder::create(t / "out", "s");
  CheckpointWriter w;
  w.add_value("n", 1);
  f.save_checkpoint(w, 10);
  f.save_checkpoint(w, 20);
  fs::resize_file(f.checkpoint(20), 30);
  const auto loaded = f.newest_checkpoint();
  ASSERT_TRUE(loaded);
  EXPECT_EQ(loaded->step, 10);
  ASSERT_EQ(loaded->skipped.size(), 1u);
  EXPECT_NE(loaded->skipped[0].find("checkpoint-20.tcp"), std::string::npos);
  f.save_checkpoint(w, 15);  // the resumed run: the damaged later one goes, 10 stays
  EXPECT_EQ(f.checkpoints(), (std::vector<std::int64_t>{10, 15}));
  fs::resize_file(f.checkpoint(10), 30);
  fs::resize_file(f.checkpoint(15), 30);
  EXPECT_THROW(f.newest_checkpoint(), Error);
}

TEST(RunFolder, FailedCheckpointKeepsBothOldOnes) {
  TemporaryFolder t;
  const auto f = RunFolder::create(t / "out", "s");
  CheckpointWriter w;
  w.add_value("n", 1);
  f.save_checkpoint(w, 10);
  f.save_checkpoint(w, 20);
  {
    NoSpace disk;
    ScopedFileCalls scope(disk);
    EXPECT_THROW(f.save_checkpoint(w, 30), Error);
  }
  EXPECT_EQ(f.checkpoints(), (std::vector<std::int64_t>{10, 20}));
  EXPECT_EQ(f.newest_checkpoint()->step, 20);
}

}  // namespace
}  // namespace talus
