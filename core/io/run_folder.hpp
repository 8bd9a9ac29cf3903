// RunFolder: the output folder of one run: creation, lock, file names, the two newest checkpoints. Who calls it: cases/
// (run, resume, report). Invariants: the folder appears whole (scene copy included) or not at all; a folder with
// anything in it is never written over unless asked, and never if it is not marked as a run's or holds files that no
// run writes; who writes into it holds its lock.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/io/checkpoint.hpp"
#include "core/io/folder_lock.hpp"

namespace talus {

class RunFolder {
 public:
  /// Creates `dir` holding scene.toml with `scene_text`. Call it after the simulation has been built, so that a bad
  /// scene leaves nothing. Error{usage} if `dir` has content and `overwrite` is false, or has files that no run writes;
  /// Error{io} otherwise.
  static RunFolder create(const std::string& dir, const std::string& scene_text, bool overwrite = false);
  /// The folder of an earlier run, for reading. Error{usage} if it is none (no scene.toml).
  static RunFolder open(const std::string& dir);
  /// The same, to write into: takes the lock and removes what a killed run left half written. Error{io}: locked.
  static RunFolder resume(const std::string& dir);
  /// Checks what create() would refuse, without touching anything: call it before a long set-up.
  static void check(const std::string& dir, bool overwrite = false);

  const std::string& dir() const noexcept { return dir_; }
  std::string path(const std::string& name) const { return dir_ + "/" + name; }
  std::string scene() const { return path("scene.toml"); }
  std::string particles() const { return path("particles.vtkhdf"); }
  std::string walls() const { return path("walls.vtkhdf"); }
  std::string contacts() const { return path("contacts.vtkhdf"); }
  std::string series() const { return path("series.csv"); }
  std::string summary() const { return path("summary.json"); }
  std::string report() const { return path("report.html"); }
  std::string checkpoint(std::int64_t step) const;  ///< checkpoint-STEP.tcp

  /// Steps of all checkpoints, ascending.
  std::vector<std::int64_t> checkpoints() const;
  /// Writes the checkpoint of `step`, then removes all but it and the newest one before it. Error{io} keeps both old
  /// ones.
  void save_checkpoint(const CheckpointWriter& writer, std::int64_t step) const;
  struct Loaded {
    std::int64_t step;
    CheckpointReader reader;
    std::vector<std::string> skipped;  ///< messages of newer ones that were damaged
  };
  /// The newest undamaged checkpoint, or nothing if there is none. Error{io} if all are damaged.
  std::optional<Loaded> newest_checkpoint() const;
  /// Path of the folder that no file has yet: NAME-until-STEP.EXT for what was written until a resume at STEP.
  std::string name_aside(const std::string& path, std::int64_t step) const;
  /// Gives a file that name, so that a new one can take its place; returns it. Error{io}.
  std::string set_aside(const std::string& path, std::int64_t step) const;
  /// Removes what create() made (the folder with all content, or the scene copy in a folder that was there and empty):
  /// for an error found before anything of value was written. After open() it does nothing.
  void discard() noexcept;

 private:
  enum class Mine { nothing, scene_file, folder };  ///< what this object created and discard() may remove
  RunFolder(std::string dir, Mine mine, std::shared_ptr<FolderLock> lock)
      : dir_(std::move(dir)), lock_(std::move(lock)), mine_(mine) {}
  std::string dir_;
  std::shared_ptr<FolderLock> lock_;  ///< of those that write
  Mine mine_ = Mine::nothing;
};

}  // namespace talus
