#!/usr/bin/python3
"""Compares the motion of two builds: every scene that ships, by every method, byte for byte.

    test/same_motion.py BEFORE AFTER     # two folders with simulate in them, such as build/devel/lib/planar_chain

For whoever moves code: nothing that a trajectory is made of has changed if all are the same. Both must run on one
processor. A run that takes one of them longer than LIMIT is passed over, and named."""
import argparse
import pathlib
import subprocess
import sys
import tempfile

SCENES = pathlib.Path(__file__).absolute().parent.parent / "config/scenes"
METHODS = ("auto", "rk4", "dopri5", "dop853", "taylor", "rodas5p", "ros34pw2", "ros34pw2_fixed", "radau13")
DURATIONS = {"cable": 0.02}  # s; others: 1
LIMIT = 60  # s


def motion(folder, scene, method, csv):
    """The bytes of a trajectory and of what went wrong; None: it takes too long."""
    command = [folder / "simulate", scene, "--duration", str(DURATIONS.get(scene.stem, 1)), "--rate", "50",
               "--method", method, "--csv", csv]
    try:
        done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, timeout=LIMIT, check=False)
    except subprocess.TimeoutExpired:
        return None
    return done.returncode, done.stderr, pathlib.Path(csv).read_bytes() if pathlib.Path(csv).exists() else b""


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("before", type=pathlib.Path)
    parser.add_argument("after", type=pathlib.Path)
    options = parser.parse_args()
    same, other, passed_over = 0, [], []
    for scene in sorted(SCENES.glob("*.yaml")):
        for method in METHODS:
            with tempfile.TemporaryDirectory() as folder:
                runs = [motion(build, scene, method, f"{folder}/run.csv") for build in (options.before, options.after)]
            name = f"{scene.stem} by {method}"
            if None in runs:
                passed_over.append(name)
            elif runs[0] == runs[1]:
                same += 1
            else:
                other.append(name)
    print(f"{same} trajectories are the same to the last bit")
    for what, names in (("differ", other), (f"took longer than {LIMIT} s", passed_over)):
        if names:
            print(f"{len(names)} {what}: {', '.join(names)}")
    return 1 if other else 0


if __name__ == "__main__":
    sys.exit(main())
