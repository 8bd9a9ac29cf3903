#!/usr/bin/env python3
"""Do the tests bite? Breaks the code on purpose, one line at a time, and tells which faults the tests see.

  python3 tests/mutants.py                  # all faults of tests/mutants.txt, about an hour on two cores
  python3 tests/mutants.py --only skin,mesh # those whose name contains one of these words
  python3 tests/mutants.py --list           # does every fault still fit its file? builds nothing

Works in a copy of the checkout outside of it (--scratch, kept so that the next call builds little), with cheap compiler
flags. For each fault: the program is built, the tests run that should see it, and, where these pass, all others up to
the first failure (--quick: not, and only the programs of these tests are built). A fault whose line is not there exactly
once, or that does not compile, is an error of the table and no kill. Prints a line per fault and the totals; exit 1
where fewer than 95 % are killed or the table has errors. Faults of kernels: "--cmake=-DTALUS_ISAS=scalar;avx512" builds two
instruction sets, not four.
"""
import argparse
import hashlib
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
TABLE = os.path.join(ROOT, "tests", "mutants.txt")
SHARE = 0.95
BUILD_LIMIT, FILTER_LIMIT, SUITE_LIMIT = 3600, 600, 3600  # [s]; a test that hangs sees the fault, too
# Inlining keeps the hand-written vector code fast enough for the tests, the rest of -O3 costs only compile time.
FLAGS = "-O1 -finline-functions -g0"


class Mutant:
    def __init__(self, block):
        lines = block.splitlines()
        self.name, self.file, tests = (part.strip() for part in lines[0].split("|"))
        self.tests = [test.split() for test in tests.split(";")]
        self.old = "\n".join(line[1:] for line in lines[1:] if line.startswith("-"))
        self.new = "\n".join(line[1:] for line in lines[1:] if line.startswith("+"))

    def apply(self, root):
        """Text of the file without and with the fault; None where its line is not there exactly once."""
        with open(os.path.join(root, self.file), encoding="utf-8") as f:
            text = f.read()
        return (text, text.replace(self.old, self.new)) if self.old and text.count(self.old) == 1 else None


def read_table(path):
    with open(path, encoding="utf-8") as f:
        text = "\n".join(line for line in f.read().splitlines() if not line.startswith("#"))
    return [Mutant(block) for block in re.split(r"\n{2,}", text.strip("\n"))]


def copy(scratch):
    """The files of the checkout as they are now; those that are equal keep their times, so that little is built. Returns
    a hash over them."""
    listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True)
    files = {name for name in listed.stdout.splitlines() if os.path.isfile(os.path.join(ROOT, name))}
    total = hashlib.sha256()
    for name in sorted(files):
        to = os.path.join(scratch, name)
        with open(os.path.join(ROOT, name), "rb") as f:
            new = f.read()
        if not name.startswith("tests/mutants."):
            total.update(name.encode() + hashlib.sha256(new).digest())
        if os.path.exists(to):
            with open(to, "rb") as f:
                if f.read() == new:
                    continue
        os.makedirs(os.path.dirname(to), exist_ok=True)
        with open(to, "wb") as f:
            f.write(new)
        shutil.copymode(os.path.join(ROOT, name), to)
    for folder, folders, names in os.walk(scratch):
        folders[:] = [d for d in folders if os.path.join(folder, d) != os.path.join(scratch, "build")]
        for name in names:
            path = os.path.join(folder, name)
            if os.path.relpath(path, scratch) not in files:
                os.remove(path)
    return total.hexdigest()


class Scratch:
    """The copy, its build and its tests."""

    def __init__(self, folder, jobs, wait, options):
        self.folder, self.jobs, self.wait, self.options = folder, str(jobs), wait, options

    def run(self, command, limit):
        """Exit code and output; None where it takes longer than the limit [s]."""
        while self.wait and os.path.exists(self.wait):
            time.sleep(1)
        process = subprocess.Popen(command, cwd=self.folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                   text=True, errors="replace", start_new_session=True)
        try:
            out, _ = process.communicate(timeout=limit)
            return process.returncode, out
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, 9)
            process.communicate()
            return None, "took too long"

    def build(self, targets):
        """Empty, or what the compiler says."""
        code, out = self.run(["cmake", "--build", "build", "-j", self.jobs, "--target", *targets], BUILD_LIMIT)
        return "" if code == 0 else out

    def prepare(self, targets):
        os.makedirs(self.folder, exist_ok=True)
        self.state = copy(self.folder)
        if not os.path.exists(os.path.join(self.folder, "build", "build.ninja")):
            launcher = ["-DCMAKE_CXX_COMPILER_LAUNCHER=ccache"] if shutil.which("ccache") else []
            code, out = self.run(["cmake", "-S", ".", "-B", "build", "-G", "Ninja", "-DTALUS_PERF=OFF", "-DCMAKE_BUILD_TYPE=Cheap",
                                  f"-DCMAKE_CXX_FLAGS_CHEAP={FLAGS}", *launcher, *self.options], 600)
            if code != 0:
                raise SystemExit("mutants.py: cmake failed\n" + out)
        said = self.build(targets)
        if said:
            raise SystemExit("mutants.py: the copy does not build\n" + said[-3000:])

    def count(self, test):
        """Number of tests that fit (program, filter)."""
        code, out = self.run([os.path.join("build", "tests", test[0]), f"--gtest_filter={test[1]}", "--gtest_list_tests"], FILTER_LIMIT)
        return out.count("\n  ") if code == 0 else 0

    def sees(self, test):
        """Whether the tests of (program, filter) see the fault: a failure, a crash or a hang."""
        code, _ = self.run([os.path.join("build", "tests", test[0]), f"--gtest_filter={test[1]}", "--gtest_brief=1", "--gtest_fail_fast"],
                           FILTER_LIMIT)
        return code != 0

    def suite(self):
        """Name of the first test of the whole suite that fails; empty if all pass."""
        code, out = self.run(["ctest", "--test-dir", "build", "-j", self.jobs, "--timeout", "600", "--stop-on-failure", "--output-on-failure"],
                             SUITE_LIMIT)
        if code == 0:
            return ""
        failed = re.search(r"Test\s+#\d+: (\S+) .*(?:Failed|Exception|Timeout)", out)
        return failed.group(1) if failed else "the suite"


