// RunFolder; see run_folder.hpp.
#include "core/io/run_folder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>

#include "core/error.hpp"
#include "core/io/atomic_file.hpp"

namespace fs = std::filesystem;

namespace talus {

namespace {

constexpr std::string_view k_prefix = "checkpoint-", k_suffix = ".tcp";

bool ends_with(const std::string& s, std::string_view end) {
  return s.size() >= end.size() && s.compare(s.size() - end.size(), end.size(), end) == 0;
}

std::optional<std::int64_t> checkpoint_step(const std::string& name) {
  if (name.compare(0, k_prefix.size(), k_prefix) != 0 || !ends_with(name, k_suffix)) return {};
  std::int64_t step = -1;
  const char* end = name.data() + name.size() - k_suffix.size();
  const auto r = std::from_chars(name.data() + k_prefix.size(), end, step);
  if (r.ec != std::errc() || r.ptr != end || step < 0) return {};
  return step;
}

/// Names that a run writes; only these may be deleted by overwriting.
bool known(const std::string& full) {
  std::string name = full;
  if (ends_with(name, ".tmp")) name.resize(name.size() - 4);
  for (const char* k : {"scene.toml", "particles.vtkhdf", "walls.vtkhdf", "contacts.vtkhdf", "series.csv",
                        "summary.json", "report.html", "trace.json", "vtp", "failed.tcp", "failed.vtp", "failed_near.csv"})
    if (name == k) return true;
  return checkpoint_step(name).has_value() || ends_with(name, ".pvd");
}

[[noreturn]] void throw_io(const std::string& dir, const std::string& action, const std::error_code& e) {
  throw Error(ErrorCode::io, "cannot " + action + ": " + e.message(), dir, "choose a folder that you may write to");
}

/// "out/", "out//" and "out" are one name; rename() needs the bare one.
std::string bare(std::string dir) {
  while (dir.size() > 1 && dir.back() == '/') dir.pop_back();
  return dir;
}

}  // namespace

void RunFolder::check(const std::string& raw, bool overwrite) {
  const std::string dir = bare(raw);
  if (dir.empty()) throw Error(ErrorCode::usage, "name of the output folder is empty", "--out", "give a folder name");
  std::error_code e;
  const auto status = fs::status(dir, e);
  if (!fs::exists(status)) return;
  if (!fs::is_directory(status))
    throw Error(ErrorCode::usage, "output folder is a file", dir, "give another folder with --out");
  bool any = false;
  for (const auto& entry : fs::directory_iterator(dir, e)) {
    any = true;
    const std::string name = entry.path().filename().string();
    if (overwrite && !known(name))
      throw Error(ErrorCode::usage, "output folder holds '" + name + "', which no run writes, and is not overwritten",
                  dir, "give another folder with --out");
  }
  if (e) throw_io(dir, "read the output folder", e);
  if (any && !overwrite)
    throw Error(ErrorCode::usage, "output folder is not empty", dir,
                "use --resume to continue, --overwrite to replace it, or another --out");
}

RunFolder RunFolder::create(const std::string& raw, const std::string& scene_text, bool overwrite) {
  check(raw, overwrite);
  const std::string dir = bare(raw);
  std::error_code e;
  const bool was_there = fs::exists(dir, e);
  if (was_there && fs::is_empty(dir, e)) {
    // In place: an empty folder may be a mount point or the current directory, which rename cannot replace.
    write_file_atomic(dir + "/scene.toml", scene_text);
    return RunFolder(dir, Mine::scene_file);
  }
  const std::string fresh = dir + ".tmp", old = dir + ".old";
  const auto parent = fs::path(dir).parent_path();
  if (!parent.empty()) fs::create_directories(parent, e);
  if (e) throw_io(dir, "create the folder above", e);
  for (const std::string& leftover : {fresh, old}) {
    // Only what an interrupted create() can have left.
    if (fs::exists(leftover, e)) check(leftover, true);
    fs::remove_all(leftover, e);
    if (e) throw_io(leftover, "remove", e);
  }
  fs::create_directory(fresh, e);
  if (e) throw_io(fresh, "create", e);
  try {
    write_file_atomic(fresh + "/scene.toml", scene_text);
    if (was_there) {
      fs::rename(dir, old, e);
      if (e) throw_io(dir, "replace", e);
    }
    fs::rename(fresh, dir, e);
    if (e) {
      std::error_code ignored;
      if (was_there) fs::rename(old, dir, ignored);
      throw_io(dir, "create", e);
    }
  } catch (...) {
    fs::remove_all(fresh, e);
    throw;
  }
  fs::remove_all(old, e);
  return RunFolder(dir, Mine::folder);
}

RunFolder RunFolder::open(const std::string& raw) {
  const std::string dir = bare(raw);
  std::error_code e;
  if (!fs::is_regular_file(dir + "/scene.toml", e))
    throw Error(ErrorCode::usage, "is not the folder of a run (it has no scene.toml)", dir,
                "give the folder that `talus run --out` wrote");
  return RunFolder(dir, Mine::nothing);
}

std::string RunFolder::checkpoint(std::int64_t step) const {
  return path(fmt::format("{}{}{}", k_prefix, step, k_suffix));
}

std::vector<std::int64_t> RunFolder::checkpoints() const {
  std::vector<std::int64_t> steps;
  std::error_code e;
  for (const auto& entry : fs::directory_iterator(dir_, e))
    if (const auto step = checkpoint_step(entry.path().filename().string())) steps.push_back(*step);
  std::sort(steps.begin(), steps.end());
  return steps;
}

void RunFolder::save_checkpoint(const CheckpointWriter& writer, std::int64_t step) const {
  writer.commit(checkpoint(step));
  std::int64_t before = -1;
  const auto steps = checkpoints();
  for (std::int64_t s : steps)
    if (s < step) before = s;
  std::error_code ignored;
  // Later ones too: the run was resumed before them, because they were damaged or on purpose.
  for (std::int64_t s : steps)
    if (s != step && s != before) fs::remove(checkpoint(s), ignored);
}

std::optional<RunFolder::Loaded> RunFolder::newest_checkpoint() const {
  auto steps = checkpoints();
  if (steps.empty()) return {};
  std::vector<std::string> skipped;
  for (auto s = steps.rbegin(); s != steps.rend(); ++s) {
    try {
      return Loaded{*s, CheckpointReader(checkpoint(*s)), std::move(skipped)};
    } catch (const Error& error) {
      skipped.push_back(error.what());
    }
  }
  std::string all;
  for (const std::string& m : skipped) all += (all.empty() ? "" : "; ") + m;
  throw Error(ErrorCode::io, "no checkpoint can be read: " + all, dir_, "run again from the start");
}

void RunFolder::discard() noexcept {
  std::error_code ignored;
  if (mine_ == Mine::folder) fs::remove_all(dir_, ignored);
  if (mine_ == Mine::scene_file) fs::remove(scene(), ignored);
  mine_ = Mine::nothing;
}

}  // namespace talus
