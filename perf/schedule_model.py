"""Reads a recorded trace of `talus run --threads 1 --trace` and simulates the schedule of its task graph on many cores.

Who calls it: schedule.py. No I/O except reading the trace; the same seed gives the same numbers.

The model. A step is: displacement_check (serial), the lanes (one per core), in each lane for one chunk after another
narrow_phase -> contact_force -> (wall_contact) -> integrate until none is left, a join. After a step without a rebuild lanes wait for
the next one in place (scheduler/team/step_gate.hpp) and see it begin one after another; after a rebuild they are handed out as tasks, as
are the blocks of its loops. A rebuild is the sequence of serial parts and parallel loops that the trace shows. Durations
are those measured, chunk by chunk; a larger system draws from them. Scheduling of tasks follows oneTBB 2021.8 (its sources):
  - a finished node runs one ready successor on the same thread at once and puts the others at the end of its own queue; the owner
    takes from the end, a thief from the front;
  - a thread without work picks one victim at random; a failed attempt costs a pause of 1000 cycles; after some hundred failures it
    falls asleep, and waking it costs `wake`;
  - taking tasks out of one queue is serialised by its lock.
Which chunk a lane works on is the engine's choice (scheduler/team/shares.cpp): its thread takes the next chunk of its own share of
consecutive chunks, or the last one of the fullest share when its own is used up. Recorded chunks have equal cost to the
engine's estimate, as in a run with threads; what they really cost is in the trace.
Memory: traffic beyond the caches shares the node's bandwidth; a chunk cannot finish faster than its share allows.
"""
import heapq
import json
import random
from dataclasses import dataclass, field

CHAIN = ("narrow_phase", "contact_force", "wall_contact", "integrate")


@dataclass
class Costs:
    """What the scheduler itself costs, in seconds."""

    hop: float = 0.1e-6       # from a node to the next one of its chain; measured in the trace
    turn: float = 0.2e-6      # from the end of a chunk to the next one of the lane; measured in the trace
    spawn: float = 0.1e-6     # putting one ready task into the queue
    join: float = 1e-6        # last integrate -> displacement_check; measured in the trace
    steal: float = 0.3e-6     # taking a task out of another thread's queue, under its lock
    attempt: float = 0.4e-6   # a failed attempt: prolonged_pause(), 1000 cycles
    asleep_after: float = 150e-6  # idle time after which a worker sleeps: 100 yields and 2 (threads + 1) pauses
    wake: float = 20e-6       # waking it: 5 to 50 us
    seen: float = 0.2e-6      # until the first waiting lane sees the step begin: a line written by another core
    seen_next: float = 0.02e-6  # and each further one: the line is handed out to one after another
    patience: float = 40e-6   # a lane that has waited for longer ends and has to be handed out again


