#!/usr/bin/python3
"""Writes report/NAME.csv for each line of report/scenes.csv: where the report's scenes truly end, in absolute angles.

    ./report.py [NAME ...]

    pins        compiles pins.cpp, which does the work in quadruple precision (long ropes: 80 bits); before, it must agree with
                trajectories.cpp, other equations, on scenes of trajectories/
    exact       pendulum.csv
    published   beam.csv
    collocation stiff.csv
    quadrature  one_coordinate.py
README.md explains the columns.
"""

import csv
import itertools
import pathlib
import subprocess
import sys
import tempfile
from decimal import Decimal, getcontext

import one_coordinate
import scene as scenes
from trajectories import DURATIONS, numbers

HERE = pathlib.Path(__file__).parent
sys.path.append(str(HERE / "ends"))
import make  # noqa: E402  pylint: disable=wrong-import-position

ROOMS = {"report": HERE / "report", "config": HERE / "../../config/scenes"}
# As pins takes them: columns of the extrapolation and tolerance of a step, of the run and of a second one, and how
# often the scene is disturbed to see what rounding does.
USUAL = ("12", "1e-26", "9", "1e-24", "4")
PRECISION = {"rope100": ("12", "1e-24", "9", "1e-22", "4"), "rope1000": ("9", "1e-12", "8", "1e-11", "1"),
             "rope10000": ("9", "1e-11", "8", "1e-10", "1")}
KEPT = {"rope10000": 50}  # of the longest chain one link in so many, and the last
CHECKED = ("double_2", "damped_2", "springs_3", "push_3", "sine_4", "ramp_4", "heavy_tip_8", "stiff_6", "swing_12")

getcontext().prec = 30


def run(program, scene, duration, arguments=USUAL):
    """Rows of value, uncertainty, rounding: θ of each link, then ω."""
    return [line.split() for line in subprocess.run(
        [program, *arguments], input=numbers(scene, duration), stdout=subprocess.PIPE, text=True,
        check=True).stdout.splitlines()]


def check(program):
    """Newton and Euler with pin forces against Lagrange with Cholesky: both made in quadruple precision."""
    for name in CHECKED:
        ours = [Decimal(row[0]) for row in run(program, scenes.read(HERE / f"trajectories/{name}.yaml"),
                                               DURATIONS[name])]
        with open(HERE / f"trajectories/{name}.csv", encoding="utf-8") as file:
            theirs = [(row["quantity"], Decimal(row["value"])) for row in csv.DictReader(file)]
        off, total = Decimal(0), Decimal(0)
        for k, ((quantity, value), own) in enumerate(zip(theirs, ours)):
            total = value if k == 0 or quantity != theirs[k - 1][0] else total + value
            off = max(off, abs(total - own))
        print(f"pins and {name} agree to {off:.1e}", flush=True)
        assert off < 1e-17, name


def read_pendulum(_, row):
    with open(HERE / "pendulum.csv", encoding="utf-8") as file:
        values = {line["quantity"]: line["value"] for line in csv.DictReader(file)
                  if line["motion"] == "horizontal" and line["t"] == row["end_s"]}
    return [[values["q"], "0", "0"], [values["qd"], "0", "0"]]


def read_beam(_, __):
    with open(HERE / "beam.csv", encoding="utf-8") as file:
        return [[line["value"], "0", "0"] for line in csv.DictReader(file)]


def read_stiff(_, __):
    """The bar of stiff/falling.yaml with k = 1e9 and d = 1e6; from relative angles."""
    with open(HERE / "stiff.csv", encoding="utf-8") as file:
        lines = [line for line in csv.DictReader(file)
                 if (line["scene"], line["k"], line["d"]) == ("falling", "1e+09", "1e+06")]
    rows, total = [], Decimal(0)
    for line in lines:
        total = Decimal(line["value"]) + (total if line["index"] != "0" else 0)
        rows.append([f"{total:.19e}", line["uncertainty"], "0"])
    return rows


def scene_of(row):
    room, file = row["scene"].split("/")
    return scenes.read(ROOMS[room] / file)


def integrate(program, row):
    return run(program, scene_of(row), float(row["end_s"]), PRECISION.get(row["name"], USUAL))


def invert(_, row):
    """The end by an integral; DOP853 with dense equations and the force on the tip as unknown must agree."""
    scene, duration = scene_of(row), float(row["end_s"])
    rows = one_coordinate.ends(scene, duration)
    chain = [dict(mass=link.mass, inertia=link.inertia, com=link.com, pin=link.pin, q=link.angle, qd=link.velocity,
                  **({"axis": [1, 0]} if k == 0 and not scene.tip else {})) for k, link in enumerate(scene.links)]
    n = len(chain)
    other = make.run(chain, duration, make.pinned() if scene.tip else None)
    if scene.tip:
        other = [*itertools.accumulate(other[:n]), *itertools.accumulate(other[n:])]
    off = max(abs(float(value) - value_) for (value, *_), value_ in zip(rows, other))
    print(f"integral and DOP853 agree to {off:.1e}", flush=True)
    assert off < 1e-9, row["name"]
    return rows


def write(row, lines):
    n = len(lines) // 2
    table = ["quantity,index,value,uncertainty,rounding"]
    for k, line in enumerate(lines):
        if k % n % KEPT.get(row["name"], 1) == 0 or k % n == n - 1:
            table.append(",".join(["theta" if k < n else "omega", str(k % n), *line]))
    (HERE / "report" / f"{row['name']}.csv").write_text("\n".join(table) + "\n", encoding="utf-8")
    print(row["name"], "uncertainty", max(float(line[1]) for line in lines),
          "rounding", max(float(line[2]) for line in lines), flush=True)


def main():
    with open(HERE / "report/scenes.csv", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if not sys.argv[1:] or row["name"] in sys.argv[1:]]
    with tempfile.TemporaryDirectory() as scratch:
        program = f"{scratch}/pins"
        subprocess.run(["g++", "-std=gnu++17", "-O2", str(HERE / "pins.cpp"), "-o", program, "-lquadmath"], check=True)
        if any(row["reference"] == "pins" for row in rows):
            check(program)
        for row in rows:
            make = {"pins": integrate, "exact": read_pendulum, "published": read_beam,
                    "collocation": read_stiff, "quadrature": invert}[row["reference"]]
            write(row, make(program, row))


if __name__ == "__main__":
    main()
