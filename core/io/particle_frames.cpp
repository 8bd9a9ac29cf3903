// See particle_frames.hpp.
#include "core/io/particle_frames.hpp"

#include <filesystem>

#include "core/base/error.hpp"
#include "core/io/vtkhdf.hpp"

namespace talus {
namespace fs = std::filesystem;

struct ParticleFrames::Source {
  std::optional<VtkHdfReader> hdf;
  std::optional<PvdReader> pvd;
  std::optional<Frame> single;
};

ParticleFrames::ParticleFrames(const std::string& path) : path_(path), source_(std::make_unique<Source>()) {
  const std::string extension = fs::path(path).extension().string();
  if (extension == ".vtkhdf" || extension == ".hdf") {
    source_->hdf.emplace(path);
    for (const auto& s : source_->hdf->steps()) steps_.push_back({s.step, s.time});
  } else if (extension == ".pvd") {
    source_->pvd.emplace(path);
    steps_ = source_->pvd->steps();
  } else if (extension == ".vtp") {
    source_->single = read_vtp(path);
    steps_ = {{source_->single->step, source_->single->time}};
  } else {
    throw Error(ErrorCode::usage, "is no file of particle frames", path, "allowed: .pvd, .vtp, .vtkhdf");
  }
}

ParticleFrames::~ParticleFrames() = default;
ParticleFrames::ParticleFrames(ParticleFrames&&) noexcept = default;

std::optional<std::string> ParticleFrames::find(const std::string& folder) {
  std::optional<std::string> found;
  std::int64_t last = -1;
  std::error_code ignored;
  for (const char* name : {"particles.pvd", "particles.vtkhdf"}) {
    const std::string path = folder + "/" + name;
    if (!fs::exists(path, ignored)) continue;
    // A damaged one is an error also beside a good one: nobody would miss it otherwise.
    const ParticleFrames frames(path);
    const std::int64_t until = frames.steps().empty() ? -1 : frames.steps().back().step;
    if (found && until <= last) continue;
    found = path;
    last = until;
  }
  return found;
}

Frame ParticleFrames::frame(std::size_t k) const {
  if (source_->hdf) return source_->hdf->frame(k);
  if (source_->pvd) return source_->pvd->frame(k);
  return source_->single.value();
}

}  // namespace talus