def judge(scratch, mutant, quick):
    """"killed", "SURVIVED" or "ERROR", and by or of what."""
    texts = mutant.apply(scratch.folder)
    if texts is None:
        return "ERROR", "its line is not there exactly once"
    path = os.path.join(scratch.folder, mutant.file)
    try:
        with open(path, "w", encoding="utf-8") as f:
            f.write(texts[1])
        for test in mutant.tests:
            said = scratch.build(["talus", test[0]])
            if said:
                return "ERROR", "does not compile: " + said[-1500:]
            if scratch.sees(test):
                return "killed", "by " + " ".join(test)
        if quick:
            return "SURVIVED", "the tests named"
        scratch.build(["all"])
        first = scratch.suite()
        return ("killed", "by " + first) if first else ("SURVIVED", "all tests")
    finally:
        with open(path, "w", encoding="utf-8") as f:
            f.write(texts[0])


def check_sane(scratch, mutants, whole_suite):
    """Tests that fail without a fault would kill everything. What has passed on the same files is remembered."""
    tests = sorted({tuple(test) for m in mutants for test in m.tests})
    for test in tests:
        if scratch.count(test) == 0:
            raise SystemExit("mutants.py: no test fits " + " ".join(test))
    path = os.path.join(scratch.folder, "build", "sane.txt")
    known = open(path, encoding="utf-8").read().splitlines() if os.path.exists(path) else []
    for what in [" ".join(test) for test in tests] + (["all"] if whole_suite else []):
        if f"{scratch.state} {what}" in known:
            continue
        if scratch.suite() if what == "all" else scratch.sees(what.split()):
            raise SystemExit("mutants.py: fails without any fault: " + what)
        with open(path, "a", encoding="utf-8") as f:
            f.write(f"{scratch.state} {what}\n")


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    where = os.path.join(tempfile.gettempdir(), "talus-mutants-" + hashlib.sha256(ROOT.encode()).hexdigest()[:8])
    p.add_argument("--scratch", default=where, help=f"folder of the copy ({where})")
    p.add_argument("--only", default="", help="words, separated by commas, of the names of the faults")
    p.add_argument("--list", action="store_true", help="only check that the faults fit their files")
    p.add_argument("--quick", action="store_true", help="only the tests that should see a fault")
    p.add_argument("--sane", action="store_true", help="first run the whole suite without a fault, not only the tests named")
    p.add_argument("--jobs", type=int, default=len(os.sched_getaffinity(0)))
    p.add_argument("--wait-while", default="", metavar="FILE", help="start nothing while this file exists")
    p.add_argument("--cmake", default="", metavar="OPTIONS", help="further options for the first configuration of the copy")
    args = p.parse_args()
    words = [w for w in args.only.split(",") if w]
    mutants = [m for m in read_table(TABLE) if not words or any(w in m.name for w in words)]
    if args.list:
        bad = [m for m in mutants if m.apply(ROOT) is None]
        for m in bad:
            print(f"{m.name}: its line is not there exactly once in {m.file}")
        print(f"{len(mutants)} faults, {len(bad)} that do not fit")
        return 1 if bad else 0
    folder = os.path.realpath(args.scratch)
    if os.path.commonpath([folder, ROOT]) == ROOT:
        p.error("--scratch must lie outside of the checkout")
    scratch = Scratch(folder, args.jobs, args.wait_while, args.cmake.split())
    # whoever runs a few faults only does not wait for programs that see none of them
    scratch.prepare(sorted({"talus", *(test[0] for m in mutants for test in m.tests)}) if args.quick and not args.sane else ["all"])
    check_sane(scratch, mutants, args.sane)
    verdicts = []
    for k, m in enumerate(mutants):
        begin = time.time()
        verdict, what = judge(scratch, m, args.quick)
        verdicts.append(verdict)
        print(f"{k + 1:3}/{len(mutants)} {m.name:<52} {verdict:<8} {what}  ({time.time() - begin:.0f} s)", flush=True)
    killed, errors = verdicts.count("killed"), verdicts.count("ERROR")
    survived = [m.name for m, v in zip(mutants, verdicts) if v == "SURVIVED"]
    print(f"{killed} of {len(mutants)} killed, {len(survived)} survived ({'; '.join(survived) or 'none'}), {errors} errors of the table")
    return 0 if errors == 0 and killed >= SHARE * len(mutants) else 1


if __name__ == "__main__":
    sys.exit(main())
