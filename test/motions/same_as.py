#!/usr/bin/python3
"""Compares the motion of two builds: every scene of a folder, by every method.

    test/motions/same_as.py BEFORE AFTER [--scenes FOLDER] [--bound SCENE=X …] [--growth FACTOR]

BEFORE, AFTER: two programs `simulate`. Prints, of each scene and method, the largest difference between the two CSV files:
of an angle in units of 1 rad + |angle|, of a rate in units of 1 rad/s + the chain's largest rate. 0: the same to the last
bit, with the same messages. Exit status: 0 if no difference exceeds its scene's bound, else 1. Bounds are 0 unless --bound
gives one, for a whole scene (brake=1e-9) or for one method (brake/taylor=1e-9).

--growth prints beside it how far BEFORE moves if each initial angle changes by one unit in the last place of 1 + |angle|,
and allows FACTOR times as much as a bound. Where that is near 1 the motion is chaotic: choose a shorter --duration. A run
longer than --limit is passed over, and named. Both programs must run on one kind of processor."""
import argparse
import csv
import math
import os
import pathlib
import subprocess
import sys
import tempfile

import yaml

SCENES = pathlib.Path(__file__).absolute().parents[2] / "config/scenes"
METHODS = ("auto", "rk4", "dopri5", "dop853", "taylor", "rodas5p", "ros34pw2", "ros34pw2_fixed", "radau13")
DURATION = 2  # s
LONG = {64: 0.5, 1000: 0.02}  # s, from so many links on


def links_of(scene):
    return sum(scene["links"].get(name, {}).get("repeat", 1) for name in scene["chain"])


def duration_of(scene, longest):
    shorter = [duration for least, duration in LONG.items() if links_of(scene) >= least]
    return min([longest] + shorter)


def moved(scene):
    """The scene with each initial angle larger by one unit in the last place of 1 + |angle|, but in driven joints."""
    links = {}
    for name, link in scene["links"].items():
        if "drive" in link.get("joint", {}):
            links[name] = link
            continue
        initial = dict(link.get("initial") or {})
        angle = float(initial.get("angle", 0))
        initial["angle"] = angle + sys.float_info.epsilon * (1 + abs(angle))
        links[name] = {**link, "initial": initial}
    return {**scene, "links": links}


def motion(program, scene, method, duration, limit):
    """(exit status, messages, bytes of the CSV); None: it takes too long."""
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "run.csv")
        command = [str(program), str(scene), "--duration", str(duration), "--rate", "50", "--method", method, "--csv", out]
        try:
            done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, timeout=limit, check=False)
        except subprocess.TimeoutExpired:
            return None
        rows = pathlib.Path(out).read_bytes() if os.path.exists(out) else b""
        return done.returncode, done.stderr.replace(folder.encode(), b""), rows


def numbers(data):
    rows = csv.reader(data.decode().splitlines())
    names = next(rows, [])
    return names, [[float(cell) for cell in row] for row in rows]


def apart(before, after):
    """The largest difference; infinite where the files have other rows or the programs ended otherwise."""
    if before == after:
        return 0
    (names, ours), (other_names, theirs) = numbers(before[2]), numbers(after[2])
    if before[0] != after[0] or names != other_names or len(ours) != len(theirs):
        return math.inf
    most = 0
    rates = [i for i, name in enumerate(names) if name.startswith("qd_")]
    fastest = max((abs(row[i]) for row in ours for i in rates), default=0)
    for row, other in zip(ours, theirs):
        for name, a, b in zip(names, row, other):
            unit = 1 + (fastest if name.startswith("qd_") else abs(a))
            if name.startswith(("q_", "qd_")) and not a == b:
                difference = abs(a - b) / unit
                most = max(most, difference if difference == difference else math.inf)
    # If only the energy or a message differs, the difference is not 0.
    return most or sys.float_info.min


def read_bounds(given):
    bounds = {}
    for each in given:
        name, _, bound = each.partition("=")
        bounds[name] = float(bound)
    return bounds


def compare(scene, method, options):
    """(difference, growth or None); None: a run takes too long."""
    tree = yaml.safe_load(scene.read_text(encoding="utf-8"))
    duration = duration_of(tree, options.duration)
    before, after = (motion(program, scene, method, duration, options.limit)
                     for program in (options.before, options.after))
    if before is None or after is None:
        return None
    growth = None
    if options.growth is not None:
        with tempfile.NamedTemporaryFile("w", suffix=".yaml", encoding="utf-8") as file:
            yaml.safe_dump(moved(tree), file)
            file.flush()
            other = motion(options.before, file.name, method, duration, options.limit)
        growth = math.inf if other is None else apart(before, other)
    return apart(before, after), growth


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("before", type=pathlib.Path)
    parser.add_argument("after", type=pathlib.Path)
    parser.add_argument("--scenes", type=pathlib.Path, default=SCENES)
    parser.add_argument("--methods", type=lambda text: text.split(","), default=METHODS)
    parser.add_argument("--bound", nargs="*", default=[], metavar="SCENE=X")
    parser.add_argument("--growth", type=float, metavar="FACTOR")
    parser.add_argument("--duration", type=float, default=DURATION, help="s; long chains less")
    parser.add_argument("--limit", type=float, default=60, help="of a run, s")
    return parser.parse_args()


def main():
    options = arguments()
    bounds = read_bounds(options.bound)
    scenes = sorted(options.scenes.glob("*.yaml"))
    if not scenes:
        sys.exit(f"{options.scenes} has no scenes")
    same, other, passed_over = 0, [], []
    for scene in scenes:
        for method in options.methods:
            name = f"{scene.stem}/{method}"
            found = compare(scene, method, options)
            if found is None:
                passed_over.append(name)
                print(f"{name:32} took longer than {options.limit} s", flush=True)
                continue
            difference, growth = found
            bound = bounds.get(name, bounds.get(scene.stem, (options.growth or 0) * (growth or 0)))
            same += difference == 0
            if difference > bound:
                other.append(name)
            print(f"{name:32} {difference:9.2g}" + ("" if growth is None else f"   growth {growth:9.2g}") +
                  ("   MORE THAN " + f"{bound:.2g}" if difference > bound else ""), flush=True)
    print(f"{same} trajectories are the same to the last bit")
    for what, names in (("differ by more than their bound", other), ("were passed over", passed_over)):
        if names:
            print(f"{len(names)} {what}: {', '.join(names)}")
    return 1 if other else 0


if __name__ == "__main__":
    sys.exit(main())
