#!/usr/bin/env python3
"""The forty-six stiff and extreme scenarios as a table: scenario, what was asserted, measured figure, verdict.

    python3 perf/stability.py                          table of build/tests/test_stability
    python3 perf/stability.py --build DIR --json F     another build folder; the rows also as JSON
    python3 perf/stability.py --only 8,10              some scenarios
    TALUS_FULL=1 python3 perf/stability.py             the long variants

Verdicts: holds; partly (passes, with a shortfall that is printed below the table); pending (the engine lacks the
feature: listed, not passed); fails; missing (no such test). Exit code 1 if any scenario fails or is missing.
"""

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
import textwrap

SCENARIOS = 46


def words(name):
    """'S07_RadiusRatio100ListComplete' -> 'radius ratio 100 list complete'."""
    parts = re.findall(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])|\d+", name.split("_", 1)[1])
    return " ".join(p if p.isupper() and len(p) > 1 else p.lower() for p in parts)


def run(binary, only):
    pattern = ":".join(f"Stability.S{k:02d}_*" for k in only) if only else "Stability.*"
    with tempfile.TemporaryDirectory() as folder:
        report = os.path.join(folder, "report.json")
        command = [binary, f"--gtest_filter={pattern}", f"--gtest_output=json:{report}"]
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if not os.path.exists(report):
            sys.exit(f"stability.py: {binary} left no report (exit {done.returncode}):\n{done.stdout[-2000:]}")
        with open(report) as f:
            return json.load(f)


def row_of(test):
    failures = [f["failure"] for f in test.get("failures", [])]
    row = {
        "scenario": int(test["name"][1:3]),
        "name": test["name"],
        "asserted": test.get("asserted", ""),
        "figure": test.get("figure", ""),
        "seconds": float(test.get("time", "0s").rstrip("s")),
        "note": "",
    }
    if failures:
        row["verdict"] = "fails"
        row["note"] = failures[0].split("\n", 1)[-1].replace("\n", " ")[:400]
    elif test.get("result") == "SKIPPED" or "pending" in test:
        row["verdict"] = "pending"
        row["note"] = test.get("pending", "skipped")
    elif "shortfall" in test:
        row["verdict"] = "partly"
        row["note"] = test["shortfall"]
    else:
        row["verdict"] = "holds"
    return row


def rows_of(report, wanted):
    rows = [row_of(t) for suite in report.get("testsuites", []) for t in suite.get("testsuite", [])]
    present = {r["scenario"] for r in rows}
    for k in wanted:
        if k not in present:
            rows.append({"scenario": k, "name": f"S{k:02d}_Missing", "asserted": "", "figure": "", "seconds": 0,
                         "verdict": "missing", "note": "no test of this number"})
    return sorted(rows, key=lambda r: (r["scenario"], r["name"]))


def print_table(rows):
    widths = (34, 46, 40)
    print(f"{'#':>2}  {'scenario':<{widths[0]}} {'asserted':<{widths[1]}} {'figure':<{widths[2]}} verdict")
    print("-" * (sum(widths) + 15))
    for r in rows:
        cells = [textwrap.wrap(text, w) or [""] for text, w in zip((words(r["name"]), r["asserted"], r["figure"]), widths)]
        for k in range(max(map(len, cells))):
            line = [c[k] if k < len(c) else "" for c in cells]
            first = f"{r['scenario']:>2}" if k == 0 else "  "
            last = r["verdict"] if k == 0 else ""
            print(f"{first}  {line[0]:<{widths[0]}} {line[1]:<{widths[1]}} {line[2]:<{widths[2]}} {last}".rstrip())
    print()
    for r in rows:
        if r["note"]:
            print(textwrap.fill(f"{r['scenario']:>2} {r['verdict']}: {r['note']}", 120, subsequent_indent="   "))
    count = {v: sum(r["verdict"] == v for r in rows) for v in ("holds", "partly", "pending", "fails", "missing")}
    print(f"\n{len(rows)} rows: " + ", ".join(f"{n} {v}" for v, n in count.items() if n)
          + f"; {sum(r['seconds'] for r in rows):.0f} s")


def main():
    here = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", default=os.path.join(here, "build"), help="build folder (default: build)")
    parser.add_argument("--only", default="", help="numbers of scenarios, comma separated")
    parser.add_argument("--json", help="write the rows to this file")
    options = parser.parse_args()
    binary = os.path.join(options.build, "tests", "test_stability")
    if not os.access(binary, os.X_OK):
        sys.exit(f"stability.py: no {binary}: build it (ninja -C {options.build} test_stability) or give --build DIR")
    try:
        only = [int(k) for k in options.only.split(",") if k]
    except ValueError:
        sys.exit(f"stability.py: --only {options.only}: numbers of scenarios, as in --only 8,10")
    rows = rows_of(run(binary, only), only or range(1, SCENARIOS + 1))
    print_table(rows)
    if options.json:
        with open(options.json, "w") as f:
            json.dump(rows, f, indent=1)
    return 1 if any(r["verdict"] in ("fails", "missing") for r in rows) else 0


if __name__ == "__main__":
    sys.exit(main())
