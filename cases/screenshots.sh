#!/bin/bash
# Pictures of pages, made by a headless Chromium (apt-get install chromium): bash cases/screenshots.sh [TALUS]. The report of a
# tutorial lesson (top and whole), and all pictures of the README; cases/tutorial/2-material/report.png is the former, smaller.
set -euo pipefail
cd "$(dirname "$0")/.."
talus=${1:-build/talus}
python=/usr/bin/python3
out=results/screenshots
mkdir -p "$out"
shot() { "$python" tests/io/check_browser.py --screenshot "$out/$1.png" "$2" "$3" "$4"; }

"$talus" run cases/tutorial/2-material/scene.toml --out "$out/run" --overwrite --quiet
"$talus" report "$out/run" >/dev/null
"$python" tests/io/check_browser.py "$out/run/report.html" "spheres are drawn"
shot report 1200 1500 "$out/run/report.html"
shot report-whole 1200 5000 "$out/run/report.html"
"$python" - "$out" <<'PYTHON'
import os, re, sys
with open("README.md", encoding="utf-8") as f:
    pictures = re.findall(r"!\[([^]]*)\]\(([^)]*)\)", f.read())
page = "".join(f"<figure><img width=360 src='{os.path.abspath(p)}'><figcaption>{t}</figcaption></figure>" for t, p in pictures)
with open(os.path.join(sys.argv[1], "readme.html"), "w", encoding="utf-8") as f:
    f.write(f"<body style='display: flex; flex-wrap: wrap'>{page}")
PYTHON
shot readme 1250 1100 "$out/readme.html"
"$python" - "$out/report.png" cases/tutorial/2-material/report.png <<'PYTHON'
import sys
from PIL import Image
image = Image.open(sys.argv[1]).convert("RGB")
image.resize((image.width * 2 // 3, image.height * 2 // 3), Image.LANCZOS).quantize(256, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE).save(sys.argv[2], optimize=True)
PYTHON
ls -l cases/tutorial/2-material/report.png
