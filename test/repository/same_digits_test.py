#!/usr/bin/python3
"""The plain kernel gives the same digits on every x86-64 CPU: this one, and a Nehalem of 2008 by qemu-user.

    same_digits_test.py SIMULATE SCENES_FOLDER"""
import os
import pathlib
import subprocess
import sys
import tempfile

SIMULATE, SCENES = sys.argv[1], pathlib.Path(sys.argv[2])
NEHALEM = ["qemu-x86_64", "-cpu", "Nehalem"]
DURATIONS = {"cable": 0.002, "rope": 0.1, "beam": 0.1, "falling_chain": 0.1, "throw": 0.1}  # s; others: 0.5


def trajectory(scene, csv, *options, emulator=(), plain=""):
    """The bytes of the CSV that simulate writes."""
    subprocess.run([*emulator, SIMULATE, scene, "--duration", str(DURATIONS.get(scene.stem, 0.5)), "--csv", csv, *options],
                   check=True, stdout=subprocess.DEVNULL, env={**os.environ, "PLANAR_CHAIN_PLAIN_KERNEL": plain})
    return pathlib.Path(csv).read_bytes()


def main():
    wrong = 0
    with tempfile.TemporaryDirectory() as folder:
        csv = f"{folder}/run.csv"
        for scene in sorted(SCENES.glob("*.yaml")):
            for options in ((), ("--method", "radau13")) if scene.stem in ("triple", "driven") else ((),):
                here = trajectory(scene, csv, *options, plain="1")
                there = trajectory(scene, csv, *options, emulator=NEHALEM)
                is_same = here == there and len(here) > 500
                wrong += not is_same
                print(scene.stem, *options, f"{len(here)} bytes", "the same" if is_same else "DIFFERENT")

        # The scene's own key asks for the same kernel: for the motion, and for the start that closes a loop.
        for name in ("whip", "four_bar"):
            scene = SCENES / f"{name}.yaml"
            by_key = pathlib.Path(f"{folder}/{name}.yaml")
            by_key.write_text(scene.read_text().replace("integrator:", "integrator:\n  plain_kernel: true"))
            is_same = trajectory(by_key, csv) == trajectory(scene, csv, plain="1")
            wrong += not is_same
            print(name, "by its key", "the same" if is_same else "DIFFERENT")
    sys.exit(wrong != 0)


main()
