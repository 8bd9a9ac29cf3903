#!/usr/bin/env python3
"""The speed table of the README from perf/results/MACHINE/peers.csv: python3 perf/readme_table.py [--write|--check].

One row per scene, at most eight. --write puts it between the marks of the README, --check says whether it is there.
"""
import argparse
import csv
import os
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
BEGIN, END = "<!-- peers:begin", "<!-- peers:end -->"
MACHINE_BEGIN, MACHINE_END = "<!-- machine:begin -->", "<!-- machine:end -->"


def rows(machine):
    with open(os.path.join(HERE, "results", machine, "peers.csv"), newline="", encoding="utf-8") as f:
        table = list(csv.DictReader(f))
    if len(table) > 8:
        sys.exit(f"{len(table)} rows: the README shows at most 8")
    for r in table:
        span = f" ({r['lammps_low']} … {r['lammps_high']})" if r["lammps_low"] else ""
        yield f"| {r['text']} | {r['rate']} | {r['lammps']}{span} | {r['liggghts']} |"


def between(text, begin, end, new):
    """The text with what stands between the line of one mark and another replaced."""
    start = text.index("\n", text.index(begin)) + 1
    return text[:start] + new + text[text.index(end):]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--machine", default="zen5", help="folder below perf/results")
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--check", action="store_true")
    options = parser.parse_args()
    head = "\n| one core, rebuilds included | million particle-steps/s | × LAMMPS | × LIGGGHTS |\n|---|---|---|---|\n"
    table = head + "".join(r + "\n" for r in rows(options.machine)) + "\n"
    with open(os.path.join(HERE, "results", options.machine, "machine.txt"), encoding="utf-8") as f:
        machine = f.read().strip()
    machine = f"{machine}. Made by `python3 perf/peers.py --scenes all`; more in [perf/measured.md](perf/measured.md).\n"
    readme = os.path.join(os.path.dirname(HERE), "README.md")
    with open(readme, encoding="utf-8") as f:
        text = f.read()
    new = between(between(text, BEGIN, END, table), MACHINE_BEGIN, MACHINE_END, machine)
    if options.write:
        with open(readme, "w", encoding="utf-8") as f:
            f.write(new)
    elif options.check:
        if new != text:
            sys.exit("README.md does not show perf/results: python3 perf/readme_table.py --write")
    else:
        print(table + machine, end="")


if __name__ == "__main__":
    main()
