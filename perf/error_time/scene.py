"""What all scenes share: a Setting names the knobs of one point of the plot, a Scene builds Problems and judges Outcomes.

Who calls it: the scene modules and error_time.py. A Scene says `tc`, the contact time of its hard law; a Setting's q is the
number of steps per contact time of the law it uses, so with a softened law the step follows. Invariant: steps divide into
the scene's frames, so that all settings are compared at the same instants.
"""
import dataclasses
import math

from .problem import Problem

DEFAULT = "default (centred)"
LISTS = "lists and instruction sets"
INEXACT = "list that may miss contacts"


@dataclasses.dataclass
class Setting:
    label: str
    family: str
    q: float
    code: str = "talus"
    soft: float = 1.0
    hertz: bool = False
    knobs: dict = dataclasses.field(default_factory=dict)
    peer: dict = None
    same_bits_as: str = None    # label of the setting whose state hash this one must have
    may_stop: bool = False      # the program may refuse or stop: that is a result


@dataclasses.dataclass
class Judged:
    """error: of the scene's norm; half: half width of its 95 % interval (0 where there is no statistics)."""
    error: float
    half: float = 0.0
    note: str = ""


class Scene:
    name = title = norm = reference = ""
    kind = "exact"              # exact, path or bulk
    tc = T = 1.0
    frames = 1
    seeds = (1,)
    law = hertz_law = None
    skin = 0.1                  # of the peers, in length units of the scene
    softenings = ()
    energy_counts = True        # the engine's energy balance is complete for this scene
    limits = ()                 # sentences about what the scene cannot show

    def __init__(self, quick):
        self.quick = quick
        self.notes = []         # facts found on the way, printed below the plot
        self.limits = list(self.limits)

    def body(self, seed):
        """Arguments of Problem that do not depend on the setting."""
        raise NotImplementedError

    def prepare(self, engine):
        """References and initial states."""

    def judge(self, setting, outcomes):
        raise NotImplementedError

    def finish(self, rows):
        """After all settings: what needs all of them."""

    def build(self, setting, seed):
        law = self.hertz_law if setting.hertz else self.law
        if setting.soft != 1:
            law = law.softened(setting.soft)
        tc = self.tc * math.sqrt(setting.soft)
        per_frame = max(1, round(self.T / self.frames * setting.q / tc))
        knobs = dict(setting.knobs)
        knobs.setdefault("checks.allow_unstable_step", True)
        return Problem(dt=self.T / (self.frames * per_frame), steps=per_frame * self.frames, frames=self.frames, law=law,
                       knobs=knobs, **self.body(seed))

    def steps_of(self, quick, full):
        return quick if self.quick else full

    def settings(self, features):
        """Points of this scene. features: what this build of Talus and this machine offer (see error_time.py)."""
        qs, middle = self.q_list(), self.q_middle
        out = [Setting(f"dt {q:g}", DEFAULT, q) for q in qs]
        base = f"dt {middle:g}"
        some = qs if not self.quick else [middle]
        for family, knobs in self.variants():
            out += [Setting(f"{family}, dt {q:g}", family, q, knobs=knobs) for q in some]
        if self.hertz_law:
            out += [Setting(f"Hertz, dt {q:g}", "Hertz law", q, hertz=True) for q in some]
            if self.hertz_law.mu > 0:  # a law of its own, so averages are told apart at one step
                out += [Setting(f"Hertz, partial slip, dt {q:g}", "Hertz law, partial slip", q, hertz=True,
                                knobs={"contact.partial_slip": True}) for q in ([middle] if self.kind == "bulk" else some)]
        out += [Setting(f"soft {f:g}", "softened, step follows", middle, soft=f, may_stop=True) for f in self.softenings]
        for key, value in features["precisions"]:
            out += [Setting(f"{key} {value}, dt {q:g}", f"{key} {value}", q, knobs={key: value}) for q in some]
        out += self.list_settings(features, base)
        for code in ("lammps", "liggghts"):
            if features[code]:
                out += [Setting(f"{code} dt {q:g}", code.upper(), q, code=code, peer={"skin": self.skin}, may_stop=True)
                        for q in self.peer_q_list()]
        return out

    def variants(self):
        return [("leapfrog", {"integrator": "leapfrog"}), ("pairwise dashpot", {"contact.dashpot": "pairwise"}),
                ("lagged dashpot", {"contact.dashpot": "lagged"})]

    def list_settings(self, features, base):
        q, out = self.q_middle, []
        cases = [(p, k) for p in features["exact_policies"] for k in ((200,) if self.quick else (20, 200, 1000))
                 if p not in ("always", "uniform") or k == 200]
        if self.quick and self.kind == "bulk":
            cases.remove(("always", 200))  # a search per step and seed takes longer than all the rest of a quick scene
        for policy, k in cases:
            out.append(Setting(f"{policy} K {k}", LISTS, q, knobs={"list.policy": policy, "list.verlet_k": float(k)},
                               same_bits_as=base))
        for isa in features["isas"] if not self.quick else features["isas"][:1]:
            out.append(Setting(f"isa {isa}", LISTS, q, peer={"isa": isa}, same_bits_as=base))
        for policy in features["inexact_policies"]:
            out.append(Setting(f"{policy}", INEXACT, q, knobs={"list.policy": policy, "list.interval": 25}))
        return out

    q_middle = 40

    def q_list(self):
        return [10, 40, 160] if self.quick else [6, 10, 20, 40, 80, 160, 320]

    def peer_q_list(self):
        return [10, 40] if self.quick else [10, 20, 40, 80, 160]
