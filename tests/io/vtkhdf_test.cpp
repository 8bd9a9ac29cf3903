// VTKHDF files, checked by an independent reader (check_vtkhdf.py, h5py): schema, offsets, values, resume, kills.
#include "core/io/vtkhdf.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>

#include "core/base/error.hpp"
#include "core/io/watched_file.hpp"
#include "tests/io/output_frames.hpp"

namespace talus {
namespace {

using test::make_frame;
using test::python;
using test::slurp;
using test::TemporaryFolder;
using Content = VtkHdfWriter::Content;

const ParticleColumns k_all = ParticleColumns::all();

TEST(VtkHdf, ParticlesOfVaryingNumberMatchTheFormat) {
  TemporaryFolder folder;
  {
    VtkHdfWriter w(folder / "p.vtkhdf", k_all);
    for (auto [step, n] : {std::pair{0, 5}, {10, 5000}, {20, 12}, {30, 12}}) w.append(make_frame(step, n));
    EXPECT_EQ(w.frames(), 4);
    EXPECT_EQ(w.last_step(), 30);
  }
  EXPECT_TRUE(python("check_vtkhdf.py", folder / "p.vtkhdf" + " particles 0:5 10:5000 20:12 30:12"));
}

TEST(VtkHdf, CheckerRejectsAnotherFrame) {  // the checker itself must be able to fail
  TemporaryFolder folder;
  { VtkHdfWriter(folder / "p.vtkhdf", k_all).append(make_frame(10, 5)); }
  EXPECT_TRUE(python("check_vtkhdf.py", folder / "p.vtkhdf" + " particles 10:5"));
  EXPECT_FALSE(python("check_vtkhdf.py", folder / "p.vtkhdf" + " particles 11:5 2>/dev/null"));
  EXPECT_FALSE(python("check_vtkhdf.py", folder / "p.vtkhdf" + " particles 10:4 2>/dev/null"));
}

TEST(VtkHdf, EmptyFramesAnywhereKeepOffsetsRightForOldAndNewReaders) {
  TemporaryFolder folder;
  {
    VtkHdfWriter w(folder / "p.vtkhdf", {}), walls(folder / "w.vtkhdf", {}, Content::walls);
    const int counts[] = {0, 0, 4, 7, 0, 3, 0, 0};
    for (int k = 0; k < 8; ++k) {
      w.append(make_frame(k, counts[k]));
      walls.append(make_frame(k, 0, counts[k]));
    }
  }
  EXPECT_TRUE(python("check_vtkhdf.py", folder / "p.vtkhdf" + " particles 0:0 1:0 2:4 3:7 4:0 5:3 6:0 7:0"));
  EXPECT_TRUE(python("check_vtkhdf.py", folder / "w.vtkhdf" + " walls 0:0 1:0 2:4 3:7 4:0 5:3 6:0 7:0"));
}

TEST(VtkHdf, WallsAndContacts) {
  TemporaryFolder folder;
  {
    VtkHdfWriter walls(folder / "w.vtkhdf", {}, Content::walls), contacts(folder / "c.vtkhdf", {}, Content::contacts);
    for (int step : {0, 4}) {
      walls.append(make_frame(step, 3, 6));
      contacts.append(make_frame(step, 3 + step, 6));
    }
  }
  EXPECT_TRUE(python("check_vtkhdf.py", folder / "w.vtkhdf" + " walls 0:6 4:6"));
  EXPECT_TRUE(python("check_vtkhdf.py", folder / "c.vtkhdf" + " contacts 0:3 4:7"));
}

TEST(VtkHdf, ColumnsFollowTheSceneNotTheFrame) {
  TemporaryFolder folder;
  Frame bare = make_frame(0, 2);
  bare.w.clear();
  bare.material.clear();
  bare.fixed.clear();
  bare.coordination.clear();
  bare.stress.clear();
  VtkHdfWriter w(folder / "p.vtkhdf", {});
  EXPECT_NO_THROW(w.append(bare));
  VtkHdfWriter all(folder / "q.vtkhdf", k_all);
  EXPECT_THROW(all.append(bare), Error);
}

TEST(VtkHdf, ResumeDropsLaterFramesAndContinuesLikeAnUninterruptedRun) {
  for (std::int64_t resumed : {-1, 0, 10, 14, 20, 30, 99}) {
    TemporaryFolder folder;
    const std::string path = folder / "p.vtkhdf", whole = folder / "q.vtkhdf";
    const std::pair<int, int> plan[] = {{0, 3}, {10, 0}, {20, 6000}, {30, 2}, {40, 4}};
    {
      VtkHdfWriter w(path, k_all);
      for (int k = 0; k < 4; ++k) w.append(make_frame(plan[k].first, plan[k].second));
    }
    {
      auto w = VtkHdfWriter::resume(path, k_all, Content::particles, resumed);
      EXPECT_EQ(w.last_step(), resumed < 0 ? -1 : resumed >= 30 ? 30 : resumed / 10 * 10);
      for (auto [step, n] : plan)
        if (step > w.last_step()) w.append(make_frame(step, n));
    }
    EXPECT_TRUE(python("check_vtkhdf.py", path + " particles 0:3 10:0 20:6000 30:2 40:4")) << resumed;
  }
}

TEST(VtkHdf, ResumeRefusesOtherColumnsAndForeignFiles) {
  TemporaryFolder folder;
  { VtkHdfWriter(folder / "p.vtkhdf", k_all).append(make_frame(0, 3)); }
  const auto resume = [&](const std::string& name, const ParticleColumns& c, Content content = Content::particles) {
    try {
      VtkHdfWriter::resume(folder / name, c, content, 0);
      return ErrorCode::usage;  // accepted
    } catch (const Error& e) {
      return e.code();
    }
  };
  EXPECT_EQ(resume("p.vtkhdf", {}), ErrorCode::io);
  EXPECT_EQ(resume("p.vtkhdf", {}, Content::walls), ErrorCode::io);
  test::spill(folder / "junk.vtkhdf", "not an HDF5 file");
  EXPECT_EQ(resume("junk.vtkhdf", k_all), ErrorCode::io);
  EXPECT_EQ(resume("new.vtkhdf", k_all), ErrorCode::usage);  // a missing file is created
  EXPECT_THROW(VtkHdfWriter(folder / "none/p.vtkhdf", k_all), Error);
}

TEST(VtkHdf, StepsMustAscend) {
  TemporaryFolder folder;
  VtkHdfWriter w(folder / "p.vtkhdf", {});
  w.append(make_frame(5, 2));
  EXPECT_THROW(w.append(make_frame(5, 2)), Error);
  EXPECT_THROW(w.append(make_frame(4, 2)), Error);
  EXPECT_NO_THROW(w.append(make_frame(6, 2)));
}

TEST(VtkHdf, SameFramesGiveSameBytes) {
  TemporaryFolder folder;
  for (const char* name : {"a", "b"}) {
    VtkHdfWriter w(folder / name, k_all);
    for (int step : {0, 1, 2}) w.append(make_frame(step, 5000));
    if (*name == 'a') sleep(1);  // a creation date would differ by now
  }
  EXPECT_TRUE(slurp(folder / "a") == slurp(folder / "b"));
}

TEST(VtkHdf, ReadableWhileTheWriterHasItOpen) {
  TemporaryFolder folder;
  VtkHdfWriter w(folder / "p.vtkhdf", k_all);
  w.append(make_frame(0, 100));
  w.append(make_frame(1, 90));
  EXPECT_TRUE(python("check_vtkhdf.py", folder / "p.vtkhdf" + " particles 0:100 1:90"));
}

int entries(const TemporaryFolder& folder) {
  return static_cast<int>(std::distance(std::filesystem::directory_iterator(folder.path()), {}));
}

/// A limit on the size of files while it lives: as a full disk.
class NoRoom {
 public:
  explicit NoRoom(rlim_t bytes) {
    signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit now{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &now);
  }
  ~NoRoom() { setrlimit(RLIMIT_FSIZE, &before_); }

