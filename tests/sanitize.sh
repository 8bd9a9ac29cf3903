#!/bin/bash
# Lanes with sanitizers, outside CI. Each builds into build/sanitize/LANE, runs tests and ends with the number of reports
# of the sanitizers, of the tests and of their child processes; the exit code is 0 only without reports and failures.
#   bash tests/sanitize.sh asan    ASan and UBSan, the whole suite (needs what tests/run_all.sh needs)
#   bash tests/sanitize.sh tsan    TSan, test_determinism, with a oneTBB that is built with TSan too (Debian's own gives
#                                  false reports): its source comes from Debian into the build folder. No suppressions.
# Each test program runs once as a whole: by the single test most of the time would go into starting programs. Further
# arguments go to the test programs. JOBS=N: programs and compilers at a time (default: all cores). TALUS_ISAS="scalar;avx512":
# kernels of these instruction sets alone (halves the build). PROGRAMS="test_cli test_io": these programs alone.
set -uo pipefail
cd "$(dirname "$0")/.."
lane=${1:-}
[ "$lane" = asan ] || [ "$lane" = tsan ] || { sed -n '2,11s/^# \{0,1\}//p' "$0"; exit 2; }
shift
folder=$PWD/build/sanitize/$lane
jobs=${JOBS:-$(nproc)}
mkdir -p "$folder"
fail() { echo "tests/sanitize.sh: $1"; exit 1; }

# Debian's source of oneTBB, with lists and cache of its own: needs neither root nor a change of the system's sources.
fetch_tbb() {
  local apt=$folder/apt
  mkdir -p "$apt/lists/partial" "$apt/cache/archives/partial"
  echo 'deb-src [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] http://deb.debian.org/debian bookworm main' >"$apt/sources.list"
  local options=(-o "Dir::Etc::sourcelist=$apt/sources.list" -o Dir::Etc::sourceparts=/dev/null -o "Dir::State::lists=$apt/lists"
                 -o "Dir::Cache=$apt/cache" -o "APT::Sandbox::User=$(id -un)")
  (cd "$folder" && apt-get -qq "${options[@]}" update && apt-get -qq "${options[@]}" source --download-only onetbb &&
    rm -rf onetbb && dpkg-source --no-check -x onetbb_*.dsc onetbb >/dev/null)
}

build_tbb() {
  [ -f "$folder/tbb/lib/libtbb.so" ] && return
  [ -d "$folder/onetbb" ] || fetch_tbb || fail "the source of oneTBB could not be fetched"
  cmake -S "$folder/onetbb" -B "$folder/onetbb-build" -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DTBB_TEST=OFF -DTBB_STRICT=OFF \
    -DTBBMALLOC_BUILD=OFF -DTBB_SANITIZE=thread -DCMAKE_INSTALL_LIBDIR=lib -DCMAKE_INSTALL_PREFIX="$folder/tbb" >/dev/null &&
    cmake --build "$folder/onetbb-build" --parallel "$jobs" >/dev/null && cmake --install "$folder/onetbb-build" >/dev/null ||
    fail "oneTBB was not built"
}

# A build type of its own: CMakeLists.txt sets the flags of Release whatever the command line says, and at -O3 the
# compilers take hours. Without inlining the hand-written vector code would be too slow for the tests.
options=(-DCMAKE_BUILD_TYPE=Sanitized "-DCMAKE_CXX_FLAGS_SANITIZED=-O1 -finline-functions -g1" -DTALUS_PERF=OFF)
if [ -n "${TALUS_ISAS:-}" ]; then options+=("-DTALUS_ISAS=$TALUS_ISAS"); fi
if command -v ccache >/dev/null; then options+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi
if [ "$lane" = asan ]; then
  options+=(-DTALUS_SANITIZE=address,undefined)
  target=${PROGRAMS:-all}
else
  build_tbb
  options+=(-DTALUS_SANITIZE=thread "-DTBB_DIR=$folder/tbb/lib/cmake/TBB")
  target=test_determinism
fi
cmake -S . -B "$folder/talus" -G Ninja "${options[@]}" >/dev/null || fail "configuration failed"
cmake --build "$folder/talus" --parallel "$jobs" --target $target >"$folder/build.log" 2>&1 ||
  { tail -30 "$folder/build.log"; fail "build failed"; }

rm -rf "$folder/reports"
mkdir -p "$folder/reports"
common=log_path=$folder/reports
export ASAN_OPTIONS=$common/asan:detect_stack_use_after_return=1:strict_string_checks=1
export UBSAN_OPTIONS=$common/ubsan:print_stacktrace=1
export TSAN_OPTIONS=$common/tsan:second_deadlock_stack=1
begin=$SECONDS
if [ -n "${PROGRAMS:-}" ]; then
  programs=()
  for name in $PROGRAMS; do programs+=("$folder/talus/tests/$name"); done
elif [ "$lane" = asan ]; then
  mapfile -t programs < <(find "$folder/talus/tests" -maxdepth 1 -type f -executable -name 'test_*')
else
  programs=("$folder/talus/tests/test_determinism")
fi
run_program() {
  local log=$1.log begin=$SECONDS code
  "$@" >"$log" 2>&1 </dev/null
  code=$?
  echo "$(basename "$1"): exit code $code, $((SECONDS - begin)) s; $(grep -E '^\[  (PASSED|FAILED) ' "$log" | head -20 | tr '\n' ' ')"
  return $code
}
export -f run_program
printf '%s\0' "${programs[@]}" | xargs -0 -I{} -P "$jobs" bash -c 'run_program "$@"' - {} "$@"
code=$?
reports=$(cat "$folder"/reports/* 2>/dev/null | grep -cE 'ERROR: |WARNING: ThreadSanitizer|runtime error:')
echo "$lane: tests $([ $code -eq 0 ] && echo passed || echo failed), $((SECONDS - begin)) s, $reports reports ($folder/reports)"
[ "$code" -eq 0 ] && [ "$reports" -eq 0 ]
