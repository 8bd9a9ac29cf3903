#!/usr/bin/env python3
"""Kills runs at random moments and fills their disks; checks that nothing is lost but time.

    python3 tests/kills.py --kills 200 --sizes 20 --build build    (about ten minutes)

Every trial runs one small scene with all kinds of output. A kill (SIGKILL, often twice) is followed by a look at every
file, a resume, and a comparison with the undisturbed run: state hash, checkpoint, series and frames. A full disk is a tmpfs of
that size (needs root; else a limit on the size of a file): exit code 5 with one error line, readable files, and the
same result once there is room. Prints its figures as it goes; the exit code is 1 if anything was wrong.
"""
import argparse
import csv
import filecmp
import json
import os
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time

import h5py

STEPS, EVERY = 600, "41"
SCENE = """title = "kills"
seed = 5
gravity = [0, 0, -9.81]
sort_every = 70
[domain]
lower = [0, 0, 0]
upper = [0.08, 0.08, 0.16]
boundary = ["periodic", "periodic", "wall"]
[time]
step = 2e-5
steps = %d
[[material]]
name = "glass"
density = 2500
[contact]
friction = 0.5
restitution = 0.8
normal_stiffness = 2e4
[[source]]
kind = "stream"
number_rate = 5000
interval = 1e-3
region = { lower = [0.005, 0.005, 0.1], upper = [0.075, 0.075, 0.15] }
size = { kind = "uniform", min = 0.006, max = 0.009 }
velocity = [0, 0, -1]
[[wall]]
name = "lid"
shape = "box"
lower = [0.02, 0.02, 0.02]
upper = [0.04, 0.04, 0.04]
[wall.motion]
velocity = [0.1, 0, 0]
[output]
particles_every = 4e-4
csv_every = 1e-4
vtp = true
vtkhdf = true
contacts = true
energies = true
""" % STEPS
SCRATCH = re.compile(r"^\.talus-[0-9a-f]{16}$")


class Wrong(Exception):
    pass