 private:
  rlimit before_{};
};

TEST(VtkHdf, WithoutRoomTheFileIsAsBeforeAndCanBeContinued) {
  TemporaryFolder folder;
  const std::string path = folder / "p.vtkhdf";
  {
    VtkHdfWriter w(path, k_all);
    w.append(make_frame(0, 100));
    const std::string before = test::slurp(path);
    {
      const NoRoom disk(before.size() + 1000);
      EXPECT_THROW(w.append(make_frame(1, 5000)), Error);
    }
    EXPECT_EQ(test::slurp(path), before);
    EXPECT_EQ(w.frames(), 1);
    w.append(make_frame(2, 800));  // there is room again
  }
  EXPECT_TRUE(python("check_vtkhdf.py", path + " particles 0:100 2:800"));
}

TEST(VtkHdf, WithoutRoomNoFileIsCreatedAndAnOldOneStays) {
  TemporaryFolder folder;
  const std::string path = folder / "p.vtkhdf";
  test::spill(path, "old");
  {
    const NoRoom disk(20000);
    EXPECT_THROW(VtkHdfWriter(path, k_all), Error);
  }
  EXPECT_EQ(test::slurp(path), "old");
  EXPECT_EQ(entries(folder), 1) << "no scratch is left";
}

TEST(VtkHdf, FilesThatOthersTouchedAreSeen) {
  TemporaryFolder folder;
  const std::string path = folder / "p.vtkhdf";
  const auto touched = [&](const std::function<void()>& touch) {
    VtkHdfWriter w(path, k_all);
    w.append(make_frame(0, 100));
    w.check();
    touch();
    EXPECT_THROW(w.check(), Error);
    EXPECT_THROW(w.append(make_frame(1, 100)), Error);
  };
  touched([&] { std::filesystem::remove(path); });
  touched([&] { std::filesystem::resize_file(path, 5000); });
  touched([&] { std::filesystem::rename(path, path + "2"), std::filesystem::copy_file(path + "2", path); });
}

TEST(VtkHdf, WhatCannotBeContinuedIsToldApartAndLeftAsItWas) {
  TemporaryFolder folder;
  const std::string path = folder / "p.vtkhdf";
  { VtkHdfWriter(path, k_all).append(make_frame(0, 100)); }
  const std::string whole = test::slurp(path);
  EXPECT_THROW(VtkHdfWriter::resume(path, {}, VtkHdfWriter::Content::particles, 5), CannotContinue);
  EXPECT_EQ(test::slurp(path), whole);
  test::spill(path, whole.substr(0, 3000));
  EXPECT_THROW(VtkHdfWriter::resume(path, k_all, VtkHdfWriter::Content::particles, 5), CannotContinue);
  EXPECT_EQ(test::slurp(path), whole.substr(0, 3000));
}

TEST(VtkHdf, KilledWriterLeavesWholeFramesAndCanBeResumed) {
  TemporaryFolder folder;
  int some = 0;
  for (int round = 0; round < 8; ++round) {
    const std::string path = folder / ("k" + std::to_string(round) + ".vtkhdf");
    int pipe_ends[2];
    ASSERT_EQ(pipe(pipe_ends), 0);
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      VtkHdfWriter w(path, k_all);
      for (int step = 0;; ++step) {
        w.append(make_frame(step, 100 + 700 * (step % 5)));
        if (write(pipe_ends[1], "", 1) != 1) _exit(1);
      }
    }
    close(pipe_ends[1]);
    // The file appears whole: from the moment it has its name it can be read. The kill comes at another moment of a
    // frame in each round, and in half of the rounds surely after four frames, however slow the machine is.
    for (int wait = 0; wait < 20000 && !std::filesystem::exists(path); ++wait) usleep(1000);
    char told = 0;
    for (int frame = 0; frame < (round % 2 == 1 ? 4 : 0); ++frame) ASSERT_EQ(read(pipe_ends[0], &told, 1), 1);
    usleep(static_cast<useconds_t>(7000 * round));
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    close(pipe_ends[0]);
    EXPECT_TRUE(python("check_vtkhdf.py", path + " particles --whole > /dev/null")) << round;
    auto w = VtkHdfWriter::resume(path, k_all, Content::particles, 3);
    some += w.frames() == 4;
    for (int step = static_cast<int>(w.frames()); step < 6; ++step) w.append(make_frame(step, 100 + 700 * (step % 5)));
    EXPECT_TRUE(python("check_vtkhdf.py", path + " particles 0:100 1:800 2:1500 3:2200 4:2900 5:100")) << round;
  }
  EXPECT_GT(some, 0);  // at least one kill came after four frames
}

}  // namespace
}  // namespace talus
