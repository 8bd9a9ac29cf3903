#!/usr/bin/env python3
"""What heat, conversion and gas change of the K study: a table from the study's runs of the furnace.

  python3 perf/study.py --small --cases furnace --few --series paper,local,others   # first (two to four minutes)
  python3 perf/furnace_k.py                                    # the table; exit 1 where two runs differ in a bit
  python3 perf/furnace_k.py --write                            # puts it on measured/furnace.md
  python3 perf/furnace_k.py --study DIR                        # where the study lies (build/study)

Lists: displacement check, rebuild, sort epoch. Parts: the nodes of heat, conversion and gas, and the one that changes
sizes. The columns "without" leave the parts' time out: what the same lists would be worth to the mechanics alone.
Medians over the repeats. Needs no package.
"""
import argparse
import json
import os
import statistics
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, HERE)
sys.dont_write_bytecode = True
from page_table import write_table  # noqa: E402

LISTS, NARROW = ("displacement_check", "rebuild", "sort_epoch"), ("narrow_phase",)
INEXACT = ("fixed",)


def is_part(node):
    return node == "resize" or node.startswith(("gas_", "heat_", "conversion"))


class Point:
    def __init__(self, name, rows):
        def of(takes):
            return statistics.median(sum(s for n, s in r["nodes"].items() if takes(n)) for r in rows)

        self.name, self.steps = name, rows[0]["steps"]
        self.wall, self.rebuilds = statistics.median(r["wall_s"] for r in rows), rows[0]["rebuilds"]
        self.all, self.parts, self.gas = of(lambda n: True), of(is_part), of(lambda n: n == "gas_step")
        self.lists, self.narrow = of(lambda n: n in LISTS), of(lambda n: n in NARROW)
        self.rest = self.all - self.parts - self.lists - self.narrow
        self.bare = self.all - self.parts
        self.series, self.value = rows[0]["series"], rows[0]["value"]


def row(p, none):
    return (f"| {p.name} | {1e6 * p.wall / p.steps:.0f} | {100 * p.rebuilds / p.steps:.1f} | {100 * p.lists / p.all:.1f} | {100 * p.narrow / p.all:.1f} | "
            f"{100 * p.rest / p.all:.0f} | {100 * p.parts / p.all:.0f} | {100 * (1 - p.all / none.all):.0f} | {100 * p.lists / p.bare:.1f} | {100 * (1 - p.bare / none.bare):.0f} |")


def findings(points, none, rows):
    held = [p for p in points if p.series not in INEXACT]
    out = []
    for series in ("paper", "local"):
        sweep = [p for p in held if p.series == series]
        if sweep:
            whole, bare = min(sweep, key=lambda p: p.all), min(sweep, key=lambda p: p.bare)
            out.append(f"- Best K of `{series}`: {whole.value} with the parts ({100 * (1 - whole.all / none.all):.0f} % less than rebuilding at every step), "
                       f"{bare.value} by the mechanics alone ({100 * (1 - bare.bare / none.bare):.0f} % less).")
    parts = [p.parts / p.steps for p in held]
    out.append(f"- Heat, conversion and gas take {1e6 * min(parts):.0f} to {1e6 * max(parts):.0f} us per step whatever the list; the gas step alone is "
               f"{100 * statistics.median(p.gas / p.parts for p in held):.0f} % of that.")
    hashes = sorted({r["state_hash"] for r in rows if r["series"] not in INEXACT})
    out.append(f"- {sum(r['series'] not in INEXACT for r in rows)} runs with exact lists end in {len(hashes)} state hash{'es' if len(hashes) > 1 else ''}: {', '.join(hashes)}.")
    return out, len(hashes) == 1


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--study", default=os.path.join(HERE, "..", "build", "study"), help="folder of perf/study.py")
    parser.add_argument("--case", default="furnace")
    parser.add_argument("--write", action="store_true", help="put the table on measured/furnace.md")
    args = parser.parse_args()
    journal = os.path.join(args.study, "runs.jsonl")
    if not os.path.exists(journal):
        parser.error(f"{journal} is not there: run perf/study.py --small --cases furnace first")
    with open(journal, encoding="utf-8") as f:
        rows = [r for r in map(json.loads, f) if r["case"] == args.case]
    versions = {(r["version"], r["isa"], r["threads"], r["steps"]) for r in rows}
    if len(versions) != 1 or not any(r["point"] == "none" for r in rows):
        parser.error(f"{journal}: needs runs of one build, with the point 'none'; there are {len(versions)} builds")
    points = [Point(name, [r for r in rows if r["point"] == name]) for name in dict.fromkeys(r["point"] for r in rows)]
    points.sort(key=lambda p: ({"none": 0, "paper": 1, "local": 2}.get(p.series, 3), p.value if isinstance(p.value, (int, float)) else 0, p.name))
    none = next(p for p in points if p.name == "none")
    said, same = findings(points, none, rows)
    lines = [f"{max(r['particles'] for r in rows)} grains, {none.steps} steps, {len(rows) // len(points)} repeats, one thread, {rows[0]['isa']}.", "",
             "| list | us/step | rebuilds % | lists % | narrow phase % | contacts, walls, motion % | heat, conversion, gas % | less than none % | lists % without | less than none % without |",
             "|---" * 10 + "|", *[row(p, none) for p in points], "", *said]
    print("\n".join(lines))
    if args.write:
        write_table(os.path.join(HERE, "measured", "furnace.md"), "furnace", lines)
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main())
