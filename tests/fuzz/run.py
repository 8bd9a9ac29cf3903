#!/usr/bin/env python3
"""Builds the fuzz targets with clang, ASan and UBSan, and runs each for a number of inputs.

  python3 tests/fuzz/run.py --runs 1000000
  python3 tests/fuzz/run.py --only scene,mesh --runs 100000 --seconds 600
  python3 tests/fuzz/run.py --keep          # the smallest set of inputs that covers the same code goes to the corpus
"""
import argparse
import os
import re
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
TARGETS = ("scene", "particles", "mesh", "checkpoint", "series", "kernels")


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--runs", type=int, default=1000000)
    p.add_argument("--seconds", type=int, default=3600, help="at most so long per target")
    p.add_argument("--only", default=",".join(TARGETS))
    p.add_argument("--keep", action="store_true")
    p.add_argument("--build", default=os.path.join(ROOT, "build", "fuzz"))
    args = p.parse_args()
    names = args.only.split(",")
    for name in names:
        if name not in TARGETS:
            p.error(f"unknown target '{name}'; there are {', '.join(TARGETS)}")
    subprocess.run(["cmake", "-S", ROOT, "-B", args.build, "-G", "Ninja", "-DCMAKE_CXX_COMPILER=clang++", "-DCMAKE_C_COMPILER=clang",
                    "-DTALUS_FUZZ=ON", "-DTALUS_TESTS=OFF", "-DTALUS_PERF=OFF"], check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["cmake", "--build", args.build, "--target", *("fuzz_" + n for n in names)], check=True, stdout=subprocess.DEVNULL)
    failed = False
    for name in names:
        corpus = os.path.join(ROOT, "tests", "fuzz", "corpus", name)
        work, found = os.path.join(args.build, "corpus", name), os.path.join(args.build, "found", name + "-")
        for folder in (work, os.path.dirname(found)):
            os.makedirs(folder, exist_ok=True)
        done = subprocess.run([os.path.join(args.build, "fuzz_" + name), f"-runs={args.runs}", f"-max_total_time={args.seconds}",
                               "-max_len=4096", "-timeout=10", "-rss_limit_mb=4096", f"-artifact_prefix={found}",
                               "-print_final_stats=1", "-verbosity=0", work, corpus],
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace", check=False)
        runs = re.search(r"number_of_executed_units: (\d+)", done.stdout)
        verdict = "held" if done.returncode == 0 else f"FOUND SOMETHING (exit {done.returncode})"
        print(f"{name:<11} {int(runs.group(1)) if runs else 0:>9} inputs  {verdict}", flush=True)
        if done.returncode != 0:
            failed = True
            print(done.stdout[-3000:])
        elif args.keep:
            subprocess.run([os.path.join(args.build, "fuzz_" + name), "-merge=1", "-max_len=2048", corpus, work], check=True,
                           stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
