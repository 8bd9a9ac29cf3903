#!/usr/bin/env python3
"""Ten million grains on one core beside half a million: rate, ratio, bytes per particle, memory and time of start-up.

  python3 perf/large.py                       # perf/scenes/settle10m.toml: about 5 GiB, a minute and a half
  python3 perf/large.py --tiles 8             # fewer tiles of 32k (8 x 8: 2 million)

Exit 1 if the rate is below 0.7 of the rate at 512k, which is run before and after it.
"""
import argparse
import json
import os
import subprocess
import sys
import time

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(HERE)


def run(args, tiles, steps):
    command = ["taskset", "-c", str(args.core), args.talus, "run", os.path.join(HERE, "scenes", "settle10m.toml"), "--threads", "1",
               "--warm", str(args.warm), "--steps", str(args.warm + steps), "--quiet", "--json", "--overwrite", "--out",
               os.path.join(args.out, "run"), "--set", f"source.0.tile=[{tiles}, {tiles}, 1]", "--set",
               f"domain.upper=[{40 * tiles}, {20 * tiles}, 45]", "--set", "output.particles_every=0"]
    start = time.monotonic()
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
    wall = time.monotonic() - start
    if done.returncode != 0:
        raise SystemExit(f"large.py: {' '.join(command)}\n{done.stderr}")
    s = json.loads(done.stdout)
    n, rate = s["particles"], s["particle_steps_per_s"]
    rest = wall - (args.warm + steps) * n / rate
    print(f"{n:>9} grains: {rate / 1e6:6.2f} M particle-steps/s, {s['bytes_per_particle']:.0f} bytes per particle (arrays), peak "
          f"{s['peak_rss_bytes'] / 2**30:.2f} GiB = {s['peak_rss_bytes'] / n:.0f} bytes per particle; whole run {wall:.1f} s, of which "
          f"{rest:.1f} s start and end ({1e6 * rest / n:.2f} us per grain)", flush=True)
    return rate


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--talus", default=os.path.join(ROOT, "build", "talus"))
    p.add_argument("--tiles", type=int, default=18, help="per side, of 32k grains each")
    p.add_argument("--warm", type=int, default=10)
    p.add_argument("--steps", type=int, default=40)
    p.add_argument("--core", type=int, default=0)
    p.add_argument("--out", default=os.path.join(ROOT, "build", "large"))
    args = p.parse_args()
    args.talus = os.path.abspath(args.talus)
    before = run(args, 4, args.steps)
    large = run(args, args.tiles, args.steps)
    after = run(args, 4, args.steps)
    ratio = 2 * large / (before + after)
    print(f"ratio {ratio:.3f} (512k varied by {100 * abs(before - after) / (before + after) * 2:.0f} %), mark >= 0.7: "
          f"{'holds' if ratio >= 0.7 else 'DOES NOT HOLD'}")
    return 0 if ratio >= 0.7 else 1


if __name__ == "__main__":
    sys.exit(main())
