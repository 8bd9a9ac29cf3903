"""What the study runs: the cases, their prepared states, and the points of the sweep. Called by perf/study.py.

A state is taken by running a case's scene until `prepared` [s]; every timed run of that case resumes from this one
checkpoint, so that all points see the same physics (and, the policies being exact, must end with the same state_hash).
"""
import os
import re
import subprocess
from dataclasses import dataclass, field

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))

NONE = "none"  # the paper's "without Verlet buffer": a rebuild at every step
K_SWEEP = [0, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000]
UNIFORM_R = 1.0  # of the radius: the rival that the paper names
UNIFORM_TUNED = [0.7, 0.5, 0.35, 0.25, 0.18, 0.12, 0.08, 0.05, 0.03]
UNIFORM_FEW = [0.5, 0.25, 0.12, 0.06]
SWEPT = ["paper", "local"]
# The other policies: those with K at two of it, those with one skin for all at two skins (radii of the smallest grain).
ONE_SKIN = ("two_largest", "accumulated")
OTHER_K, OTHER_SKINS = [50, 200], [0.25, 0.1]
FIXED_INTERVAL, FIXED_SKIN = 10, 0.1  # 50 steps made grains meet unseen until the run stopped (hopper)
QUICK_STEPS, QUICK_WARM, QUICK_REPEATS = 1000, 200, 2  # lists of the small cases live 20 to 60 steps at K = 200


@dataclass(frozen=True)
class Case:
    name: str
    paper: str            # row of the paper's table 1, "" if none
    scene: str            # below cases/
    prepared: float       # simulated time of the common state [s]
    steps: int            # timed steps of one run
    make: str = ""        # script that writes the generated files, "" if none
    make_args: tuple = ()


def cases(full):
    size = "full" if full else "small"
    made = {"make_args": ("--only", size)}
    out = [
        Case("incline", "Granular flows", f"incline/{size}.toml", 1.1 if full else 0.7, 5000, "incline/make_incline.py", **made),
        Case("avalanche", "Avalanche", f"avalanche/{size}.toml", 6.0 if full else 4.0, 5000, "avalanche/make_avalanche.py", **made),
        Case("levelling", "Powder leveling", f"levelling/{size}.toml", 0.025 if full else 0.015, 5000,
             "levelling/make_levelling.py", **made),
        Case("grates", "Biomass", f"grates/{size}.toml", 2.0, 5000),
    ]
    # heat, conversion and gas on: 520 to 640 grains, of which some burn; no row of the paper's table
    furnace = [] if full else [Case("furnace", "", "grates/furnace.toml", 10.0, 5000)]
    if full:
        return [Case("hopper-125k", "Hopper 125k", "hopper/hopper-125k.toml", 1.1, 5000),
                Case("hopper-250k", "Hopper 250k", "hopper/hopper-250k.toml", 1.3, 5000),
                Case("hopper-500k", "Hopper 500k", "hopper/hopper-500k.toml", 1.5, 5000)] + out
    return [Case("hopper", "Hopper 125k", "hopper/hopper-20k.toml", 0.8, 5000)] + out + furnace


@dataclass(frozen=True)
class Point:
    """One setting of the list. `value`: K, or the skin of the uniform policy in radii."""
    series: str
    value: object
    sets: tuple = field(default=())

    @property
    def name(self):
        return f"{self.series} {self.value}" if self.value is not None else self.series


def sweep(policy, ks):
    return [Point(policy, k, (f"list.policy={policy}", f"list.verlet_k={k}")) for k in ks]


def points(offered, auto, series, ks, few=False):
    """All points of one case. offered: the policies of this build, auto: it can choose K itself, few: fewer uniform skins and
    the other policies at one setting each."""
    tuned, other_k, other_skins = (UNIFORM_FEW, OTHER_K[-1:], OTHER_SKINS[-1:]) if few else (UNIFORM_TUNED, OTHER_K, OTHER_SKINS)
    out = [Point(NONE, None, ("list.policy=always",))]
    for policy in SWEPT:
        if policy in series:
            out += sweep(policy, ks)
    if "uniform" in series:
        out += [Point("uniform", s, ("list.policy=uniform", f"list.uniform_skin={s}")) for s in [UNIFORM_R, *tuned]]
    if "others" in series:
        out += [Point("paper + floor", k, ("list.policy=local", f"list.verlet_k={k}", "list.acceleration=false")) for k in other_k]
        for policy in offered:
            if policy == "fixed":
                out += [Point(policy, FIXED_INTERVAL, (f"list.policy={policy}", f"list.interval={FIXED_INTERVAL}", f"list.uniform_skin={FIXED_SKIN}"))]
            elif policy in ONE_SKIN:
                out += [Point(policy, s, (f"list.policy={policy}", f"list.uniform_skin={s}")) for s in other_skins]
            elif policy not in ("always", "uniform", *SWEPT):
                out += [Point(policy, k, (f"list.policy={policy}", f"list.verlet_k={k}")) for k in other_k]
        if auto:
            out.append(Point("auto", None, ("list.policy=local", 'list.verlet_k="auto"')))
    return out


def choices(talus):
    """Policies that this build offers and whether K may be "auto", from its own help."""
    def ask(key):
        return subprocess.run([talus, "help", "scene", key], capture_output=True, text=True, check=True).stdout
    words = re.search(r"value:\s+one of (.*)", ask("list.policy"))
    if not words:
        raise SystemExit(f"study.py: {talus} help scene list.policy names no policies")
    return [w.strip() for w in words.group(1).split(",")], '"auto"' in ask("list.verlet_k") or " auto" in ask("list.verlet_k")
