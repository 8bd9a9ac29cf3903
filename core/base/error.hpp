// The one error type that crosses API edges, and the exit codes of the command line.
// Who calls it: every module that reads input, writes files or detects a physical failure (DESIGN I9). Invariant: a
// message is one line of at most 1000 bytes without control characters, whatever texts of users are in it.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace talus {

/// Exit codes of the command line (DESIGN 6).
enum class ErrorCode : int { usage = 2, scene = 3, physics = 4, io = 5 };

/// What went wrong, where (file:line:col, key, particle and step) and what cures it.
class Error : public std::runtime_error {
 public:
  Error(ErrorCode code, std::string_view what, std::string_view where = {}, std::string_view cure = {});
  ErrorCode code() const noexcept { return code_; }
  int exit_code() const noexcept { return static_cast<int>(code_); }

 private:
  ErrorCode code_;
};

}  // namespace talus
