// How many cores this process may use. Who calls it: simulation.cpp, where no number of threads is asked for.
#pragma once

#include <string>

namespace talus {

/// Cores of the affinity mask, but not more than the CPU quota of the control group or of one above it, rounded up; at
/// least 1. Files that are absent or unreadable limit nothing.
int available_cores();

/// Quota in cores of the group that `membership` (/proc/self/cgroup) names below `root` (/sys/fs/cgroup), the smallest
/// on the way up to the root; both versions of control groups. Infinity: none.
double quota_cores(const std::string& membership, const std::string& root);

}  // namespace talus
