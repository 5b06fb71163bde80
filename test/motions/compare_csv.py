#!/usr/bin/python3
"""How far apart two motions end: compare_csv.py A.csv B.csv

It compares the last rows of two files that `simulate --csv` wrote; or B is a list of theta_i and omega_i, as reference/beam.csv.
It prints the largest difference of an absolute angle and of an absolute rate, and the largest of either in B.
"""
import csv
import itertools
import sys


def absolute(path):
    with open(path, newline="") as file:
        rows = list(csv.reader(file))
    if rows[0] == ["component", "value"]:
        return [[float(value) for name, value in rows[1:] if name.startswith(kind)] for kind in ("theta_", "omega_")]
    last = dict(zip(rows[0], rows[-1]))
    return [list(itertools.accumulate(float(value) for name, value in last.items() if name.startswith(kind)))
            for kind in ("q_", "qd_")]


def compare(ours, theirs):
    """(largest difference, largest of theirs): of the angles, rad, and of the rates, rad/s"""
    return [(max(abs(a - b) for a, b in zip(*pair)), max(map(abs, pair[1])))
            for pair in zip(absolute(ours), absolute(theirs))]


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    for name, (apart, largest) in zip(("angles, rad", "rates, rad/s"), compare(*sys.argv[1:])):
        print(f"{name}: {apart:.3g} apart, of {largest:.3g}")
