// Turns the signals that ask a run to end into a flag that the run loop reads between slices. Called by cli_run.cpp
// only. Invariant: the handler only stores number and time; a second signal from a user ends the process at once, one
// within a tenth of a second of the first is the same (timeout and job schedulers signal a process and its group).
#pragma once

namespace talus::cli {

/// SIGPIPE and SIGXFSZ do not end the process from now on: the write that fails says so. They are not ignored, since
/// ignoring would forget one that is pending; the next SignalGuard reports it.
void outlive_failed_writes() noexcept;

/// Catches SIGINT, SIGTERM, SIGHUP (unless ignored, as by nohup), SIGPIPE and SIGXFSZ for its lifetime and restores the
/// former handlers afterwards. One object at a time.
class SignalGuard {
 public:
  SignalGuard();
  ~SignalGuard();
  SignalGuard(const SignalGuard&) = delete;
  SignalGuard& operator=(const SignalGuard&) = delete;
  /// The first signal that arrived, or 0.
  int caught() const noexcept;
};

}  // namespace talus::cli
