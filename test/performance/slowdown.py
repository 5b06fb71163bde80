#!/usr/bin/python3
"""How much slower the second of two builds is: slowdown.py ROUNDS "COMMAND" "COMMAND"

Each command runs the test program `instructions` of one build, such as "chroot FOLDER /planar_chain/build/test/instructions".
They take turns. Shows, of the rounds, the median time of the first and the median ratio within a round."""
import csv
import shlex
import statistics
import subprocess
import sys


def times(command):
    """The build, and nanoseconds by (operation, chain, links)."""
    said = subprocess.run([*shlex.split(command), "time"], stdout=subprocess.PIPE, universal_newlines=True, check=True).stdout
    build, *lines = said.splitlines()
    return build, {tuple(key): float(time) for *key, time in csv.reader(lines)}


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    first, second = [], []
    for k in range(int(sys.argv[1])):
        turns = [(sys.argv[2], first), (sys.argv[3], second)]
        for command, found in turns if k % 2 == 0 else reversed(turns):
            build, one = times(command)
            found.append(one)
            if k == 0:
                print(build)
    for key in first[0]:
        ratio = statistics.median(b[key] / a[key] for a, b in zip(first, second))
        print("{:16} {:20} {:>5}".format(*key), f"{statistics.median(a[key] for a in first):11.1f} ns {ratio:6.3f}")


main()
