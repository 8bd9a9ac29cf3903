// Atomic replacement under every failing system call, and the checkpoint that relies on it.
#include "core/io/atomic_file.hpp"

#include <gtest/gtest.h>

#include <cerrno>
#include <filesystem>

#include "core/base/error.hpp"
#include "core/io/checkpoint.hpp"
#include "tests/io/output_frames.hpp"

namespace talus {
namespace {

using test::slurp;
using test::spill;
using test::TemporaryFolder;

/// Fails the n-th call of all (0: none) with `error`; counts calls; may also interrupt every call once or write short.
class Faulty : public FileCalls {
 public:
  int fail_at = 0, error = EIO;
  bool interrupt = false;   ///< every retryable call first fails with EINTR
  std::size_t at_most = 0;  ///< bytes per write, 0: no limit
  int calls = 0, writes = 0;

  int open(const char* p, int flags, unsigned mode) override {
    return broken() || interrupted() ? -1 : FileCalls::open(p, flags, mode);
  }
  ssize_t write(int fd, const void* d, std::size_t n) override {
    if (broken() || interrupted()) return -1;
    ++writes;
    return FileCalls::write(fd, d, at_most != 0 && n > at_most ? at_most : n);
  }
  int fsync(int fd) override { return broken() || interrupted() ? -1 : FileCalls::fsync(fd); }
  int close(int fd) override {
    const bool bad = broken();
    const int r = FileCalls::close(fd);  // Linux releases the descriptor in any case
    if (bad) errno = error;
    return bad ? -1 : r;
  }
  int rename(const char* a, const char* b) override { return broken() || interrupted() ? -1 : FileCalls::rename(a, b); }

 private:
  bool broken() {
    if (++calls != fail_at) return false;
    errno = error;
    return true;
  }
  bool interrupted() {
    toggle_ = interrupt && !toggle_;
    if (toggle_) errno = EINTR;
    return toggle_;
  }
  bool toggle_ = false;
};

int open_descriptors() {
  int n = 0;
  for ([[maybe_unused]] const auto& e : std::filesystem::directory_iterator("/proc/self/fd")) ++n;
  return n;
}

int entries(const TemporaryFolder& folder) {
  return static_cast<int>(std::distance(std::filesystem::directory_iterator(folder.path()), {}));
}

/// Calls of one fault-free replacement: open, write..., fsync, close, rename, open folder, fsync, close.
int calls_needed(const TemporaryFolder& folder) {
  Faulty calls;
  ScopedFileCalls scope(calls);
  write_file_atomic(folder / "probe", "new content");
  return calls.calls;
}

TEST(AtomicFile, OldFileSurvivesAnyFailingCall) {
  TemporaryFolder folder;
  const std::string path = folder / "data";
  const int needed = calls_needed(folder);
  ASSERT_EQ(needed, 8);
  const int descriptors = open_descriptors();
  for (int error : {ENOSPC, EIO, EDQUOT})
    for (int at = 1; at <= needed; ++at) {
      spill(path, "old content");
      Faulty calls;
      calls.fail_at = at;
      calls.error = error;
      bool threw = false;
      {
        ScopedFileCalls scope(calls);
        try {
          write_file_atomic(path, "new content");
        } catch (const Error& e) {
          threw = true;
          EXPECT_EQ(e.code(), ErrorCode::io);
          EXPECT_NE(std::string(e.what()).find(path), std::string::npos) << e.what();
        }
      }
      // Calls 1-5 (open, write, fsync, close, rename) come before the exchange, 6 and 7 after it; closing the folder
      // (8) has nothing to lose.
      EXPECT_EQ(threw, at <= 7) << "call " << at;
      EXPECT_EQ(slurp(path), at <= 5 ? "old content" : "new content") << "call " << at;
      EXPECT_EQ(entries(folder), 2) << "call " << at << ": the file and the probe, nothing beside them";
      EXPECT_EQ(open_descriptors(), descriptors) << "call " << at;
    }
}

TEST(AtomicFile, InterruptedCallsAreRetried) {
  TemporaryFolder folder;
  Faulty calls;
  calls.interrupt = true;
  ScopedFileCalls scope(calls);
  write_file_atomic(folder / "data", "content");
  EXPECT_EQ(slurp(folder / "data"), "content");
  EXPECT_EQ(calls.calls, 8 + 6);  // each of the six retryable calls twice, close never
}

TEST(AtomicFile, ShortWritesAreContinued) {
  TemporaryFolder folder;
  Faulty calls;
  calls.at_most = 3;
  ScopedFileCalls scope(calls);
  write_file_atomic(folder / "data", "0123456789");
  EXPECT_EQ(slurp(folder / "data"), "0123456789");
  EXPECT_EQ(calls.writes, 4);
}

TEST(AtomicFile, FailureInTheMiddleOfShortWritesKeepsTheOldFile) {
  TemporaryFolder folder;
  spill(folder / "data", "old");
  Faulty calls;
  calls.at_most = 3;
  calls.fail_at = 4;  // open, write, write, write
  calls.error = ENOSPC;
  ScopedFileCalls scope(calls);
  EXPECT_THROW(write_file_atomic(folder / "data", "0123456789"), Error);
  EXPECT_EQ(slurp(folder / "data"), "old");
}

TEST(AtomicFile, AbandonedFileLeavesNothing) {
  TemporaryFolder folder;
  spill(folder / "data", "old");
  {
    AtomicFile file(folder / "data");
    file.write("half");
    EXPECT_EQ(entries(folder), 2);
  }
  EXPECT_EQ(entries(folder), 1);
  EXPECT_EQ(slurp(folder / "data"), "old");
}

TEST(AtomicFile, MissingFolderIsAnErrorThatNamesIt) {
  TemporaryFolder folder;
  try {
    write_file_atomic(folder / "none/data", "x");
    FAIL() << "no error";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("none/data"), std::string::npos);
  }
}

TEST(Checkpoint, OldOneSurvivesAnyFailingCall) {
  TemporaryFolder folder;
  const std::string path = folder / "c.tcp";
  CheckpointWriter old, fresh;
  old.add_value("n", std::int64_t{1});
  fresh.add_value("n", std::int64_t{2});
  fresh.add_array("more", "abc", 3);
  int last = 0;
  for (int at = 1;; ++at) {
    old.commit(path);
    Faulty calls;
    calls.fail_at = at;
    calls.error = ENOSPC;
    bool threw = false;
    {
      ScopedFileCalls scope(calls);
      try {
        fresh.commit(path);
      } catch (const Error&) {
        threw = true;
      }
    }
    const auto n = CheckpointReader(path).read_value<std::int64_t>("n");  // one of the two, whole
    if (calls.calls < at) break;
    EXPECT_TRUE(threw || n == 2);
    last = at;
  }
  EXPECT_GT(last, 12);  // more calls than a single write: sections are written one by one
}

}  // namespace
}  // namespace talus
