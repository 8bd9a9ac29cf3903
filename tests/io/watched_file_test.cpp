// Files that others change while a run writes them.
#include "core/io/watched_file.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/io/output_frames.hpp"

namespace talus {
namespace {

struct WatchedFileTest : ::testing::Test {
  test::TemporaryFolder folder;
  std::string path = folder / "data";
  WatchedFileTest() { std::ofstream(path) << std::string(1000, 'x'); }
};

TEST_F(WatchedFileTest, ACutWhileItsRoomIsReservedIsSeenEvenIfWritesRestoreTheSize) {
  WatchedFile file(path);
  file.reserve(5000);
  EXPECT_NO_THROW(file.check_room());
  std::filesystem::resize_file(path, 500);
  std::filesystem::resize_file(path, 1400);  // as a write behind the cut does
  EXPECT_THROW(file.check_room(), Error);
}

TEST_F(WatchedFileTest, ACutBetweenTwoWritesIsSeen) {
  WatchedFile file(path);
  file.reserve(5000);
  file.release(1200);
  file.mark(1200);
  EXPECT_NO_THROW(file.check());
  EXPECT_NO_THROW(file.check_room()) << "nothing is reserved";
  std::filesystem::resize_file(path, 1199);
  EXPECT_THROW(file.check(), Error);
}

}  // namespace
}  // namespace talus
