#!/bin/bash
# Lane outside the fast tests: builds the Debian package, installs it into this system (root or sudo), uses it as a stranger
# would, and removes it again: bash tests/package.sh. Needs a build (cases/build.sh). The last line is "package: passed".
set -euo pipefail
cd "$(dirname "$0")/.."
source_dir=$PWD
sudo=(); [ "$(id -u)" -eq 0 ] || sudo=(sudo)
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
step() { echo "== $*"; }

step "build the package"
bash cases/build.sh talus talus_docs >/dev/null
(cd build && cpack -G DEB -B "$scratch/out" >"$scratch/cpack.log" 2>&1) || { cat "$scratch/cpack.log"; exit 1; }
package=$(ls "$scratch"/out/*.deb)
dpkg-deb --info "$package" | sed -n 's/^ \(Package\|Version\|Depends\|Recommends\)/\1/p'

step "install it"
"${sudo[@]}" dpkg -i "$package" >/dev/null
trap '"${sudo[@]}" dpkg -r talus >/dev/null 2>&1; rm -rf "$scratch"' EXIT
[ "$(command -v talus)" = /usr/bin/talus ]
cd "$scratch"
talus --version

step "run, report, convert"
talus run /usr/share/talus/cases/tutorial/1-box/scene.toml --out box --steps 500 --quiet
talus report box >/dev/null
talus convert box box.csv
grep -q "state_hash" box/summary.json

step "man page, completions"
if [ -e /usr/share/man/man1/talus.1 ]; then  # small systems leave man pages out
  MANWIDTH=80 man talus | grep "EXIT STATUS" >/dev/null
fi
bash -c 'source /usr/share/bash-completion/completions/talus; COMP_WORDS=(talus ru); COMP_CWORD=1; _talus
         [ "${COMPREPLY[*]}" = run ]'

step "find_package(Talus)"
mkdir app
cat >app/CMakeLists.txt <<'END'
cmake_minimum_required(VERSION 3.25)
project(app CXX)
find_package(Talus REQUIRED)
add_executable(app app.cpp)
target_link_libraries(app Talus::Talus)
END
cat >app/app.cpp <<'END'
#include <cstdio>
#include "core/scene/scene_file.hpp"
#include "scheduler/simulation.hpp"
int main(int, char** argv) {
  const talus::Scene scene = talus::load_scene(argv[1]);
  talus::Simulation simulation(scene, talus::RunOptions{});
  simulation.run(500);
  std::printf("%016llx\n", static_cast<unsigned long long>(simulation.state_hash()));
}
END
cmake -S app -B app/build >/dev/null
cmake --build app/build >/dev/null
hash=$(app/build/app /usr/share/talus/cases/tutorial/1-box/scene.toml)
grep -q "\"state_hash\": \"$hash\"" box/summary.json || { echo "the library ends in $hash, the program does not"; exit 1; }

step "remove it"
"${sudo[@]}" dpkg -r talus >/dev/null
hash -r
if command -v talus >/dev/null; then echo "the program is still there"; exit 1; fi
cd "$source_dir"
echo "package: passed"
