#!/usr/bin/env python3
"""Do the tests bite? Breaks the code on purpose, one line at a time, and tells which faults the tests see.

  python3 tests/mutants.py                  # all faults of tests/mutants.txt, about an hour on two cores
  python3 tests/mutants.py --only skin,eta  # those whose name contains one of these words
  python3 tests/mutants.py --list           # checks that every fault still fits its file, builds nothing

Works in a copy of the checkout (--scratch, kept for the next call), builds incrementally, and runs for each fault first
the tests that should see it, then, if these pass, all test programs (--quick: not). A fault that does not compile counts
as an error of the table, not as killed. Prints killed and survived; exit 1 where less than 95 % are killed.
"""
import argparse
import os
import shutil
import subprocess
import sys
import time

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
FOLDERS = ("core", "kernels", "scheduler", "cases", "tests", "perf")


def read_table(path):
    """Blocks of `name | file | program filter`, `-old`, `+new`, separated by empty lines."""
    mutants = []
    with open(path, encoding="utf-8") as f:
        for block in f.read().split("\n\n"):
            lines = [line for line in block.splitlines() if line and not line.startswith("#")]
            if not lines:
                continue
            name, file, test = (part.strip() for part in lines[0].split("|"))
            old = "\n".join(line[1:] for line in lines[1:] if line.startswith("-"))
            new = "\n".join(line[1:] for line in lines[1:] if line.startswith("+"))
            mutants.append({"name": name, "file": file, "test": test.split(), "old": old, "new": new})
    return mutants


def mutated(mutant, root):
    """Text of the file with the fault in it; SystemExit where the line is not there exactly once."""
    with open(os.path.join(root, mutant["file"]), encoding="utf-8") as f:
        text = f.read()
    if text.count(mutant["old"]) != 1:
        raise SystemExit(f"mutants.py: {mutant['name']}: its line is {text.count(mutant['old'])} times in {mutant['file']}")
    return text, text.replace(mutant["old"], mutant["new"])


def copy(scratch):
    """The checkout as it is now; files keep their times so that only what has changed is built again."""
    os.makedirs(scratch, exist_ok=True)
    for folder in FOLDERS:
        for path, folders, files in os.walk(os.path.join(ROOT, folder)):
            folders[:] = [d for d in folders if d != "__pycache__"]
            to = os.path.join(scratch, os.path.relpath(path, ROOT))
            os.makedirs(to, exist_ok=True)
            for file in files:
                a, b = os.path.join(path, file), os.path.join(to, file)
                with open(a, "rb") as x:
                    new = x.read()
                if not os.path.exists(b) or open(b, "rb").read() != new:
                    shutil.copyfile(a, b)
                    shutil.copymode(a, b)
    for file in os.listdir(ROOT):
        if os.path.isfile(os.path.join(ROOT, file)) and file != "build":
            shutil.copyfile(os.path.join(ROOT, file), os.path.join(scratch, file))


def run(command, limit, **keywords):
    try:
        return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace",
                              timeout=limit, check=False, stdin=subprocess.DEVNULL, **keywords)
    except subprocess.TimeoutExpired:
        return None


def build(scratch, targets):
    done = run(["cmake", "--build", "build", "--target", *targets], 3600, cwd=scratch)
    return done is not None and done.returncode == 0, "" if done is None else done.stdout


def fails(scratch, program, pattern, limit):
    """Whether a test program sees the fault: a failure, a crash or a hang."""
    done = run([os.path.join("build", "tests", program), f"--gtest_filter={pattern}", "--gtest_brief=1", "--gtest_fail_fast"],
               limit, cwd=scratch)
    return done is None or done.returncode != 0


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--scratch", default=os.path.join(ROOT, "build", "mutants"))
    p.add_argument("--only", default="")
    p.add_argument("--list", action="store_true")
    p.add_argument("--quick", action="store_true", help="only the tests that should see a fault")
    args = p.parse_args()
    words = [w for w in args.only.split(",") if w]
    mutants = [m for m in read_table(os.path.join(ROOT, "tests", "mutants.txt")) if not words or any(w in m["name"] for w in words)]
    for m in mutants:
        mutated(m, ROOT)
    print(f"{len(mutants)} faults")
    if args.list:
        return 0
    scratch = os.path.abspath(args.scratch)
    copy(scratch)
    if not os.path.exists(os.path.join(scratch, "build", "build.ninja")):
        launcher = ["-DCMAKE_CXX_COMPILER_LAUNCHER=ccache"] if shutil.which("ccache") else []
        done = run(["cmake", "-S", ".", "-B", "build", "-G", "Ninja", "-DTALUS_PERF=OFF", *launcher], 600, cwd=scratch)
        if done is None or done.returncode != 0:
            raise SystemExit("mutants.py: cmake failed\n" + ("" if done is None else done.stdout))
    programs = sorted("test_" + d for d in os.listdir(os.path.join(scratch, "tests"))
                      if any(f.endswith(".cpp") for f in os.listdir(os.path.join(scratch, "tests", d))
                             ) and os.path.isdir(os.path.join(scratch, "tests", d))) if os.path.isdir(scratch) else []
    good, text = build(scratch, ["all"])
    if not good:
        raise SystemExit("mutants.py: the copy does not build\n" + text[-3000:])
    survived, broken = [], []
    for k, m in enumerate(mutants):
        begin = time.time()
        before, after = mutated(m, scratch)
        path = os.path.join(scratch, m["file"])
        with open(path, "w", encoding="utf-8") as f:
            f.write(after)
        first, pattern = m["test"][0], m["test"][1] if len(m["test"]) > 1 else "*"
        good, text = build(scratch, ["talus", first])
        if not good:
            broken.append(m["name"])
            verdict = "DOES NOT COMPILE\n" + text[-1500:]
        elif fails(scratch, first, pattern, 600):
            verdict = f"killed by {first} {pattern}"
        else:
            verdict = "SURVIVED"
            if not args.quick:
                build(scratch, ["all"])
                seen = next((q for q in programs if fails(scratch, q, "*", 1800)), None)
                if seen is not None:
                    verdict = f"killed by {seen}"
            if verdict == "SURVIVED":
                survived.append(m["name"])
        with open(path, "w", encoding="utf-8") as f:
            f.write(before)
        print(f"{k + 1:3}/{len(mutants)} {m['name']:<28} {verdict}  ({time.time() - begin:.0f} s)", flush=True)
    killed = len(mutants) - len(survived) - len(broken)
    print(f"{killed} of {len(mutants)} killed; survived: {', '.join(survived) or 'none'}; do not compile: {', '.join(broken) or 'none'}")
    return 0 if not broken and killed >= 0.95 * len(mutants) else 1


if __name__ == "__main__":
    sys.exit(main())
