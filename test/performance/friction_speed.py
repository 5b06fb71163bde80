#!/usr/bin/python3
"""How much longer a falling chain takes with dry friction in every joint than with viscous dampers of like size.

    friction_speed.py SIMULATE [LINKS DURATION]      SIMULATE: the program; by default 10 links for 10 s, 100 for 3 s
"""
import json
import os
import resource
import subprocess
import sys
import tempfile

RUNS = 5


def processor_time(program, links, duration, joint):
    """The least of some runs of the whole program, s."""
    link = {"mass": 0.1, "inertia": 1e-4, "com": [0.05, 0], "pin": [0.1, 0], "repeat": links, "joint": joint}
    times = []
    with tempfile.TemporaryDirectory() as folder:
        scene = os.path.join(folder, "scene.yaml")
        with open(scene, "w") as file:
            json.dump({"chain": ["c"], "links": {"c": link}, "integrator": {"tolerance": 1e-6}}, file)
        for _ in range(RUNS):
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            subprocess.run([program, scene, "--duration", str(duration)], stdout=subprocess.DEVNULL, check=True)
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            times.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return min(times)


def main():
    if len(sys.argv) not in (2, 4):
        sys.exit(__doc__)
    for links, duration in [sys.argv[2:]] if sys.argv[2:] else ((10, 10), (100, 3)):
        damped, rubbing = (processor_time(sys.argv[1], int(links), duration, {kind: 0.01})
                           for kind in ("damping", "friction"))
        print(f"{links} links, {duration} s: dampers {damped:.3f} s, friction {rubbing:.3f} s, {rubbing / damped:.1f} times")


main()
