#!/bin/bash
# Installs what Talus needs from Debian bookworm (or a relative of it), nothing else. Called by cases/run_hopper.sh and
# tests/run_all.sh. Idempotent: does not touch apt when everything is present. Root or sudo.
set -euo pipefail

packages=(
  build-essential cmake ninja-build pkg-config
  libtbb-dev libeigen3-dev libxsimd-dev libfmt-dev libcli11-dev   # engine and command line
  libtomlplusplus-dev libhdf5-dev libxxhash-dev zlib1g-dev  # files
  libgtest-dev libbenchmark-dev                                   # tests and benchmarks
  file                                                            # cpack asks it which libraries a package needs
  zsh                                                             # a test of its completions
  python3 python3-numpy python3-matplotlib python3-h5py python3-vtk9  # reports, and tests of what was written
)

missing=()
for package in "${packages[@]}"; do
  status=$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null || true)
  [ "$status" = installed ] || missing+=("$package")
done
if [ ${#missing[@]} -eq 0 ]; then
  exit 0
fi
if ! command -v apt-get >/dev/null; then
  echo "install.sh: no apt-get here; install the equivalents of: ${missing[*]}" >&2
  exit 1
fi

sudo=()
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null || { echo "install.sh: needs root or sudo to install: ${missing[*]}" >&2; exit 1; }
  sudo=(sudo)
fi
echo "Installing ${#missing[@]} packages (a minute or two, silently): ${missing[*]}"
# env: sudo drops DEBIAN_FRONTEND, and a question from debconf would hang a CI machine.
"${sudo[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -o Acquire::Retries=3 -qq update
"${sudo[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -o Acquire::Retries=3 -o Dpkg::Use-Pty=0 -qq \
  install -y --no-install-recommends "${missing[@]}" >/dev/null
