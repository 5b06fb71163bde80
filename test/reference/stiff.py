#!/usr/bin/python3
"""Writes stiff.csv: the scenes of stiff/ with springs and dampers of many strengths, in quadruple precision.
Compiles stiff.cpp, which does the work, and trajectories.cpp, an explicit method, which must agree where
nothing is damped.
"""

import pathlib
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

import scene as scenes
from trajectories import numbers

HERE = pathlib.Path(__file__).parent
# k: s in which the clamped bar vibrates some hundred times; s before it rests with d = k/1000
VIBRATING = {1e3: 0.5, 1e5: 0.125, 1e7: 0.015625, 1e9: 0.001953125}
COMING_TO_REST = {1e3: 1.0, 1e5: 0.25, 1e7: 0.00390625, 1e9: 0.001953125}


def cases():
    """Scene, k, d, duration, s."""
    for k, vibrating in VIBRATING.items():
        yield "bent", k, 0.0, vibrating
        yield "bent", k, k / 1000, COMING_TO_REST[k]
        yield "bent", k, k, 1.0
        yield "falling", k, 0.0, vibrating / 4
        yield "falling", k, k / 1000, 1.0
        yield "falling", k, k, 1.0


def scaled(scene, k, d):
    links = [SimpleNamespace(**{**vars(link), "stiffness": k * link.stiffness, "damping": d * link.damping})
             for link in scene.links]
    return SimpleNamespace(gravity=scene.gravity, links=links, loads=[])


def compiled(name, scratch):
    program = f"{scratch}/{name}"
    subprocess.run(["g++", "-std=gnu++17", "-O2", str(HERE / f"{name}.cpp"), "-o", program, "-lquadmath"],
                   check=True)
    return lambda text: [line.split() for line in subprocess.run(
        [program], input=text, stdout=subprocess.PIPE, text=True, check=True).stdout.splitlines()]


def main():
    with tempfile.TemporaryDirectory() as scratch:
        implicit, explicit = compiled("stiff", scratch), compiled("trajectories", scratch)

        def lines(case):
            name, k, d, duration = case
            text = numbers(scaled(scenes.read(HERE / "stiff" / f"{name}.yaml"), k, d), duration)
            rows = implicit(text)
            assert all(float(uncertainty) < 1e-12 for _, uncertainty in rows), case
            if d == 0:
                assert max(abs(float(a[0]) - float(b[0])) for a, b in zip(rows, explicit(text))) < 1e-12, case
            print(*case, "uncertainty", max(float(row[1]) for row in rows), flush=True)
            half = len(rows) // 2
            return [",".join([name, f"{k:g}", f"{d:g}", f"{duration!r}", "q" if i < half else "qd",
                              str(i % half), *row]) for i, row in enumerate(rows)]

        with ThreadPoolExecutor() as pool:
            table = [line for some in pool.map(lines, cases()) for line in some]
    header = "scene,k,d,t,quantity,index,value,uncertainty"
    (HERE / "stiff.csv").write_text("\n".join([header, *table]) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
