#!/usr/bin/env python3
"""Runs commands in turn, A B C A B C ..., and prints what each of them says it took: python3 clock.py JOBS.json

Who calls it: engine.py, behind --wrap if one is given (a program that pins or isolates, so that it wraps one batch and not
every run). JOBS.json: {"rounds": n, "jobs": [{"code", "command", "cwd"}]}. Output: {"seconds": [[per round] per job],
"hash": [last state_hash or null], "load": largest load average}.
"""
import json
import os
import re
import subprocess
import sys


def seconds_of(code, text):
    """(seconds of the time loop, state_hash): what the code itself reports; start-up is not in it."""
    if code == "talus":
        summary = json.loads(text[text.index("{"):])
        return summary["wall_s"], summary["state_hash"]
    loops = re.findall(r"Loop time of ([0-9.eE+-]+) on", text)
    if not loops:
        raise ValueError("no 'Loop time' in its output")
    return float(loops[-1]), None


def main():
    with open(sys.argv[1]) as f:
        plan = json.load(f)
    jobs = plan["jobs"]
    taken, hashes, load = [[] for _ in jobs], [None] * len(jobs), 0.0
    for _ in range(plan["rounds"]):
        for i, job in enumerate(jobs):
            load = max(load, os.getloadavg()[0])
            done = subprocess.run(job["command"], cwd=job["cwd"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                  env=dict(os.environ, OMP_NUM_THREADS="1"), check=False)
            if done.returncode:
                sys.exit(f"{' '.join(job['command'])} in {job['cwd']}: exit code {done.returncode}\n{done.stdout[-2000:]}")
            s, hashes[i] = seconds_of(job["code"], done.stdout)
            taken[i].append(s)
    print(json.dumps({"seconds": taken, "hash": hashes, "load": load}))


if __name__ == "__main__":
    main()
