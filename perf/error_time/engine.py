"""Runs Problems with Talus, LAMMPS and LIGGGHTS, keeps what came out, and measures run times.

Who calls it: error_time.py. Invariants: a result is filed under a hash of the input files, the command and the program, so
a second call does only what is missing and another build starts afresh; observed runs (frames, energies, audit) are never
timed, timed runs write nothing; every run uses one thread.
"""
import concurrent.futures
import csv
import dataclasses
import hashlib
import json
import os
import shlex
import shutil
import subprocess
import sys
import time

import numpy as np

import states

from . import clock, peers, problem

PREFIX_S = 0.8      # longer runs are timed over their first steps, as many as take about this long
BATCH_S = 40.0      # timed batches are at most this long: a wrapper may hold other work back


class Failure(Exception):
    pass


@dataclasses.dataclass
class Outcome:
    """What an observed run left. frames: {step: rows by id, x y z vx vy vz wx wy wz}, and the quaternion of bodies."""
    steps: int
    frames: dict
    hash: str = None
    energy: float = None            # largest |balance residual| / energy turned over
    missed: int = None
    audited: int = 0                # steps compared with brute force
    rebuilds: int = None
    wall: float = 0.0
    stopped: str = None             # the program refused or stopped: why

    @property
    def last(self):
        return self.frames[max(self.frames)]


class Engine:
    def __init__(self, folder, binaries, wrap, rounds, audit_s, jobs):
        self.folder, self.binaries, self.wrap, self.rounds, self.audit_s = folder, binaries, wrap, rounds, audit_s
        self.identity = {c: digest_file(p) for c, p in binaries.items() if p}
        self.work = os.path.join(folder, "work")
        self.cache = os.path.join(folder, "cache")
        os.makedirs(self.cache, exist_ok=True)
        self.jobs, self.ran = jobs, 0

    def prepare(self, code, p, observed, peer=None):
        """Input files of a run: (folder, command, key). The key names all that determines the result."""
        files = {}
        if code == "talus":
            files["scene.toml"] = problem.talus_scene(p, observed)
            data, write = "grains.csv", problem.write_csv
            command = [self.binaries[code], "run", "scene.toml", "--out", "run", "--overwrite", "--quiet", "--json",
                       "--threads", "1"]
            if "isa" in (peer or {}):
                command += ["--isa", peer["isa"]]
        else:
            files["deck"] = peers.deck(code, p, observed, peer["skin"], peer.get("every"))
            data, write = "grains.data", peers.write_data
            command = [self.binaries[code], "-in", "deck", "-log", "none"]
        key = hashlib.sha256()
        for part in (code, self.identity[code], repr(command[1:]), *files.values(), str(observed)):
            key.update(part.encode() + b"\0")
        key.update(p.grains.tobytes() + p.kind.tobytes())
        key = key.hexdigest()[:24]
        folder = os.path.join(self.work, key)
        if not os.path.isdir(folder):
            os.makedirs(folder + ".part", exist_ok=True)
            for name, text in files.items():
                with open(os.path.join(folder + ".part", name), "w") as f:
                    f.write(text)
            write(os.path.join(folder + ".part", data), p)
            os.replace(folder + ".part", folder)
        return folder, command, key

    def at_once(self, work, items):
        """[work(item)], several at a time: for runs that are not timed."""
        with concurrent.futures.ThreadPoolExecutor(self.jobs) as pool:
            return list(pool.map(work, items))

    def observe(self, code, p, peer=None, may_stop=False, audited=True):
        """Outcome of a run with frames, energies and the audit, from the cache if it is there."""
        folder, command, key = self.prepare(code, p, True, peer)
        audit = 0
        if code == "talus" and audited and self.audit_s > 0:
            audit = min(p.steps, max(20, int(self.audit_s / (3e-9 * len(p.grains) ** 2 + 1e-6))))
        path = os.path.join(self.cache, f"{key}-{audit}.npz")
        if not os.path.exists(path):
            self.ran += 1
            outcome = self.observed(code, p, folder, command, audit, may_stop, "every" in (peer or {}))
            facts = {k: v for k, v in dataclasses.asdict(outcome).items() if k != "frames"}
            with open(path + ".part", "wb") as f:
                np.savez(f, facts=json.dumps(facts), **{str(s): x for s, x in outcome.frames.items()})
            os.replace(path + ".part", path)
        shutil.rmtree(folder, ignore_errors=True)
        with np.load(path) as z:
            facts = json.loads(str(z["facts"]))
            return Outcome(frames={int(k): z[k] for k in z.files if k != "facts"}, **facts)

    def observed(self, code, p, folder, command, audit, may_stop, unchecked):
        whole = audit == p.steps
        done = execute(command + (["--audit"] if whole and audit else []), folder)
        if code != "talus":
            if done.returncode:
                if may_stop:
                    return Outcome(p.steps, {}, stopped=tail(done.stdout, 1))
                raise failed(command, folder, done)
            outcome = Outcome(p.steps, peers.read_dump(os.path.join(folder, "dump.txt"), len(p.grains)),
                              wall=clock.seconds_of(code, done.stdout)[0])
            if unchecked:
                outcome.missed, outcome.audited = peers.missed_contacts(folder, outcome.frames, p), p.frames
            return outcome
        if done.returncode:
            if may_stop and done.returncode in (3, 4):
                reason = [line for line in done.stdout.splitlines() if "error" in line]
                return Outcome(p.steps, {}, stopped=(reason or ["stopped"])[0])
            raise failed(command, folder, done)
        summary = json.loads(done.stdout[done.stdout.index("{"):])
        outcome = Outcome(p.steps, talus_frames(os.path.join(folder, "run"), len(p.grains)), hash=summary["state_hash"],
                          energy=energy_residual(os.path.join(folder, "run", "series.csv")),
                          rebuilds=summary["rebuilds"], wall=summary["wall_s"], audited=audit)
        if whole and audit:
            outcome.missed = summary["missed_contacts"]
        elif audit:
            checked = execute(command + ["--audit", "--steps", str(audit)], folder)
            if checked.returncode:
                raise failed(command, folder, checked)
            outcome.missed = json.loads(checked.stdout[checked.stdout.index("{"):])["missed_contacts"]
        return outcome

    def time(self, runs, progress):
        """[(median s, lowest, highest, steps timed, state_hash of a whole run or None)] for [(code, problem, peer, Outcome)].

        All runs of a batch are interleaved, `rounds` times; kept from an earlier call where nothing has changed."""
        plans = []
        for code, p, peer, outcome in runs:
            steps = p.steps
            if outcome.wall > PREFIX_S:
                steps = min(steps, max(100, int(p.steps * PREFIX_S / outcome.wall)))
            folder, command, key = self.prepare(code, p.with_steps(steps), False, peer)
            plans.append([code, folder, command, os.path.join(self.cache, f"{key}-time{self.rounds}.json"), steps,
                          min(outcome.wall, PREFIX_S) + 0.1])
        batches, length = [[]], 0.0
        for plan in plans:
            if os.path.exists(plan[3]):
                continue
            if length + plan[5] * self.rounds > BATCH_S:
                batches.append([])
                length = 0.0
            batches[-1].append(plan)
            length += plan[5] * self.rounds
        for batch in filter(None, batches):
            self.run_batch(batch)
            progress(len(batch))
        out = []
        for code, folder, _, path, steps, _ in plans:
            shutil.rmtree(folder, ignore_errors=True)
            with open(path) as f:
                kept = json.load(f)
            s = np.array(kept["seconds"])
            out.append((float(np.median(s)), float(s.min()), float(s.max()), steps, kept["hash"], kept["load"]))
        return out

    def run_batch(self, batch):
        jobs = [{"code": code, "command": command, "cwd": folder} for code, folder, command, *_ in batch]
        path = os.path.join(self.work, "jobs.json")
        with open(path, "w") as f:
            json.dump({"rounds": self.rounds, "jobs": jobs}, f)
        command = shlex.split(self.wrap) + [sys.executable, os.path.abspath(clock.__file__), path]
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
        if done.returncode:
            raise Failure(f"timing failed: {done.stderr[-2000:]}")
        result = json.loads(done.stdout[done.stdout.index("{"):])
        for i, plan in enumerate(batch):
            with open(plan[3], "w") as f:
                json.dump({"seconds": result["seconds"][i], "hash": result["hash"][i], "load": result["load"]}, f)

    def kept_state(self, name, parts, make):
        """An array made by make() once and filed under name and parts (anything with a repr)."""
        key = hashlib.sha256(repr((name, parts, self.identity["talus"])).encode()).hexdigest()[:24]
        path = os.path.join(self.cache, f"state-{name}-{key}.npy")
        if not os.path.exists(path):
            np.save(path + ".part.npy", make())
            os.replace(path + ".part.npy", path)
        return np.load(path)


