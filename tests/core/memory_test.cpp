// Claims about the memory that is left, from made-up /proc and /sys.
#include "core/base/memory.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace talus {
namespace {
namespace fs = std::filesystem;

class MemoryLeft : public ::testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::temp_directory_path() / ("talus_memory_" + std::to_string(getpid()));
    fs::remove_all(root_);
    put("proc/meminfo", "MemTotal: 9000 kB\nMemFree: 1000 kB\nMemAvailable: 4000 kB\n");
  }
  void TearDown() override { fs::remove_all(root_); }
  void put(const std::string& name, const std::string& text) {
    fs::create_directories((root_ / name).parent_path());
    std::ofstream(root_ / name) << text;
  }
  double left() const { return available_memory(root_.string()).bytes; }
  fs::path root_;
};

TEST_F(MemoryLeft, IsThatOfTheMachineWithoutGroups) { EXPECT_EQ(left(), 4000.0 * 1024); }

TEST_F(MemoryLeft, IsTheLeastOfAllLevelsOfGroupsOfVersion2) {
  put("proc/self/cgroup", "0::/job/step\n");
  put("sys/fs/cgroup/job/step/memory.max", "max\n");
  put("sys/fs/cgroup/job/memory.max", "3000000\n");
  put("sys/fs/cgroup/job/memory.current", "2000000\n");
  put("sys/fs/cgroup/job/memory.stat", "anon 1500000\ninactive_file 400000\n");
  EXPECT_EQ(left(), 1400000.0) << "what is used, less the cache that can be given back";
  put("sys/fs/cgroup/memory.max", "500000\n");  // the root of a container's own namespace
  EXPECT_EQ(left(), 500000.0);
  put("sys/fs/cgroup/job/memory.current", "9000000\n");
  EXPECT_EQ(left(), 0.0);
}

TEST_F(MemoryLeft, CountsGroupsOfVersion1) {
  put("proc/self/cgroup", "7:cpu:/x\n5:memory:/job\n");
  put("sys/fs/cgroup/memory/job/memory.limit_in_bytes", "2000000\n");
  put("sys/fs/cgroup/memory/job/memory.usage_in_bytes", "700000\n");
  put("sys/fs/cgroup/memory/job/memory.stat", "total_inactive_file 100000\n");
  EXPECT_EQ(left(), 1400000.0);
}

TEST(RequireMemory, RefusesInOneLineWithBothNumbers) {
  require_memory(1 << 20, "a small thing", "", "");
  try {
    require_memory(1e18, "the grid", "scene.toml: output.grid", "fewer cells");
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::scene);
    const std::string m = e.what();
    EXPECT_EQ(m.rfind("scene.toml: output.grid: the grid needs about 888.2 PiB of memory, ", 0), 0u) << m;
    EXPECT_NE(m.find("are available"), std::string::npos) << m;
  }
}

}  // namespace
}  // namespace talus
