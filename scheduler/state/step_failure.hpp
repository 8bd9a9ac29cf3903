// How a node ends a run: it throws this; the step takes itself back and turns it into the Error of the run.
#pragma once

#include <exception>
#include <string>
#include <utility>
#include <vector>

#include "core/base/types.hpp"
#include "core/walls/walls.hpp"
#include "scheduler/state/contacts.hpp"

namespace talus {

class StepFailure : public std::exception {
 public:
  /// `ids`: who is to blame. `takes_back`: the state to look at is that before the last integration, where every number
  /// is still finite.
  StepFailure(std::vector<ParticleId> ids, std::string what, std::string cure, bool takes_back = true)
      : ids_(std::move(ids)), what_(std::move(what)), cure_(std::move(cure)), takes_back_(takes_back) {}
  const char* what() const noexcept override { return what_.c_str(); }
  const std::vector<ParticleId>& ids() const noexcept { return ids_; }
  const std::string& cure() const noexcept { return cure_; }
  bool takes_back() const noexcept { return takes_back_; }

 private:
  std::vector<ParticleId> ids_;
  std::string what_, cure_;
  bool takes_back_;
};

/// For a row with a position or velocity that is no number; names what it touches.
[[noreturn]] void fail_non_finite(const Rows& rows, const Contacts& contacts, const WallSet& walls, Row row);

}  // namespace talus
