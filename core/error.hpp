// The one error type that crosses API edges, and the exit codes of the command line.
// Who calls it: every module that reads input, writes files or detects a physical failure (DESIGN I9).
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace talus {

/// Exit codes of the command line (DESIGN 6).
enum class ErrorCode : int { usage = 2, scene = 3, physics = 4, io = 5 };

/// What went wrong, where (file:line:col, key, particle and step) and what cures it.
class Error : public std::runtime_error {
 public:
  Error(ErrorCode code, std::string what, std::string where = {}, std::string cure = {})
      : std::runtime_error(compose(what, where, cure)), code_(code) {}
  ErrorCode code() const noexcept { return code_; }
  int exit_code() const noexcept { return static_cast<int>(code_); }

 private:
  static std::string compose(const std::string& what, const std::string& where, const std::string& cure) {
    std::string s = where.empty() ? what : where + ": " + what;
    if (!cure.empty()) s += " (" + cure + ")";
    return s;
  }
  ErrorCode code_;
};

}  // namespace talus
