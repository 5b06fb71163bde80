#!/usr/bin/python3
"""Evaluations of long chains with dry friction over those with dampers, from no friction to much.

    friction_sweep.py SIMULATE [DURATION [LINKS …]]     by default 0.3 s of 100, 300 and 1000 links of 0.1 m and 0.1 kg

The chains are let go level, at tolerance 1e-6. Prints a row for each friction, N m. Fails if a run does not end, a
tick of 5 ms takes more than a second on average, or the ratio is above 40.
"""
import json
import os
import re
import subprocess
import sys
import tempfile
import time

TORQUES = (1e-300, 1e-14, 1e-12, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1)
MOST_RATIO, TICK, MOST_TIME = 40, 0.005, 1


def evaluations(program, links, duration, joint):
    """The evaluations of one run, and its time per tick, s. None: it does not end."""
    link = {"mass": 0.1, "inertia": 1e-4, "com": [0.05, 0], "pin": [0.1, 0], "repeat": links, "joint": joint}
    with tempfile.TemporaryDirectory() as folder:
        scene = os.path.join(folder, "scene.yaml")
        with open(scene, "w") as file:
            json.dump({"chain": ["c"], "links": {"c": link}, "integrator": {"tolerance": 1e-6}}, file)
        begin = time.perf_counter()
        try:
            run = subprocess.run([program, scene, "--duration", str(duration)], stdout=subprocess.PIPE,
                                 stderr=subprocess.DEVNULL, universal_newlines=True, check=True,
                                 timeout=MOST_TIME * duration / TICK)
        except (subprocess.CalledProcessError, subprocess.TimeoutExpired):
            return None, None
        spent = time.perf_counter() - begin
    return int(re.search(r"(\d+) evaluations", run.stdout).group(1)), spent * TICK / duration


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    duration = float(sys.argv[2]) if len(sys.argv) > 2 else 0.3
    failures = 0
    for links in map(int, sys.argv[3:] or (100, 300, 1000)):
        for torque in TORQUES:
            rubbing, tick = evaluations(sys.argv[1], links, duration, {"friction": torque})
            damped, _ = evaluations(sys.argv[1], links, duration, {"damping": torque})
            if rubbing is None or damped is None:
                print(f"{links} links, {torque:g} N m: does not end", flush=True)
                failures += 1
                continue
            ratio = rubbing / damped
            failures += ratio > MOST_RATIO
            print(f"{links} links, {torque:g} N m: {rubbing} evaluations, {ratio:.1f} times those of dampers, "
                  f"{tick * 1e3:.1f} ms a tick", flush=True)
    sys.exit(1 if failures else 0)


main()
