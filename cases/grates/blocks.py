#!/usr/bin/env python3
"""Block means of a furnace's run, to see whether it is steady.

  python3 cases/grates/blocks.py results/furnace                # blocks of 10 s
  python3 cases/grates/blocks.py results/furnace --block 5 --from 20
"""
import argparse
import csv
import os
import sys


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", help="of a run, also of one that goes on")
    parser.add_argument("--block", type=float, default=10, help="[s]")
    parser.add_argument("--from", type=float, default=0, dest="start", help="first block begins here [s]")
    args = parser.parse_args()
    if not args.block > 0:
        parser.error("--block must be above 0")
    with open(os.path.join(args.folder, "series.csv")) as f:
        rows = [{k: float(v) for k, v in r.items() if v} for r in csv.DictReader(line for line in f if not line.startswith("#"))]
    print("| time [s] | water [g] | wood [g] | char [g] | oxygen taken [g/s] | grains that left per s |\n|---|---|---|---|---|---|")
    a = args.start
    while a + args.block <= rows[-1]["time"] + 1e-9:
        block = [r for r in rows if a - 1e-9 <= r["time"] <= a + args.block + 1e-9]
        means = [1e3 * sum(r["conversion." + k] for r in block) / len(block) for k in ("moisture", "fuel", "char")]
        rate = [(block[-1][k] - block[0][k]) / args.block for k in ("conversion.oxygen_taken", "removed")]
        print(f"| {a:g} to {a + args.block:g} | {means[0]:.3f} | {means[1]:.2f} | {means[2]:.2f} | {1e3 * rate[0]:.3f} | {rate[1]:.1f} |")
        a += args.block
    return 0


if __name__ == "__main__":
    sys.exit(main())
