"""Runs the study: prepared states, timed runs in random order, a journal to resume from. Called by perf/study.py.

Every finished run is one line of OUT/runs.jsonl under a key that names everything that determines it (scene text,
generated files, binary, state, setting, steps, threads, repeat); a second call only does what is missing.
"""
import glob
import hashlib
import json
import os
import random
import shlex
import subprocess
import sys
import time

from . import findings, plan

PHYSICS = 4     # exit code of a run that its physics stopped
AUDITED = 2_000_000  # grain-steps of the run that counts missed contacts, at least 20 steps, each a sweep over all grains
QUIET = ["output.particles_every=0", "output.csv_every=0", "output.energies=false"]


class Failed(Exception):
    pass


def digest(*parts):
    h = hashlib.sha256()
    for p in parts:
        h.update(p if isinstance(p, bytes) else str(p).encode())
        h.update(b"\0")
    return h.hexdigest()[:16]


def contents(path):
    with open(path, "rb") as f:
        return f.read()


class Study:
    def __init__(self, args, cases, points):
        self.args, self.cases, self.points = args, cases, points
        self.journal = os.path.join(args.out, "runs.jsonl")
        self.binary = digest(contents(args.talus))
        os.makedirs(args.out, exist_ok=True)
        self.runs = {}
        if os.path.exists(self.journal):
            with open(self.journal, encoding="utf-8") as f:
                for line in f:
                    try:
                        row = json.loads(line)
                    except ValueError:
                        continue  # the last line of a killed call
                    self.runs[row["key"]] = row
        self.begin = time.monotonic()
        self.wanted, self.failures = [], []
        self.took = {}  # (case, point) -> seconds of the last run including start-up

    # ---- states ----
    def scene(self, case):
        return os.path.join(plan.ROOT, "cases", case.scene)

    def overrides(self, case):
        return QUIET + self.args.set + [s.split(":", 1)[1] for s in self.args.case_set if s.split(":", 1)[0] == case.name]

    def prepare(self, case):
        """Checkpoint of the common state; made once."""
        scene = self.scene(case)
        generated = sorted(glob.glob(os.path.join(os.path.dirname(scene), "generated", "*")))
        if case.make:
            script = os.path.join(plan.ROOT, "cases", case.make)
            if not any(case.make_args[-1] in os.path.basename(g) for g in generated):
                self.check([sys.executable, script, *case.make_args])
                generated = sorted(glob.glob(os.path.join(os.path.dirname(scene), "generated", "*")))
        used = [g for g in generated if case.make and case.make_args[-1] in os.path.basename(g)]
        steps = self.args.prepare_steps
        if steps is None:
            text = contents(scene).decode()
            dt = next(float(line.split("=")[1]) for line in text.splitlines() if line.replace(" ", "").startswith("step="))
            steps = int(round(case.prepared / dt))
        # not the binary: any build may go on from a state (or says that it cannot), and all points share this one
        key = digest(contents(scene), *[contents(g) for g in used], *self.overrides(case), steps)
        folder = os.path.join(self.args.out, "states", f"{case.name}-{key}")
        checkpoint = os.path.join(folder, f"checkpoint-{steps}.tcp")
        if not os.path.exists(checkpoint):
            say(f"{case.name}: preparing the state ({steps} steps)")
            threads = str(self.args.prepare_threads)
            self.check([self.args.talus, "run", scene, "--out", folder, "--overwrite", "--quiet", "--threads", threads, "--steps",
                        str(steps), *sets(self.overrides(case))])
        return key, steps, checkpoint

    @staticmethod
    def check(command):
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        if done.returncode:
            raise Failed(f"{shlex.join(command)}: exit code {done.returncode}\n{done.stdout[-2000:]}")
        return done.stdout

    # ---- runs ----
    def tasks(self):
        """(case, point, repeat, key, ...) of everything; each repeat in its own random order."""
        out = []
        for case in self.cases:
            state, first, checkpoint = self.prepare(case)
            for repeat in range(self.args.repeats):
                order = list(self.points)
                random.Random(f"{case.name} {repeat} {self.args.seed}").shuffle(order)
                for point in order:
                    key = digest(state, self.binary, point.name, *point.sets, self.args.steps or case.steps, self.args.warm,
                                 self.args.threads, repeat, self.args.isa or "")
                    out.append((case, point, repeat, key, first, checkpoint))
        return out

    def plan_only(self):
        self.wanted = [t[3] for t in self.tasks()]

    def run_all(self):
        """True when nothing is left to do, False when the budget is spent."""
        tasks = self.tasks()
        self.wanted = [t[3] for t in tasks]
        for row in self.runs.values():
            self.took[row["case"], row["point"]] = row["elapsed_s"]
        todo = [t for t in tasks if t[3] not in self.runs]
        done_before = len(tasks) - len(todo)
        for i, (case, point, repeat, key, first, checkpoint) in enumerate(todo):
            left = sum(self.guess(c.name, p.name) for c, p, *_ in todo[i:])
            expected = self.guess(case.name, point.name)
            spent = time.monotonic() - self.begin
            if self.args.budget and spent + 1.2 * expected > self.args.budget:
                say(f"budget of {self.args.budget:g} s spent, {len(todo) - i} runs are left (about {left:.0f} s): call again")
                return False
            say(f"[{done_before + i + 1}/{len(tasks)}, {left:.0f} s left] {case.name}: {point.name}, repeat {repeat + 1}")
            row = self.one(case, point, repeat, key, first, checkpoint)
            if row is None:
                self.wanted.remove(key)  # an inexact list let the run fail: a result, told on the page, without a time
            else:
                self.record(row)
        return True

    def guess(self, case, point):
        exact = self.took.get((case, point))
        if exact is not None:
            return exact
        alike = [v for (c, _), v in self.took.items() if c == case] or list(self.took.values())
        return sum(alike) / len(alike) if alike else 5.0

    def one(self, case, point, repeat, key, first, checkpoint):
        steps = self.args.steps or case.steps
        command = shlex.split(self.args.prefix or os.environ.get("TALUS_RUN_PREFIX", ""))
        command += [self.args.talus, "run", self.scene(case), "--resume", checkpoint, "--out", os.path.join(self.args.out, "run"),
                    "--overwrite", "--quiet", "--json", "--threads", str(self.args.threads), "--warm", str(self.args.warm), "--steps",
                    str(first + self.args.warm + steps), *sets(self.overrides(case) + list(point.sets))]
        if self.args.isa:
            command += ["--isa", self.args.isa]
        begin = time.monotonic()
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
        elapsed = time.monotonic() - begin
        if done.returncode == PHYSICS and point.series in findings.INEXACT:
            last = next((line for line in done.stderr.splitlines() if "error:" in line), "")
            self.failures.append(f"{case.name}, {point.name}: {last}")
            say(self.failures[-1])
            return None
        if done.returncode:
            raise Failed(f"{shlex.join(command)}: exit code {done.returncode}\n{done.stderr[-2000:]}")
        s = json.loads(done.stdout[done.stdout.index("{"):])
        self.took[case.name, point.name] = elapsed
        nodes = {n["name"]: n["seconds"] for n in s["nodes"]}
        calls = {n["name"]: n["calls"] for n in s["nodes"]}
        # once per point: every repeat misses the same ones
        audited = min(300, max(20, AUDITED // max(1, s["particles"])))
        missed = None
        if point.series in findings.INEXACT and repeat == 0 and not self.args.no_audit:
            missed = self.missed(case, point, first, checkpoint, audited)
        return {"key": key, "case": case.name, "missed_contacts": missed, "audited_steps": audited, "point": point.name, "series": point.series, "value": point.value, "repeat": repeat,
                "steps": steps, "wall_s": s["wall_s"], "nodes": nodes, "rebuilds": calls.get("rebuild", 0), "elapsed_s": elapsed,
                "sort_epochs": calls.get("sort_epoch", 0), "candidates": s["candidate_pairs"], "contacts": s["contacts"],
                "particles": s["particles"], "state_hash": s["state_hash"], "shortest_interval": s["shortest_interval"],
                "threads": s["threads"], "isa": s["isa"], "version": s["version"], "load": os.getloadavg()[0]}

    def missed(self, case, point, first, checkpoint, steps):
        """Contacts that an inexact policy misses in `steps` steps, counted by an untimed run that checks every step."""
        say(f"{case.name}: {point.name}, counting missed contacts in {steps} steps")
        out = self.output([self.args.talus, "run", self.scene(case), "--resume", checkpoint, "--out", os.path.join(self.args.out, "audit"),
                          "--overwrite", "--quiet", "--json", "--audit", "--threads", str(self.args.threads), "--steps", str(first + steps),
                          *sets(self.overrides(case) + list(point.sets))])
        return json.loads(out[out.index("{"):])["missed_contacts"]

    @staticmethod
    def output(command):
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
        if done.returncode not in (0, PHYSICS) or "{" not in done.stdout:
            raise Failed(f"{shlex.join(command)}: exit code {done.returncode}\n{done.stderr[-2000:]}")
        return done.stdout

    def record(self, row):
        self.runs[row["key"]] = row
        with open(self.journal, "a", encoding="utf-8") as f:
            f.write(json.dumps(row) + "\n")
            f.flush()
            os.fsync(f.fileno())

    def results(self):
        """Finished runs of this call's plan."""
        return [self.runs[k] for k in self.wanted if k in self.runs]


def sets(items):
    out = []
    for item in items:
        out += ["--set", item]
    return out


def say(text):
    print(text, file=sys.stderr, flush=True)
