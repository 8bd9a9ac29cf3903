// Runs the program `talus` (TALUS_BINARY) as users do and returns exit code and output. Called by tests/cli/*_test.cpp.
// Invariant: every test works in a folder of its own, which is removed afterwards.
#pragma once

#include <gtest/gtest.h>
#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "paths.hpp"

namespace talus::test {

struct Result {
  int exit_code = -1;  ///< -1 - signal where a signal ended it
  std::string out, err;
};

/// Columns of a time series by name.
using Table = std::map<std::string, std::vector<double>>;
/// Reads a CSV text whose first line names the columns and whose other entries are all numbers.
Table table_of(const std::string& csv);

/// A started `talus`; wait() must be called.
class Process {
 public:
  /// Output goes to files in `folder`, which is also the working directory. `prepare` runs in the new process just
  /// before the program.
  Process(const std::filesystem::path& folder, const std::vector<std::string>& arguments,
          const std::function<void()>& prepare = {});
  pid_t id() const { return id_; }
  Result wait();

 private:
  pid_t id_ = -1;
  std::filesystem::path folder_;
};

/// Fixture: temporary folder, small scenes, shorthands.
class Cli : public ::testing::Test {
 protected:
  void SetUp() override;
  void TearDown() override;
  Result talus(const std::vector<std::string>& arguments, const std::function<void()>& prepare = {}) {
    return Process(folder, arguments, prepare).wait();
  }
  /// Writes text to folder/name and returns the name.
  std::string write(const std::string& name, const std::string& text);
  std::string read(const std::string& name) const;
  bool exists(const std::string& name) const { return std::filesystem::exists(folder / name); }
  /// Number or string behind "key": in a JSON text; empty if it is not there.
  static std::string json_value(const std::string& text, const std::string& key);

  std::filesystem::path folder;
};

/// A box with `number` frictional spheres under gravity, CSV and particles on; `extra` is appended. 400 steps. [SI]
std::string small_scene(int number = 200, const std::string& extra = "");

/// Replaces the first occurrence of `from`, which must exist.
std::string replaced(std::string text, const std::string& from, const std::string& to);

}  // namespace talus::test