def execute(command, folder):
    return subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False,
                          env=dict(os.environ, OMP_NUM_THREADS="1"))


def tail(text, lines):
    return "\n".join(text.strip().splitlines()[-lines:])


def failed(command, folder, done):
    return Failure(f"{' '.join(command)}\nin {folder}: exit code {done.returncode}\n{tail(done.stdout, 12)}")


def digest_file(path):
    key = hashlib.sha256()
    with open(path, "rb") as f:
        for block in iter(lambda: f.read(1 << 20), b""):
            key.update(block)
    return key.hexdigest()


def talus_frames(folder, count):
    frames, names = {}, sorted(os.listdir(os.path.join(folder, "vtp")))
    for name in (n for n in names if n.startswith("bodies-")):
        c = states.read_vtp(os.path.join(folder, "vtp", name))
        rows = np.hstack([c["Points"], c["velocity"], c["angular_velocity"], c["orientation"]])
        frames[int(name[len("bodies-"):-len(".vtp")])] = rows[np.argsort(c["id"])]
    if frames:
        return frames
    for name in names:
        if name.startswith("particles-"):
            c = states.read_vtp(os.path.join(folder, "vtp", name))
            out = np.full((count, 9), np.nan)
            out[c["id"]] = np.hstack([c["Points"], c["velocity"], c["omega"] if "omega" in c else np.zeros((len(c["id"]), 3))])
            frames[int(name[len("particles-"):-len(".vtp")])] = out
    return frames


def energy_residual(path):
    """Largest |balance residual| over the energy there is or has been turned over (kinetic, dissipated, work of walls)."""
    with open(path, newline="") as f:
        table = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(f)]
    # a scene without friction, walls or drag has no such column
    kinetic = max(row["kinetic_translation"] + row.get("kinetic_rotation", 0.0) for row in table)
    last = table[-1]
    lost = sum(v for k, v in last.items() if k.startswith("dissipated_"))
    scale = max(kinetic, abs(lost), abs(last.get("wall_work", 0.0)))
    return max(abs(row["balance_residual"]) for row in table) / scale if scale > 0 else None


class Progress:
    """Lines on stderr with the share done and the time left."""

    def __init__(self, total):
        self.total, self.done, self.started = max(total, 1), 0, time.time()

    def step(self, text, count=1):
        self.done += count
        spent = time.time() - self.started
        left = f", {spent / self.done * max(self.total - self.done, 0):4.0f} s left" if self.done else ""
        print(f"[{100 * min(self.done / self.total, 1):3.0f} %{left}] {text}", file=sys.stderr, flush=True)
