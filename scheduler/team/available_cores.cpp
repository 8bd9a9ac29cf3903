// Affinity and the quotas of control groups (versions 1 and 2).
#include "scheduler/team/available_cores.hpp"

#include <sched.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>

namespace talus {

namespace {

constexpr double k_unlimited = std::numeric_limits<double>::infinity();

/// `cpu.max` of version 2: "quota period" or "max period" [us].
double quota_of_max(const std::string& folder) {
  std::ifstream in(folder + "/cpu.max");
  double quota = 0, period = 0;
  return in >> quota >> period && quota > 0 && period > 0 ? quota / period : k_unlimited;
}

/// `cpu.cfs_quota_us` of version 1; -1 stands for none.
double quota_of_cfs(const std::string& folder) {
  std::ifstream first(folder + "/cpu.cfs_quota_us"), second(folder + "/cpu.cfs_period_us");
  double quota = 0, period = 0;
  return first >> quota && second >> period && quota > 0 && period > 0 ? quota / period : k_unlimited;
}

/// Smallest quota on the way from root + path up to root. In a container the path may lie outside of what is mounted:
/// then the root still holds the container's own quota.
template <class Quota>
double smallest(const std::string& root, std::string path, Quota quota) {
  double least = quota(root);
  while (!path.empty() && path != "/") {
    least = std::min(least, quota(root + path));
    path.resize(path.rfind('/'));
  }
  return least;
}

}  // namespace

double quota_cores(const std::string& membership, const std::string& root) {
  double least = k_unlimited;
  std::ifstream in(membership);
  // lines "number:controllers:path"; version 2 has no controllers
  for (std::string line; std::getline(in, line);) {
    const auto first = line.find(':'), second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos || line.compare(second + 1, 1, "/") != 0) continue;
    const std::string path = line.substr(second + 1);
    std::string controllers(1, ',');
    controllers.append(line, first + 1, second - first - 1).append(1, ',');
    if (controllers == ",,") least = std::min(least, smallest(root, path, quota_of_max));
    if (controllers.find(",cpu,") != std::string::npos)
      least = std::min(least, smallest(root + "/cpu", path, quota_of_cfs));
  }
  return least;
}

int available_cores() {
  cpu_set_t set;
  CPU_ZERO(&set);
  const int cores = sched_getaffinity(0, sizeof set, &set) == 0 ? std::max(1, CPU_COUNT(&set)) : 1;
  const double quota = quota_cores("/proc/self/cgroup", "/sys/fs/cgroup");
  return quota < cores ? std::max(1, static_cast<int>(std::ceil(quota))) : cores;
}

}  // namespace talus
