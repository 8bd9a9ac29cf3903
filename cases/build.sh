#!/bin/bash
# Configures and builds Talus (Release) in build/. Arguments: CMake targets; none = everything. Called by
# cases/run_hopper.sh and tests/run_all.sh after cases/install.sh. TALUS_JOBS: parallel compile jobs (default: cores, but
# at most one per 1.5 GiB of memory, which the template-heavy kernel units need).
set -euo pipefail
cd "$(dirname "$0")/.."

memory_jobs=$(awk '/MemAvailable/ {print int($2 / 1572864)}' /proc/meminfo)
jobs=$(nproc)
[ "$memory_jobs" -ge "$jobs" ] || jobs=$memory_jobs
[ "$jobs" -ge 1 ] || jobs=1
jobs=${TALUS_JOBS:-$jobs}

options=(-G Ninja -DCMAKE_BUILD_TYPE=Release)
if command -v ccache >/dev/null; then
  options+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
fi
mkdir -p build
echo "Configuring (build/configure.log)"
cmake -S . -B build "${options[@]}" >build/configure.log 2>&1 || { cat build/configure.log >&2; exit 1; }
if [ $# -eq 0 ]; then set -- all; fi
echo "Building: $* ($jobs jobs; some minutes the first time)"
cmake --build build --parallel "$jobs" --target "$@"
