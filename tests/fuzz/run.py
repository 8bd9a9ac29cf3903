#!/usr/bin/env python3
"""Fuzzes the readers of files and the contact kernels with libFuzzer, ASan and UBSan.

  python3 tests/fuzz/run.py --runs 1000000
  python3 tests/fuzz/run.py --only scene,mesh --runs 100000

Builds build/fuzz with clang (apt-get install clang libclang-rt-14-dev), runs every target on that many inputs, one
target after the other, and prints for each: inputs, seconds, findings. An input that ends a target is left in
build/fuzz/found; the exit code is then 1. Inputs that reach new code are kept in build/fuzz/corpus for the next run.
"""
import argparse
import os
import re
import resource
import subprocess
import sys
import time

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
# longest input [bytes]
TARGETS = {"scene": 4096, "particles": 1024, "mesh": 1024, "series": 2048, "summary": 1024, "checkpoint": 512,
           "kernels": 512, "contacts": 128}
LIMIT = 10  # [s] for one input


def build(folder, names):
    subprocess.run(["cmake", "-S", ROOT, "-B", folder, "-G", "Ninja", "-DCMAKE_C_COMPILER=clang", "-DCMAKE_CXX_COMPILER=clang++",
                    "-DTALUS_FUZZ=ON", "-DTALUS_TESTS=OFF", "-DTALUS_PERF=OFF"], check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["cmake", "--build", folder, "--parallel", str(os.cpu_count()), "--target", *("fuzz_" + n for n in names)],
                   check=True, stdout=subprocess.DEVNULL)


def run(command):
    """Exit code, output, and seconds of processor time."""
    environment = dict(os.environ, TMPDIR="/dev/shm" if os.path.isdir("/dev/shm") else "/tmp")
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace", check=False,
                          env=environment)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return done.returncode, done.stdout, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def only_a_slow_machine(program, output):
    """libFuzzer's limit counts seconds of the clock: on a busy machine, or one that was stopped, a quick input runs into
    it. Such an input is tried again by the processor's time, and removed if it is quick."""
    slow = re.search(r"Test unit written to (\S*-?timeout-\S+)", output)
    if slow is None:
        return False
    code, _, seconds = run([program, "-timeout=1000", slow.group(1)])
    if code != 0 or seconds > LIMIT:
        return False
    os.remove(slow.group(1))
    return True


def fuzz(folder, name, runs, seed):
    """Number of inputs, seconds, and the output where something was found."""
    work, found = os.path.join(folder, "corpus", name), os.path.join(folder, "found")
    os.makedirs(work, exist_ok=True)
    os.makedirs(found, exist_ok=True)
    program = os.path.join(folder, "tests", "fuzz", "fuzz_" + name)
    begin, done = time.monotonic(), 0
    while done < runs:
        code, output, _ = run([program, f"-runs={runs - done}", f"-seed={seed + done}", f"-max_len={TARGETS[name]}", "-entropic=0",
                               f"-timeout={LIMIT}", "-rss_limit_mb=4096", "-print_final_stats=1", "-print_funcs=0", "-verbosity=0",
                               f"-artifact_prefix={found}/{name}-", work, os.path.join(ROOT, "tests", "fuzz", "corpus", name)])
        units = re.search(r"number_of_executed_units:\s*(\d+)", output)
        done += int(units.group(1)) if units else 0
        if code == 0 or not only_a_slow_machine(program, output):
            return done, time.monotonic() - begin, output if code != 0 else ""
    return done, time.monotonic() - begin, ""


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--runs", type=int, default=1000000, help="inputs per target")
    p.add_argument("--only", default=",".join(TARGETS))
    p.add_argument("--seed", type=int, default=1)
    p.add_argument("--build", default=os.path.join(ROOT, "build", "fuzz"))
    args = p.parse_args()
    names = args.only.split(",")
    for name in names:
        if name not in TARGETS:
            p.error(f"unknown target '{name}'; there are {', '.join(TARGETS)}")
    build(args.build, names)
    findings = 0
    print(f"{'target':<11} {'inputs':>9} {'seconds':>8} {'findings':>8}")
    for name in names:
        runs, seconds, output = fuzz(args.build, name, args.runs, args.seed)
        findings += output != ""
        print(f"{name:<11} {runs:>9} {seconds:>8.0f} {int(output != ''):>8}", flush=True)
        if output:
            print(output[-4000:], flush=True)
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
