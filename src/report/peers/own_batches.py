#!/usr/bin/python3
"""The same batch by `simulate_many` on one core: reads it as JSON from standard input, and writes the states at the end and the time
of each repetition, s. Outside the environment of the other programs, whose NumPy is newer."""
import json
import sys
import time

from planar_chain import Scene, simulate_many

BATCH = json.load(sys.stdin)
SCENE = Scene({**Scene.from_file(BATCH["path"]).to_dict(), "integrator": {"tolerance": BATCH["tolerance"]}})
SECONDS = []
for _ in range(BATCH["repetitions"]):
    began = time.process_time()
    runs = simulate_many(SCENE, [BATCH["end"]], BATCH["starts"], threads=1)
    SECONDS.append(time.process_time() - began)
json.dump({"states": runs.states[:, -1, :].tolist(), "seconds": SECONDS}, sys.stdout)
