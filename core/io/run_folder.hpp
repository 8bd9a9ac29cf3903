// RunFolder: the output folder of one run: creation, file names, the two newest checkpoints. Who calls it: cases/ (run,
// resume, report). Invariants: the folder appears whole (scene copy included) or not at all; a folder with anything in
// it is never written over unless asked, and never if it holds files that no run writes.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/io/checkpoint.hpp"

namespace talus {

class RunFolder {
 public:
  /// Creates `dir` holding scene.toml with `scene_text`. Call it after the simulation has been built, so that a bad
  /// scene leaves nothing. Error{usage} if `dir` has content and `overwrite` is false, or has files that no run writes;
  /// Error{io} otherwise.
  static RunFolder create(const std::string& dir, const std::string& scene_text, bool overwrite = false);
  /// The folder of an earlier run, for --resume and reports. Error{usage} if it is none (no scene.toml).
  static RunFolder open(const std::string& dir);
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
  /// Removes what create() made (the folder with all content, or the scene copy in a folder that was there and empty):
  /// for an error found before anything of value was written. After open() it does nothing.
  void discard() noexcept;

 private:
  enum class Mine { nothing, scene_file, folder };  ///< what this object created and discard() may remove
  explicit RunFolder(std::string dir, Mine mine) : dir_(std::move(dir)), mine_(mine) {}
  std::string dir_;
  Mine mine_ = Mine::nothing;
};

}  // namespace talus
