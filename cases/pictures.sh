#!/bin/bash
# Draws the picture of every case from a run of it: bash cases/pictures.sh [TALUS]. Some minutes on two cores; the tutorial's
# pictures are made by cases/tutorial/run_all.sh.
set -euo pipefail
cd "$(dirname "$0")/.."
talus=${1:-build/talus}
python=/usr/bin/python3

# picture CASE SCENE STEPS [options of draw.py]; NAME=file without .png
picture() {
  local folder=results/pictures/$1
  rm -rf "$folder"
  "$talus" run "cases/$1/$2" --out "$folder" --steps "$3" --quiet
  "$python" cases/draw.py "$folder" --out "cases/$1/${NAME:-picture}.png" --width 640 "${@:4}"
}
for make in incline avalanche levelling; do "$python" "cases/$make/make_$make.py" >/dev/null; done
picture hopper hopper-20k.toml 45000
picture grates small.toml 75000 --azimuth 12 --elevation 12
picture incline small.toml 45000 --azimuth 25 --elevation 25
picture avalanche small.toml 16000 --azimuth 30 --elevation 30 --no-walls
picture levelling small.toml 60000 --azimuth 20 --elevation 20
NAME=track picture levelling laser.toml 82000 --by temperature --time 0.0241 --azimuth 15 --elevation 35
NAME=lentils picture shapes lentil-heap.toml 150000 --azimuth 25 --elevation 20 --no-walls
NAME=wheat picture shapes wheat-drum.toml 40000 --azimuth 15 --elevation 12
