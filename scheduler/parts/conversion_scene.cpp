// What a scene says of conversion, for the part: its grain files. Who calls it: parts.cpp.
#include <filesystem>
#include <map>
#include <mutex>

#include "scheduler/parts/conversion.hpp"

namespace talus {

using namespace conversion;

namespace {

/// A file is read once for all copies of a run.
std::shared_ptr<const GrainJob> job_of(const std::string& path) {
  static std::mutex mutex;
  static std::map<std::string, std::weak_ptr<const GrainJob>> known;
  const std::lock_guard lock(mutex);
  std::weak_ptr<const GrainJob>& at = known[path];
  std::shared_ptr<const GrainJob> job = at.lock();
  if (!job) at = job = std::make_shared<const GrainJob>(load_grain(path));
  return job;
}

}  // namespace

std::unique_ptr<Part> make_conversion(const Rules& rules) {
  const ConversionScene& c = rules.scene.conversion;
  if (!c.on) return nullptr;
  ConversionSettings s;
  s.every = c.every;
  s.shells = c.shells;
  s.gone_below = c.gone_below;
  s.resizes = c.resize;
  s.matter.resize(rules.scene.materials.size());
  for (std::size_t k = 0; k < s.matter.size() && k < c.grain.size(); ++k) {
    if (c.grain[k].empty()) continue;
    const std::filesystem::path file(c.grain[k]);
    s.matter[k] = job_of((file.is_absolute() ? file : std::filesystem::path(rules.scene.directory) / file).string());
  }
  return make_conversion(rules, s);
}

}  // namespace talus
