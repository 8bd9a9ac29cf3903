#!/bin/bash
# From a fresh clone to a tested build: installs what is missing, builds everything, runs the tests. The last line is
# "N passed, N failed"; the exit code is 0 only if nothing failed. Called by people and by .ci/run.
#   bash tests/run_all.sh               the fast lane (CI)
#   TALUS_FULL=1 bash tests/run_all.sh  also the long sweeps (hours): tests read TALUS_FULL to widen their ranges
#   bash tests/run_all.sh -R Skin       arguments go to ctest
set -uo pipefail
cd "$(dirname "$0")/.."

failed_early() {
  echo "tests/run_all.sh: $1"
  echo "0 passed, 1 failed"
  exit 1
}
bash cases/install.sh </dev/null || failed_early "installation failed"
bash cases/build.sh </dev/null || failed_early "build failed"

limit=900
[ -z "${TALUS_FULL:-}" ] || limit=36000
results=$PWD/build/ctest.xml
rm -f "$results"
ctest --test-dir build --parallel "$(nproc)" --timeout "$limit" --output-on-failure --no-tests=error \
  --output-junit "$results" "$@" </dev/null
code=$?

attribute() { sed -n "s/.*[[:space:]]$1=\"\([0-9]*\)\".*/\1/p" "$results" 2>/dev/null | head -1; }
all=$(attribute tests)
failed=$(attribute failures)
skipped=$(($(attribute skipped) + $(attribute disabled)))
[ -n "$all" ] || failed_early "ctest wrote no results"
# A test program that cannot be listed or that crashes ctest must not look like success.
if [ "$code" -ne 0 ] && [ "$failed" -eq 0 ]; then failed=1; fi
if [ "$skipped" -gt 0 ]; then echo "$skipped skipped"; fi
echo "$((all - failed - skipped)) passed, $failed failed"
[ "$failed" -eq 0 ]
