// RunFolder; see run_folder.hpp.
#include "core/io/run_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <filesystem>

#include "core/base/error.hpp"
#include "core/io/atomic_file.hpp"
#include "core/io/scratch.hpp"

namespace fs = std::filesystem;

namespace talus {

namespace {

constexpr std::string_view k_prefix = "checkpoint-", k_suffix = ".tcp", k_until = "-until-";

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

bool digits(std::string_view s) { return !s.empty() && s.find_first_not_of("0123456789") == std::string_view::npos; }

/// Names that a run writes into its folder; only these may be deleted by overwriting.
bool known(std::string name) {
  if (is_scratch_name(name)) return true;
  // "series-until-120.csv" and "series-until-120-2.csv" were "series.csv"
  const std::size_t until = name.find(k_until), dot = name.find('.', until == std::string::npos ? 0 : until);
  if (until != std::string::npos && dot != std::string::npos) {
    std::string step = name.substr(until + k_until.size(), dot - until - k_until.size());
    if (const std::size_t dash = step.find('-'); dash != std::string::npos && digits(step.substr(dash + 1)))
      step.resize(dash);
    if (digits(step)) name.erase(until, dot - until);
  }
  for (const char* k : {"scene.toml", "particles.vtkhdf", "walls.vtkhdf", "contacts.vtkhdf", "series.csv",
                        "summary.json", "report.html", "trace.json", "failed.tcp", "failed.vtp", "failed_near.csv",
                        "particles.pvd", "walls.pvd", "contacts.pvd", "bodies.pvd", "grid.pvd", "gas.pvd", FolderLock::k_file})
    if (name == k) return true;
  return checkpoint_step(name).has_value();
}

/// Names in the folder vtp/: STEM-STEP.vtp and .vti.
bool known_frame(const std::string& name) {
  if (is_scratch_name(name)) return true;
  if (!ends_with(name, ".vtp") && !ends_with(name, ".vti")) return false;
  for (const std::string_view stem : {"particles-", "walls-", "contacts-", "bodies-", "grid-", "gas-"})
    if (name.starts_with(stem))
      return digits(std::string_view(name).substr(stem.size(), name.size() - stem.size() - 4));
  return false;
}

[[noreturn]] void throw_io(const std::string& dir, const std::string& action, const std::error_code& e) {
  throw Error(ErrorCode::io, "cannot " + action + ": " + e.message(), dir, "choose a folder that you may write to");
}

/// "out/", "out//" and "out" are one name; rename() needs the bare one.
std::string bare(std::string dir) {
  while (dir.size() > 1 && dir.back() == '/') dir.pop_back();
  return dir;
}

/// Calls f(path, name, fits) for every entry of a run folder and of its vtp/; fits: a run may have made it.
template <class F>
void each_entry(const std::string& dir, F f) {
  std::error_code e;
  for (const auto& entry : fs::directory_iterator(dir, e)) {
    const std::string name = entry.path().filename().string();
    std::error_code gone;
    const bool folder = fs::is_directory(entry.symlink_status(gone));
    if (name == "vtp" && folder) {
      for (const auto& frame : fs::directory_iterator(entry.path(), e)) {
        const std::string frame_name = frame.path().filename().string();
        f(frame.path(), "vtp/" + frame_name, known_frame(frame_name) && !fs::is_directory(frame.symlink_status(gone)));
      }
      if (e) throw_io(entry.path().string(), "read the folder", e);
    } else {
      f(entry.path(), name, known(name) && !folder);
    }
  }
  if (e) throw_io(dir, "read the output folder", e);
}

/// A run marks its folder by its lock file, and by the comments at the end of the scene's copy.
bool made_by_a_run(const std::string& dir) {
  std::error_code e;
  if (fs::is_regular_file(dir + "/" + FolderLock::k_file, e)) return true;
  if (!fs::is_regular_file(dir + "/scene.toml", e)) return false;
  return read_file_text(dir + "/scene.toml").find("\n#: directory ") != std::string::npos;
}

/// Deletes what runs write, then the folder if nothing else is in it.
void remove_run_files(const std::string& dir) noexcept {
  std::error_code ignored;
  try {
    std::vector<fs::path> files;
    each_entry(dir, [&](const fs::path& path, const std::string&, bool fits) {
      if (fits) files.push_back(path);
    });
    for (const fs::path& file : files) fs::remove(file, ignored);
  } catch (...) {
    // What cannot be read stays.
  }
  fs::remove(dir + "/vtp", ignored);  // both only if empty
  fs::remove(dir, ignored);
}

/// `fresh` takes the place of `dir`; returns where the old folder is now, empty if there was none.
std::string put_in_place(const std::string& fresh, const std::string& dir, bool was_there) {
  std::error_code e;
  if (!was_there) {
    fs::rename(fresh, dir, e);
    if (e) throw_io(dir, "create", e);
    return {};
  }
  if (::renameat2(AT_FDCWD, fresh.c_str(), AT_FDCWD, dir.c_str(), RENAME_EXCHANGE) == 0) return fresh;
  std::string old = scratch_beside(dir);  // a file system that cannot exchange
  fs::rename(dir, old, e);
  if (e) throw_io(dir, "replace", e);
  fs::rename(fresh, dir, e);
  if (e) {
    std::error_code ignored;
    fs::rename(old, dir, ignored);
    throw_io(dir, "create", e);
  }
  return old;
}

}  // namespace

void RunFolder::check(const std::string& raw, bool overwrite) {
  const std::string dir = bare(raw);
  if (dir.empty()) throw Error(ErrorCode::usage, "name of the output folder is empty", "--out", "give a folder name");
  std::error_code e;
  const auto status = fs::status(dir, e);
  if (status.type() == fs::file_type::not_found) return;
  if (!fs::exists(status)) throw_io(dir, "look at the output folder", e);
  if (!fs::is_directory(status))
    throw Error(ErrorCode::usage, "output folder is a file", dir, "give another folder with --out");
  bool any = false;
  each_entry(dir, [&](const fs::path&, const std::string& name, bool fits) {
    any = true;
    if (overwrite && !fits)
      throw Error(ErrorCode::usage, "output folder holds '" + name + "', which no run writes, and is not overwritten",
                  dir, "give another folder with --out");
  });
  if (!any) return;
  if (!overwrite)
    throw Error(ErrorCode::usage, "output folder is not empty", dir,
                "use --resume to continue, --overwrite to replace it, or another --out");
  if (!made_by_a_run(dir))
    throw Error(ErrorCode::usage, "output folder bears no mark of a run and is not overwritten", dir,
                "give another folder with --out");
  if (const std::string who = FolderLock::holder(dir); !who.empty())
    throw Error(ErrorCode::io, "another run is writing here (" + who + ")", dir,
                "wait for it, stop it, or choose another folder with --out");
}

RunFolder RunFolder::create(const std::string& raw, const std::string& scene_text, bool overwrite) {
  check(raw, overwrite);
  const std::string dir = bare(raw);
  std::error_code e;
  const bool was_there = fs::exists(dir, e);
  if (was_there && fs::is_empty(dir, e)) {
    // In place: an empty folder may be a mount point or the current directory, which rename cannot replace.
    auto lock = std::make_shared<FolderLock>(dir);
    try {
      write_file_atomic(dir + "/scene.toml", scene_text);
    } catch (...) {
      fs::remove(dir + "/" + FolderLock::k_file, e);
      throw;
    }
    return {dir, Mine::scene_file, std::move(lock)};
  }
  std::shared_ptr<FolderLock> old_lock;
  if (was_there) old_lock = std::make_shared<FolderLock>(dir);
  const auto parent = fs::path(dir).parent_path();
  if (!parent.empty()) fs::create_directories(parent, e);
  if (e) throw_io(dir, "create the folder above", e);
  const std::string fresh = scratch_beside(dir);
  if (!fs::create_directory(fresh, e) || e) throw_io(dir, "create", e);
  std::string old;
  std::shared_ptr<FolderLock> lock;
  try {
    lock = std::make_shared<FolderLock>(fresh);
    write_file_atomic(fresh + "/scene.toml", scene_text);
    old = put_in_place(fresh, dir, was_there);
  } catch (...) {
    remove_run_files(fresh);
    throw;
  }
  if (!old.empty()) remove_run_files(old);
  return {dir, Mine::folder, std::move(lock)};
}

RunFolder RunFolder::open(const std::string& raw) {
  const std::string dir = bare(raw);
  std::error_code e;
  const auto status = fs::status(dir + "/scene.toml", e);
  if (!fs::exists(status) && status.type() != fs::file_type::not_found)
    throw Error(ErrorCode::io, "cannot look into it: " + e.message(), dir);
  if (!fs::is_regular_file(status))
    throw Error(ErrorCode::usage, "is not the folder of a run (it has no scene.toml)", dir,
                "give the folder that `talus run --out` wrote");
  return {dir, Mine::nothing, nullptr};
}

RunFolder RunFolder::resume(const std::string& raw) {
  RunFolder folder = open(raw);
  folder.lock_ = std::make_shared<FolderLock>(folder.dir_);
  std::vector<fs::path> left;
  each_entry(folder.dir_, [&](const fs::path& path, const std::string&, bool fits) {
    if (fits && is_scratch_name(path.filename().string())) left.push_back(path);
  });
  std::error_code ignored;
  for (const fs::path& path : left) fs::remove(path, ignored);
  return folder;
}

std::string RunFolder::name_aside(const std::string& file_path, std::int64_t step) const {
  const fs::path file(file_path);
  const std::string stem = file.stem().string() + std::string(k_until) + std::to_string(step);
  for (int k = 1;; ++k) {
    std::string to = path(stem + (k > 1 ? fmt::format("-{}", k) : "") + file.extension().string());
    std::error_code e;
    if (!fs::exists(fs::symlink_status(to, e))) return to;
  }
}

std::string RunFolder::set_aside(const std::string& file_path, std::int64_t step) const {
  std::string to = name_aside(file_path, step);
  std::error_code e;
  fs::rename(file_path, to, e);
  if (e) throw_io(file_path, "rename to " + to, e);
  return to;
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
  if (mine_ == Mine::folder) remove_run_files(dir_);
  if (mine_ == Mine::scene_file) {
    fs::remove(scene(), ignored);
    fs::remove(path(FolderLock::k_file), ignored);
  }
  mine_ = Mine::nothing;
}

}  // namespace talus
