// Claims about opening files of users.
#include "core/base/input_file.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "core/tables/particle_file.hpp"
#include "core/scene/scene_file.hpp"

namespace talus {
namespace {
namespace fs = std::filesystem;

constexpr InputKind k_kind{ErrorCode::scene, "scene file", 1000, "give a scene"};

class Inputs : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("talus_input_" + std::to_string(getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::string put(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }
  std::string fifo() {
    const std::string path = folder_ / "fifo";
    EXPECT_EQ(mkfifo(path.c_str(), 0600), 0);
    return path;
  }
  static std::string refusal(const std::string& path) {
    try {
      read_input_text(path, k_kind);
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::scene);
      return e.what();
    }
    return "accepted";
  }
  fs::path folder_;
};

#define EXPECT_CONTAINS(text, part) EXPECT_NE(std::string(text).find(part), std::string::npos) << text

TEST_F(Inputs, ARegularFileIsReadAsAWhole) {
  const std::string bytes("a\0b\n", 4);
  EXPECT_EQ(read_input_text(put("gr\xc3\xbc\xc3\x9f.bin", bytes), k_kind), bytes);
  EXPECT_EQ(read_input_bytes(put("x", bytes), k_kind).size(), 4u);
  EXPECT_EQ(read_input_text(put("empty", ""), k_kind), "");
  fs::create_symlink(put("x", "linked"), folder_ / "link");
  EXPECT_EQ(read_input_text(folder_ / "link", k_kind), "linked");
}

TEST_F(Inputs, AFifoIsRefusedAndNotWaitedFor) {
  const std::string path = fifo();  // without a writer, so that an open that waits would never return
  EXPECT_CONTAINS(refusal(path), "cannot open the scene file: it is a FIFO");
  EXPECT_THROW(load_scene(path), Error);
  EXPECT_THROW(read_particle_file(path, {}), Error);
}

TEST_F(Inputs, DevicesFoldersAndMissingFilesAreRefusedByName) {
  EXPECT_CONTAINS(refusal("/dev/zero"), "/dev/zero: cannot open the scene file: it is a device");
  EXPECT_CONTAINS(refusal(folder_), "it is a folder");
  EXPECT_CONTAINS(refusal(folder_ / "none"),
                  "none: cannot open the scene file: No such file or directory (give a scene)");
  EXPECT_CONTAINS(refusal(""), "the name of the scene file is empty");
  EXPECT_CONTAINS(refusal(std::string("a\0b", 3)), "a\\x00b: the name of the scene file holds a NUL byte");
  EXPECT_CONTAINS(refusal(std::string(5000, 'a')), "File name too long");
  EXPECT_CONTAINS(refusal(put("x", "") + "/y"), "Not a directory");
  if (geteuid() != 0) {
    const std::string secret = put("secret", "x");
    fs::permissions(secret, fs::perms::none);
    EXPECT_CONTAINS(refusal(secret), "Permission denied (make it readable)");
  }
}

TEST_F(Inputs, AFileLargerThanItsKindOrThanMemoryIsRefused) {
  EXPECT_EQ(read_input_text(put("x", std::string(1000, 'x')), k_kind).size(), 1000u);
  EXPECT_CONTAINS(refusal(put("x", std::string(1001, 'x'))), "the scene file has 1001 bytes (at most 1000 bytes");
  const std::string sparse = put("sparse", "");
  fs::resize_file(sparse, std::uintmax_t{1} << 42);
  try {
    read_input_bytes(sparse, {ErrorCode::io, "checkpoint", std::uint64_t{1} << 62, ""});
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::io);
    EXPECT_CONTAINS(e.what(), "reading this checkpoint needs about 4.0 TiB of memory");
  }
}

}  // namespace
}  // namespace talus
