#!/bin/bash
# Runs all lessons and draws their pictures: bash cases/tutorial/run_all.sh [TALUS]. About a minute on one core.
set -euo pipefail
cd "$(dirname "$0")/../.."
talus=${1:-build/talus}
python=/usr/bin/python3
lesson() {
  rm -rf "results/tutorial/$1"
  "$talus" run "cases/tutorial/$1/scene.toml" --out "results/tutorial/$1" --quiet "${@:2}"
}
draw() { "$python" cases/draw.py "results/tutorial/$1" --out "cases/tutorial/$1/picture.png" --width 640 "${@:2}"; }

lesson 1-box; draw 1-box --time 0.12
lesson 2-material; draw 2-material --by material --azimuth 8 --elevation 12
lesson 3-drum; draw 3-drum --azimuth 8 --elevation 6
lesson 4-mesh; draw 4-mesh --elevation 30
"$talus" convert results/tutorial/3-drum cases/tutorial/5-restart/state.csv --overwrite
lesson 5-restart; draw 5-restart --azimuth 8 --elevation 6 --time 0.06
lesson 6-plot; "$python" cases/tutorial/6-plot/plot.py results/tutorial/6-plot --out cases/tutorial/6-plot/picture.png
further() {
  rm -rf "results/tutorial/$1"
  "$talus" run "cases/tutorial/further/$1.toml" --out "results/tutorial/$1" --quiet
  "$python" cases/draw.py "results/tutorial/$1" --out "cases/tutorial/further/$1.png" --width 480 "${@:2}"
}
further collapse --azimuth 12 --elevation 10 --time 0.4
further oedometer --azimuth 20 --elevation 10
further vibrated-box --by size --azimuth 20 --elevation 10
lesson 7-repose; draw 7-repose --by size; "$python" cases/tutorial/7-repose/repose.py results/tutorial/7-repose
