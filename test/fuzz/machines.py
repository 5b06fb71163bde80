#!/usr/bin/python3
"""Random machines by five methods at 1e-10, against each other; where they differ, how the scene lets errors grow.

    machines.py SIMULATE [COUNT [FIRST]]        SIMULATE: the program; FIRST: the first of COUNT seeds

The machines mix rotors, drives, dry friction, springs, dampers, stops, loads and moving bases. Prints scenes whose ends
are more than 1e-6 apart, relative to the larger of 1 and the number. Growth: what 1e-9 more in the first angle becomes.
"""
import concurrent.futures
import csv
import json
import os
import random
import subprocess
import sys
import tempfile

METHODS = ("auto", "dop853", "rodas5p", "radau13", "taylor")
DURATION, LIMIT = 1.0, 60


def law(chance, size):
    if chance.random() < 0.6:
        return {"amplitude": chance.uniform(0, size), "frequency": chance.uniform(0.2, 3), "phase": chance.uniform(-3, 3)}
    return {"times": [0.1, 0.3 + chance.random() / 3, 0.9], "values": [chance.uniform(-size, size) for _ in range(3)]}


def joint(chance):
    if chance.random() < 0.15:
        made = {"drive": law(chance, 1) if chance.random() < 0.7 else "hold"}
    else:
        made = {}
        if chance.random() < 0.5:
            made["friction"] = 10 ** chance.uniform(-2, 1)
            if chance.random() < 0.3:
                made["breakaway"] = made["friction"] * chance.uniform(1, 2)
        if chance.random() < 0.4:
            made.update(stiffness=10 ** chance.uniform(-1, 3), rest_angle=chance.uniform(-1, 1))
        if chance.random() < 0.4:
            made["damping"] = 10 ** chance.uniform(-2, 1)
        if chance.random() < 0.25:
            middle = chance.uniform(-1, 1)
            made.update(lower=middle - chance.uniform(0.2, 2), upper=middle + chance.uniform(0.2, 2),
                        stop_stiffness=10 ** chance.uniform(2, 5), stop_damping=chance.uniform(0, 5))
    if chance.random() < 0.3:
        made["rotor_inertia"] = 10 ** chance.uniform(-3, 1)
    return made


def machine(seed):
    chance = random.Random(seed)
    names = [f"l{k}" for k in range(chance.choice((1, 2, 3, 4, 6, 8, 12, 16)))]
    links = {}
    for name in names:
        length, mass = chance.uniform(0.2, 1), 10 ** chance.uniform(-1, 1)
        made = joint(chance)
        links[name] = {"mass": mass, "inertia": mass * length ** 2 * chance.uniform(0.02, 0.2),
                       "com": [length * chance.random(), chance.uniform(-0.1, 0.1)], "pin": [length, 0], "joint": made}
        if "drive" not in made:
            links[name]["initial"] = {"angle": chance.uniform(-1, 1),
                                      "velocity": chance.choice((0, 0, chance.uniform(-3, 3)))}
    scene = {"chain": names, "links": links, "loads": {}}
    for k in range(chance.choice((0, 0, 1, 2))):
        load = {"link": chance.choice(names), "force": [chance.uniform(-20, 20), chance.uniform(-20, 20)]}
        load.update(chance.choice(({}, {"frequency": chance.uniform(0.5, 4)}, {"start": 0.2, "stop": 0.7},
                                   {"times": [0, 0.3, 0.8], "values": [0, 1, -1]})))
        scene["loads"][f"f{k}"] = load
    if chance.random() < 0.3:
        scene["base"] = {axis: law(chance, 0.3) for axis in ("x", "y", "angle") if chance.random() < 0.6} or {"x": law(chance, 1)}
    return scene


def end(program, scene, method, tolerance, folder):
    """q and qd at the end, or why there is none."""
    path, out = os.path.join(folder, "scene.yaml"), os.path.join(folder, "out.csv")
    with open(path, "w") as file:
        json.dump(scene, file)
    command = [program, path, "--duration", str(DURATION), "--rate", str(1 / DURATION), "--csv", out, "--method", method,
               "--tolerance", str(tolerance)]
    try:
        result = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, timeout=LIMIT)
    except subprocess.TimeoutExpired:
        return f"more than {LIMIT} s"
    if result.returncode != 0:
        return result.stderr.decode().strip()
    with open(out, newline="") as file:
        return [float(number) for number in list(csv.reader(file))[-1][1:-1]]


def apart(a, b):
    return max(abs(x - y) / max(1, abs(x)) for x, y in zip(a, b))


def judge(program, seed):
    scene = machine(seed)
    with tempfile.TemporaryDirectory() as folder:
        ends = {method: end(program, scene, method, 1e-10, folder) for method in METHODS}
        failed = {method: why for method, why in ends.items() if isinstance(why, str)}
        good = {method: numbers for method, numbers in ends.items() if method not in failed}
        first = next(iter(good.values()), [])
        most = {method: apart(first, numbers) for method, numbers in good.items()}
        if not failed and max(most.values()) <= 1e-6:
            return None
        free = next((name for name in scene["chain"] if "initial" in scene["links"][name]), None)
        growth = "not known"
        if free and good:
            scene["links"][free]["initial"]["angle"] += 1e-9
            moved = end(program, scene, next(iter(good)), 1e-10, folder)
            growth = moved if isinstance(moved, str) else f"{apart(first, moved) / 1e-9:.1e}"
    return f"seed {seed}, {len(scene['chain'])} links: {failed} " + " ".join(
        f"{method} {value:.1e}" for method, value in most.items()) + f", growth {growth}"


def main():
    if not 2 <= len(sys.argv) <= 4:
        sys.exit(__doc__)
    count, start = (int(number) for number in (sys.argv[2:] + ["200", "0"][len(sys.argv) - 2:]))
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        found = [line for line in pool.map(lambda seed: judge(sys.argv[1], seed), range(start, start + count)) if line]
    print(*found, f"{len(found)} of {count} scenes differ", sep="\n")


if __name__ == "__main__":
    main()