class Trials:
    def __init__(self, talus, work):
        self.talus, self.work = talus, work
        self.scene = os.path.join(work, "scene.toml")
        with open(self.scene, "w", encoding="utf-8") as f:
            f.write(SCENE)
        self.whole = os.path.join(work, "whole")
        begin = time.monotonic()
        done = self.run(["--out", self.whole])
        self.seconds = time.monotonic() - begin
        if done.returncode != 0:
            raise Wrong(f"the undisturbed run failed: {done.stderr}")
        self.read_all(self.whole)
        self.bytes = sum(os.path.getsize(os.path.join(at, f)) for at, _, names in os.walk(self.whole) for f in names)

    def command(self, words):
        return [self.talus, "run", self.scene, "--quiet", "--threads", "1", "--checkpoint-every", EVERY, *words]

    def run(self, words, limit=None):
        before = (lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))) if limit else None
        return subprocess.run(self.command(words), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False,
                              preexec_fn=before)

    def killed(self, words, after):
        """True if the run was still going on."""
        with subprocess.Popen(self.command(words), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as run:
            time.sleep(after)
            run.send_signal(signal.SIGKILL)
            return run.wait() == -signal.SIGKILL

    # ---- every file of a folder ----
    def read_all(self, folder):
        for at, _, names in os.walk(folder):
            for name in names:
                path = os.path.join(at, name)
                try:
                    self.read_one(folder, path, name)
                except Wrong:
                    raise
                except Exception as error:  # whatever a reader says: the file cannot be read
                    raise Wrong(f"{path}: {error!r}") from error

    def read_one(self, folder, path, name):
        if SCRATCH.match(name):
            return  # what a kill left half written, under the mark that says so
        if name.endswith(".vtkhdf"):
            self.frames(path)
        elif name.endswith(".csv"):
            with open(path, encoding="utf-8") as f:
                text = f.read()
            rows = list(csv.reader(text[: text.rindex("\n") + 1].splitlines()))  # a kill may tear the last row
            if any(len(r) != len(rows[0]) for r in rows):
                raise Wrong(f"{path}: rows of different lengths")
        elif name.endswith(".json"):
            with open(path, encoding="utf-8") as f:
                json.load(f)
        elif name.endswith(".pvd"):
            with open(path, encoding="utf-8") as f:
                for frame in re.findall(r'file="([^"]*)"', f.read()):
                    if os.path.getsize(os.path.join(folder, frame)) == 0:
                        raise Wrong(f"{path}: {frame} is empty")
        elif name.endswith(".vtp"):
            with open(path, "rb") as f:
                if not f.read().endswith(b"</VTKFile>\n"):
                    raise Wrong(f"{path}: not whole")
        elif name.endswith(".tcp"):
            done = subprocess.run([self.talus, "info", path], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
            if done.returncode != 0:
                raise Wrong(f"{path}: {done.stderr.strip()}")
        elif name == "scene.toml" and os.path.getsize(path) < len(SCENE):
            raise Wrong(f"{path}: not whole")

    @staticmethod
    def frames(path):
        """All values of all frames that count."""
        with h5py.File(path, "r") as f:
            root, steps = f["VTKHDF"], f["VTKHDF/Steps"]
            n = int(steps.attrs["NSteps"])
            counts = root["NumberOfPoints"][:n]
            values = [f["talus/step"][:n].tobytes(), steps["Values"][:n].tobytes(), counts.tobytes()]
            for k in range(n):
                start = int(steps["PointOffsets"][k])
                points = root["Points"][start : start + int(counts[k])]
                if len(points) != counts[k]:
                    raise Wrong(f"{path}: frame {k} is not whole")
                values.append(points.tobytes())
                for name, column in root["PointData"].items():
                    at = int(steps["PointDataOffsets"][name][k])
                    rows = column[at : at + int(counts[k])]
                    if len(rows) != counts[k]:
                        raise Wrong(f"{path}: column {name} of frame {k} is not whole")
                    values.append(rows.tobytes())
            return values

    # ---- the end of a trial ----
    def finish(self, folder):
        """Resumes, or begins anew where there is no checkpoint yet, and compares with the undisturbed run."""
        has = os.path.isdir(folder) and any(n.endswith(".tcp") for n in os.listdir(folder))
        words = ["--resume", folder] if has else ["--out", folder, "--overwrite"]
        done = self.run(words)
        if done.returncode != 0:
            raise Wrong(f"{' '.join(words)}: exit code {done.returncode}: {done.stderr.strip()}")
        self.read_all(folder)
        for name in ("series.csv", f"checkpoint-{STEPS}.tcp", "particles.pvd"):
            with open(os.path.join(folder, name), "rb") as a, open(os.path.join(self.whole, name), "rb") as b:
                if a.read() != b.read():
                    raise Wrong(f"{folder}/{name} is not that of the undisturbed run")
        frames = [n for n in os.listdir(self.whole) if n.endswith(".vtp")]
        same, other, lost = filecmp.cmpfiles(folder, self.whole, frames, shallow=False)
        if other or lost:
            raise Wrong(f"{folder}: {len(other)} .vtp files differ from the undisturbed run and {len(lost)} are missing")
        for name in ("particles.vtkhdf", "walls.vtkhdf", "contacts.vtkhdf"):
            if self.frames(os.path.join(folder, name)) != self.frames(os.path.join(self.whole, name)):
                raise Wrong(f"{folder}/{name} is not that of the undisturbed run")
        if any(SCRATCH.match(n) for n in os.listdir(folder)):
            raise Wrong(f"{folder}: scratch files are left")
        return "resumed" if has else "begun anew"

    def kill(self, chance):
        folder = os.path.join(self.work, "killed")
        shutil.rmtree(folder, ignore_errors=True)
        hits = int(self.killed(["--out", folder], chance.uniform(0, 1.05 * self.seconds)))
        if os.path.isdir(folder):
            self.read_all(folder)
            if chance.random() < 0.5 and any(n.endswith(".tcp") for n in os.listdir(folder)):
                hits += self.killed(["--resume", folder], chance.uniform(0, 0.8 * self.seconds))
                self.read_all(folder)
        how = self.finish(folder)
        litter = [n for n in os.listdir(self.work) if SCRATCH.match(n)]  # a folder killed before it had its name
        for name in litter:
            shutil.rmtree(os.path.join(self.work, name))
        return hits, how

    def full(self, size, mount):
        """A disk of `size` bytes, or files of at most that size."""
        at = os.path.join(self.work, "disk")
        os.makedirs(at, exist_ok=True)
        folder = os.path.join(at, "out")
        if mount and not mounted(at, size):
            raise Wrong("the tmpfs cannot be mounted again")
        try:
            done = self.run(["--out", folder], None if mount else size)
            lines = [line for line in done.stderr.splitlines() if "error" in line]
            if done.returncode not in (0, 5) or len(lines) != (done.returncode == 5):
                raise Wrong(f"disk of {size} bytes: exit code {done.returncode}, {done.stderr.strip()}")
            if os.path.isdir(folder):
                self.read_all(folder)
            if mount:
                subprocess.run(["mount", "-o", f"remount,size={4 * self.bytes}", at], check=True)
            return done.returncode == 5, self.finish(folder)
        finally:
            if mount:
                subprocess.run(["umount", at], check=True)
            shutil.rmtree(at)


def mounted(at, size):
    return subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", at], stderr=subprocess.DEVNULL, check=False).returncode == 0


def can_mount(work):
    at = os.path.join(work, "probe")
    os.makedirs(at)
    if not mounted(at, 1 << 20):
        return False
    subprocess.run(["umount", at], check=True)
    return True


class Tally:
    """Counts of one kind of trial; prints a line per ten trials, and every trial that went wrong."""

    def __init__(self, what, trials):
        self.what, self.trials = what, trials
        self.done = self.hits = self.wrong = 0
        self.how = {"resumed": 0, "begun anew": 0}

    def add(self, trial, name):
        try:
            hits, how = trial()
            self.hits += hits
            self.how[how] += 1
        except Wrong as error:
            self.wrong += 1
            print(f"WRONG {name}: {error}", flush=True)
        self.done += 1
        if self.done % 10 == 0 or self.done == self.trials:
            print(f"{self.done} of {self.trials} {self.what}: {self.hits}; {self.how['resumed']} resumed, "
                  f"{self.how['begun anew']} begun anew (no checkpoint yet); {self.wrong} wrong", flush=True)


def many_kills(trials, number, chance):
    tally = Tally("runs, kills while running", number)
    for k in range(number):
        tally.add(lambda: trials.kill(chance), f"kill {k}")
    return tally.wrong


def many_sizes(trials, number, chance):
    mount = can_mount(trials.work)
    largest = 1.2 * trials.bytes if mount else 1.2 * os.path.getsize(os.path.join(trials.whole, "particles.vtkhdf"))
    kind = "disks (tmpfs)" if mount else "limits on a file (no tmpfs may be mounted)"
    tally = Tally(f"{kind} up to {largest / 1e6:.1f} MB, full before the end", number)
    for k in range(number):
        size = int(8192 + (largest - 8192) * (k + chance.random()) / number)
        tally.add(lambda size=size: trials.full(size, mount), f"size {size}")
    return tally.wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--kills", type=int, default=200)
    parser.add_argument("--sizes", type=int, default=20, help="of full disks")
    parser.add_argument("--build", default="build")
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    chance = random.Random(args.seed)
    # A kill loses nothing that was written: in memory the same moments come without waiting for a disk.
    memory = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None
    with tempfile.TemporaryDirectory(prefix="talus_kills_", dir=memory) as work:
        trials = Trials(os.path.abspath(os.path.join(args.build, "talus")), work)
        print(f"undisturbed: {trials.seconds:.2f} s, {trials.bytes / 1e6:.1f} MB", flush=True)
        wrong = many_kills(trials, args.kills, chance) + many_sizes(trials, args.sizes, chance)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