@dataclass
class Memory:
    """A stated node: shared bandwidth and caches."""

    bytes_per_particle: float = 0.0
    bandwidth: float = 0.0  # of a socket [B/s]
    l2: float = 0.0         # of a core [B]
    l3: float = 0.0         # of a socket [B]
    socket: int = 56        # cores

    def seconds_per_particle(self, cores, particles):
        """Least time of one core per particle-step while all cores stream: 0 if everything stays in the caches."""
        if self.bandwidth <= 0:
            return 0.0
        sockets = -(-cores // self.socket)
        working_set = self.bytes_per_particle * particles
        share = max(0.0, 1 - (cores * self.l2 + sockets * self.l3) / working_set)
        return cores * share * self.bytes_per_particle / (sockets * self.bandwidth)


@dataclass
class Recording:
    """What a trace says about one scene and chunk size."""

    facts: dict
    chains: list            # steps x chunks x {node: seconds}
    check: float            # seconds of displacement_check
    first_gap: float        # end of the check to the first narrow_phase
    join_gap: float         # end of the last integrate to the next check
    turn: float             # end of an integrate to the next narrow_phase
    hop: float
    rebuild: list = None    # segments of a rebuild: ("serial", s) or ("loop", [s, ...])
    sort_epoch: list = None  # of an epoch without the rebuild in it
    rebuild_share: float = 0.0
    kinds: list = field(default_factory=list)

    @property
    def chunks(self):
        return len(self.chains[0])

    def work(self):
        """Median seconds of a step's chunks: how disturbed the recording was."""
        return median([sum(sum(c.values()) for c in step) for step in self.chains])

    def kind_seconds(self, kind):
        """Mean seconds per step of one node kind, all chunks."""
        return sum(c.get(kind, 0.0) for step in self.chains for c in step) / len(self.chains)


class TraceError(Exception):
    pass


def median(values):
    values = sorted(values)
    return values[len(values) // 2] if values else 0.0


def segments(events, begin, end, inner=()):
    """Serial parts and parallel loops between begin and end; `inner` intervals belong to another node and are cut out."""
    out, at = [], begin
    loops = []
    for e in events:
        key = e["args"]["loop"]
        if not loops or loops[-1][0] != key:
            loops.append((key, []))
        loops[-1][1].append(e)
    marks = [(g[0]["ts"], max(e["ts"] + e["dur"] for e in g), [e["dur"] * 1e-6 for e in g]) for _, g in loops]
    marks += [(b, e, None) for b, e in inner]
    for b, e, blocks in sorted(marks, key=lambda m: m[0]):
        out.append(("serial", max(0.0, b - at) * 1e-6))
        if blocks:
            out.append(("loop", blocks))
        at = e
    out.append(("serial", max(0.0, end - at) * 1e-6))
    return out


def read_trace(path):
    with open(path) as f:
        trace = json.load(f)
    facts = trace["otherData"]
    if facts["threads"] != 1:
        raise TraceError(f"{path}: recorded with {facts['threads']} threads; durations are wanted from one")
    events = sorted((e for e in trace["traceEvents"] if e["ph"] == "X"), key=lambda e: e["ts"])
    steps = {}
    for e in events:
        steps.setdefault(e["args"]["step"], []).append(e)
    chains, checks, first, joins, hops, turns = [], [], [], [], [], []
    rebuilds, epochs, last_end = [], [], None
    for number in sorted(steps):
        chunks, serial, blocks = {}, {}, []
        for e in steps[number]:
            if "chunk" in e["args"]:
                chunks.setdefault(e["args"]["chunk"], {})[e["name"]] = e
            elif "loop" in e["args"]:
                blocks.append(e)
            else:
                serial[e["name"]] = e
        if not chunks or any("integrate" not in c or "narrow_phase" not in c for c in chunks.values()):
            continue  # the last check of a run, or a step cut off by the end of the trace
        chains.append([{k: v["dur"] * 1e-6 for k, v in chunks[c].items()} for c in sorted(chunks)])
        check = serial.get("displacement_check")
        if check:
            checks.append(check["dur"] * 1e-6)
            if last_end is not None:
                joins.append((check["ts"] - last_end) * 1e-6)
            if "rebuild" not in serial:
                first.append((min(c["narrow_phase"]["ts"] for c in chunks.values()) - check["ts"] - check["dur"]) * 1e-6)
        for c in chunks.values():
            chain = [c[k] for k in CHAIN if k in c]
            hops += [(b["ts"] - a["ts"] - a["dur"]) * 1e-6 for a, b in zip(chain, chain[1:])]
        ends = sorted((c["narrow_phase"]["ts"], c["integrate"]["ts"] + c["integrate"]["dur"]) for c in chunks.values())
        turns += [(b[0] - a[1]) * 1e-6 for a, b in zip(ends, ends[1:])]
        last_end = max(c["integrate"]["ts"] + c["integrate"]["dur"] for c in chunks.values())
        span = lambda e: (e["ts"], e["ts"] + e["dur"])
        if "rebuild" in serial:
            b, e = span(serial["rebuild"])
            rebuilds.append(segments([x for x in blocks if x["name"] == "rebuild"], b, e))
        if "sort_epoch" in serial:
            b, e = span(serial["sort_epoch"])
            inner = [span(serial["rebuild"])] if "rebuild" in serial else []
            epochs.append(segments([x for x in blocks if x["name"] == "sort_epoch"], b, e, inner))
    if not chains:
        raise TraceError(f"{path}: no complete step")
    count = median([len(c) for c in chains])
    chains = [c for c in chains if len(c) == count]
    clip(chains)
    chains = quieter_half(chains)
    kinds = [k for k in CHAIN if k in chains[0][0]]
    return Recording(facts, chains, median(checks), median(first), median(joins), median(turns), median(hops), typical(rebuilds), typical(epochs), kinds=kinds)


def step_times(path):
    """Seconds of every step of a trace that rebuilt nothing: from one displacement_check to the next. Any number of threads."""
    with open(path) as f:
        events = [e for e in json.load(f)["traceEvents"] if e["ph"] == "X" and "chunk" not in e["args"]]
    begin = {e["args"]["step"]: e["ts"] for e in events if e["name"] == "displacement_check"}
    rebuilt = {e["args"]["step"] for e in events if e["name"] == "rebuild"}
    return [(begin[s + 1] - begin[s]) * 1e-6 for s in sorted(begin) if s + 1 in begin and s not in rebuilt]


def length(parts):
    return sum(sum(v) if kind == "loop" else v for kind, v in parts)


def typical(recorded):
    """Part by part and block by block the median over the recorded events of the same structure as the shortest one: a block that
    was interrupted once would else be the critical path of every core count."""
    if not recorded:
        return None
    shape = lambda parts: [(kind, len(v) if kind == "loop" else 0) for kind, v in parts]
    wanted = shape(min(recorded, key=length))
    alike = [r for r in recorded if shape(r) == wanted]
    return [(kind, [median([r[k][1][b] for r in alike]) for b in range(blocks)] if kind == "loop" else median([r[k][1] for r in alike]))
            for k, (kind, blocks) in enumerate(wanted)]


def quieter_half(chains):
    """The steps of the recording that took least, in their order: on a shared machine whole stretches of steps run a third longer
    because of its other guests, and how many of them a recording holds differs between chunk sizes."""
    total = [sum(sum(c.values()) for c in step) for step in chains]
    middle = median(total)
    return [step for step, t in zip(chains, total) if t <= middle]


def clip(chains):
    """A node that lasts more than 1.5 x its chunk's median was interrupted by something else: it takes the median."""
    for k in range(len(chains[0])):
        for kind in chains[0][k]:
            middle = median([step[k][kind] for step in chains])
            for step in chains:
                if step[k][kind] > 1.5 * middle:
                    step[k][kind] = middle


class Machine:
    """`cores` workers with queues; worker 0 runs the serial parts."""

    def __init__(self, cores, costs, seed=1):
        self.cores, self.costs = cores, costs
        self.random = random.Random(seed)
        self.idle_since = [0.0] * cores
        self.now = 0.0
        self.busy = 0.0

    def serial(self, seconds):
        self.now += seconds
        self.idle_since[0] = self.now
        self.busy += seconds

    def fork_join(self, durations, tree, shares=None, waiting=False):
        """Runs tasks of the given durations from worker 0; tree: ranges are halved and handed on, otherwise worker 0 queues every
        task itself. shares: bounds of the workers' shares of the durations; the tasks are then lanes, one per worker, each of which
        takes one duration after another until none is left. waiting: the lanes wait on their workers since the last step. Sets now to
        the end of the last one."""
        c, p = self.costs, self.cores
        if p == 1:
            self.now += sum(durations) + (c.turn if shares else c.spawn) * len(durations)
            self.busy += sum(durations)
            self.idle_since[0] = self.now
            return
        queues = [[] for _ in range(p)]  # (available at, first, last) ranges of tasks
        heads = [0] * p
        locks = [0.0] * p
        tasks = min(p, len(durations)) if shares else len(durations)
        left = tasks
        end = self.now
        events = []
        for w in range(1, 1 if waiting else p):
            asleep = self.now - self.idle_since[w] > c.asleep_after
            events.append((self.now + (c.wake * self.random.uniform(0.5, 1.5) if asleep else c.attempt * self.random.random()), w, False))
        heapq.heapify(events)

        window = [list(b) for b in zip(shares, shares[1:])] if shares else None

        def taken(w):
            """The chunk that a chain starting on worker w works on."""
            own = window[w]
            if own[0] < own[1]:
                own[0] += 1
                return own[0] - 1
            fullest = max(window, key=lambda b: b[1] - b[0])
            if fullest[0] == fullest[1]:
                return -1
            fullest[1] -= 1
            return fullest[1]

        def advance(w, t):
            """The next chunk of worker w's lane, or its end."""
            nonlocal left, end
            k = taken(w)
            if k < 0:
                left -= 1
                end = max(end, t)
                self.idle_since[w] = t
                if not waiting:
                    heapq.heappush(events, (t, w, False))
                return
            self.busy += durations[k]
            heapq.heappush(events, (t + durations[k] + c.turn, w, True))

        def execute(w, t, first, last):
            """Runs a range on worker w from t on, up to its first event."""
            nonlocal left, end
            if tree:
                while last - first > 1:
                    middle = (first + last) // 2
                    t += c.spawn
                    queues[w].append((t, middle, last))
                    last = middle
            else:
                for k in range(first, last - 1):
                    t += c.spawn
                    queues[w].append((t, k, k + 1))
                first = last - 1
            if shares:
                return advance(w, t)
            lasts = durations[first]
            t += lasts
            self.busy += lasts
            left -= 1
            end = max(end, t)
            self.idle_since[w] = t
            heapq.heappush(events, (t, w, False))

        if waiting:
            t = self.now + c.seen
            for w in self.random.sample(range(1, p), p - 1)[:tasks - 1]:
                late = c.steal + c.attempt if self.now - self.idle_since[w] > c.patience else 0
                heapq.heappush(events, (t + late, w, True))
                t += c.seen_next
            advance(0, self.now)
        else:
            execute(0, self.now, 0, tasks)
        while left > 0:
            t, w, in_lane = heapq.heappop(events)
            if in_lane:
                advance(w, t)
                continue
            if len(queues[w]) > heads[w]:
                start = max(t, locks[w])
                _, first, last = queues[w].pop()
                execute(w, start, first, last)
                continue
            v = self.random.randrange(p - 1)
            v += v >= w
            if len(queues[v]) > heads[v] and queues[v][heads[v]][0] <= t:
                _, first, last = queues[v][heads[v]]
                heads[v] += 1
                start = max(t, locks[v]) + c.steal
                locks[v] = start
                execute(w, start, first, last)
            else:
                heapq.heappush(events, (t + c.attempt, w, False))
        self.now = end
        self.idle_since[0] = max(self.idle_since[0], end)


def resampled(values, count, rng):
    return values if count == len(values) else [values[rng.randrange(len(values))] for _ in range(count)]


def scaled(parts, factor, chunks, recorded_chunks, particles, cores, rng):
    """Segments of a rebuild for another number of particles: serial parts grow with it, loops over chunks get more blocks. A loop
    that one thread runs as one block is cut by threads in the engine (blocks of at least 8192 grains)."""
    out = []
    for kind, value in parts:
        if kind == "serial":
            out.append((kind, value * factor))
        elif len(value) == recorded_chunks:
            out.append((kind, resampled(value, chunks, rng)))
        elif len(value) == 1:
            blocks = max(1, min(cores, int(particles // 8192) + 1))
            out.append((kind, [value[0] * factor / blocks] * blocks))
        else:
            blocks = max(1, round(len(value) * factor))
            total = sum(value) * factor / blocks
            mean = sum(value) / len(value)
            out.append((kind, [v * total / mean for v in resampled(value, blocks, rng)]))
    return out


def equal_shares(chunks, workers):
    """As many chunks for every worker, as the engine has them where all chunks cost the same."""
    return [chunks * w // workers for w in range(workers + 1)]


def simulate(rec, particles, cores, costs, memory, tree, rebuild_every, samples=6, seed=1):
    """Seconds per step and their parts for one system on one machine."""
    rng = random.Random(seed)
    chunk = rec.facts["chunk"]
    chunks = max(1, -(-particles // chunk))
    factor = particles / rec.facts["particles"]
    per_particle = memory.seconds_per_particle(cores, particles)
    all_chains = [[sum(c.values()) for c in step] for step in rec.chains]
    hops = (len(rec.kinds) - 1) * costs.hop
    shares = equal_shares(chunks, cores)

    def one_step(machine, durations, waiting):
        begin = machine.now
        machine.serial(rec.check)  # of the same length whatever the chunks: none but those with news are visited
        machine.fork_join(durations, tree, shares, waiting)
        machine.serial(costs.join)
        return machine.now - begin

    steps, extras, busy, limited, longest = [], [], 0.0, 0, 0.0
    for s in range(samples):
        durations = resampled(all_chains[s * len(all_chains) // samples], chunks, rng)
        least = per_particle * particles / chunks
        limited += sum(d < least for d in durations)
        durations = [max(d, least) + hops for d in durations]
        longest = max(longest, max(durations))
        machine = Machine(cores, costs, seed + s)
        handed_out = one_step(machine, durations, False)
        before = machine.busy
        steps.append(one_step(machine, durations, True))
        busy += machine.busy - before
        extras.append(max(0.0, handed_out - steps[-1]))  # of the step after a rebuild
    step, extra = sum(steps) / samples, sum(extras) / samples
    result = {"step": step, "busy_step": busy / samples, "longest_chain": longest, "hand_out": extra,
              "bandwidth_limited": limited / (samples * chunks), "chunks": chunks}
    sort_every = rec.facts["sort_every"]
    rates = {"rebuild": 1 / rebuild_every + 1 / sort_every, "sort_epoch": 1 / sort_every}
    total = step + extra * rates["rebuild"]
    critical = rec.check + costs.spawn + longest + costs.join
    for name, rate in rates.items():
        parts = getattr(rec, name)
        if parts is None:
            continue
        parts = scaled(parts, factor, chunks, rec.chunks, particles, cores, rng)
        machine = Machine(cores, costs, seed)
        path = 0.0
        for kind, value in parts:
            if kind == "serial":
                machine.serial(value)
                path += value
            else:
                machine.fork_join(value, True)
                path += max(value)
        result[name] = machine.now
        result[name + "_work"] = length(parts)
        result[name + "_per_step"] = machine.now * rate
        total += machine.now * rate
        critical += path * rate
    result["total"] = total
    result["critical_path"] = critical
    return result
