#!/usr/bin/python3
"""Writes trajectories/NAME.csv for each scene trajectories/NAME.yaml: the state at the end, in quadruple
precision. Compiles trajectories.cpp, which does the work; README.md explains the columns.

    ./trajectories.py [NAME ...]
"""

import pathlib
import subprocess
import sys
import tempfile

import scene as scenes

HERE = pathlib.Path(__file__).parent
FOLDER = HERE / "trajectories"

# How long, s: short of chaos, which would multiply the last digits of any double.
DURATIONS = {
    "pendulum_1": 5, "double_2": 2, "damped_2": 10, "springs_3": 4, "push_3": 3, "sine_4": 2, "ramp_4": 2,
    "everything_5": 1.5, "points_6": 1.5, "heavy_tip_8": 1, "stiff_6": 0.5, "spin_12": 1, "swing_12": 1,
    "rope_30": 0.75, "rope_100": 0.125,
}


def numbers(scene, duration):
    """The scene as trajectories.cpp reads it."""
    rows = [[*scene.gravity, float(duration), len(scene.links)]]
    for link in scene.links:
        rows.append([link.mass, link.inertia, *link.com, *link.pin, link.stiffness, link.damping,
                     link.rest_angle, link.angle, link.velocity])
    rows.append([len(scene.loads)])
    for load in scene.loads:
        kind, *data = load.law
        if kind == "ramp":
            times, values = data
            data = [len(times), *(x for corner in zip(times, values) for x in corner)]
        rows.append([-1 if load.link is None else load.link, *load.force, *load.point, load.moment,
                     -1 if load.joint is None else load.joint, load.torque,
                     load.start, min(load.stop, 1e300), kind, *data])
    return "\n".join(" ".join(map(str, row)) for row in rows)


def main():
    with tempfile.TemporaryDirectory() as scratch:
        program = f"{scratch}/trajectories"
        subprocess.run(["g++", "-std=c++17", "-O2", str(HERE / "trajectories.cpp"), "-o", program,
                        "-lquadmath"], check=True)
        for name in sys.argv[1:] or DURATIONS:
            duration = DURATIONS[name]
            scene = scenes.read(FOLDER / f"{name}.yaml")
            lines = subprocess.run([program], input=numbers(scene, duration), stdout=subprocess.PIPE,
                                   text=True, check=True).stdout.splitlines()
            rows = [line.split() for line in lines]
            assert len(rows) == 2 * len(scene.links)
            assert all(float(uncertainty) < 1e-20 for _, uncertainty, _ in rows), name
            half = len(rows) // 2
            table = ["t,quantity,index,value,uncertainty,rounding"]
            for k, row in enumerate(rows):
                table.append(",".join([str(duration), "q" if k < half else "qd", str(k % half), *row]))
            (FOLDER / f"{name}.csv").write_text("\n".join(table) + "\n", encoding="utf-8")
            print(name, "uncertainty", max(float(row[1]) for row in rows),
                  "rounding", max(float(row[2]) for row in rows), flush=True)


if __name__ == "__main__":
    main()
