#!/usr/bin/python3
"""The motion of every scene that ships, on ARM64 and on x86-64: arm64_motion.py X86 ARM64 SYSROOT

X86 and ARM64 hold `simulate` of each; qemu-user runs that of ARM64. Rounding errors grow with a motion. How far they
carry it is seen on x86 alone, between its best kernel and its plain one. ARM64 may be TIMES as far from either."""
import csv
import os
import pathlib
import subprocess
import sys
import tempfile

SCENES = pathlib.Path(__file__).absolute().parents[2] / "config/scenes"
DURATIONS = {"cable": 0.02, "falling_chain": 0.7, "whip": 0.5}  # s; others: 1
TIMES = 4
ROUNDING = 2 ** -52
TELLING = 1e-6  # of the largest number: what has grown beyond shows nothing


def motion(command, scene, plain=""):
    """Rows of numbers: angles, rates, energies."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder, "run.csv")
        subprocess.run([*command, scene, "--duration", str(DURATIONS.get(scene.stem, 1)), "--rate", "50", "--csv", path],
                       stdout=subprocess.DEVNULL, check=True, env={**os.environ, "PLANAR_CHAIN_PLAIN_KERNEL": plain})
        with open(path, newline="") as file:
            names, *rows = csv.reader(file)
    states = [k for k, name in enumerate(names) if name.startswith(("q_", "qd_"))]
    return [[float(row[k]) for k in states] for row in rows]


def apart(a, b):
    return max(abs(x - y) for one, other in zip(a, b) for x, y in zip(one, other))


def main():
    x86, arm64, sysroot = sys.argv[1:]
    wrong = 0
    for scene in sorted(SCENES.glob("*.yaml")):
        best, plain = (motion([f"{x86}/simulate"], scene, kernel) for kernel in ("", "1"))
        there = motion(["qemu-aarch64", "-L", sysroot, f"{arm64}/simulate"], scene)
        size = max(abs(x) for row in best for x in row)
        own, theirs = apart(best, plain), min(apart(best, there), apart(plain, there))
        is_near = len(best) == len(there) > 1 and theirs <= TIMES * max(own, size * ROUNDING) < TELLING * size
        wrong += not is_near
        print(f"{scene.stem:20} {theirs:8.1e} from x86, whose kernels are {own:8.1e} apart {'' if is_near else 'TOO FAR'}", flush=True)
    sys.exit(wrong != 0)


main()
