#!/bin/bash
# From a fresh clone to a result: installs what is missing, builds, runs the 20k hopper with a progress bar and says where
# the results are. Arguments are handed to `talus run` (for example --threads 4).
set -euo pipefail
cd "$(dirname "$0")/.."

bash cases/install.sh
bash cases/build.sh talus talus_docs
exec build/talus run cases/hopper/hopper-20k.toml --out results/hopper-20k --overwrite "$@"
