#!/usr/bin/python3
"""Simulates a scene many times with varied values, on all cores or on the workers of a Dask scheduler.

An interrupted sweep goes on where it was when the same command is given again. A run that fails is kept, with its
reason. Exit status: 0 done; 1 the sweep failed; 2 bad arguments or scene; 130 interrupted."""

import argparse
import csv
import os
import sys

import numpy as np

from planar_chain import Refused, Scene
from planar_chain.sweeps import BadSweep, Sweep, run_here, run_there, table_of


def varied_from(text):
    path, equals, values = text.partition("=")
    if not equals:
        raise BadSweep(f"--vary: expected PATH=VALUES, got {text!r}")
    return path, values


def write_csv(sweep, path):
    """One row for each run and instant."""
    joints = sweep.scene.joints
    with open(path, "w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(["run", *sweep.paths, "t", *("q_" + j for j in joints), *("qd_" + j for j in joints), "reason"])
        for start, states, _, reasons in sweep.chunks():
            for k, motion in enumerate(states):
                values = [f"{value:.17g}" for value in sweep.values[start + k]]
                for t, state in zip(sweep.times, motion):
                    rows.writerow([start + k, *values, f"{t:.17g}", *(f"{x:.17g}" for x in state), reasons.get(k, "")])


def write_npz(sweep, path):
    starts, states, done, reasons = zip(*sweep.chunks())
    failed = {start + run: text for start, each in zip(starts, reasons) for run, text in each.items()}
    np.savez(path, paths=sweep.paths, values=sweep.values, times=sweep.times, joints=sweep.scene.joints,
             states=np.concatenate(states), done=np.concatenate(done),
             reasons=[failed.get(run, "") for run in range(len(sweep.values))])


WRITERS = {".csv": write_csv, ".npz": write_npz}


def show_progress(ended, runs):
    if sys.stderr.isatty():
        bar = "#" * (40 * ended // runs)
        sys.stderr.write(f"\r[{bar:.<40}] {ended} of {runs} runs\033[K" if ended < runs else "\r\033[K")
        sys.stderr.flush()


def arguments():
    parser = argparse.ArgumentParser(prog="sweep", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", metavar="SCENE", help="a YAML file, or the name of a scene that ships")
    parser.add_argument("--vary", action="append", default=[], metavar="PATH=VALUES",
                        help="a number of the scene, such as links/lower/mass, and its values: FIRST:LAST:COUNT; A,B,…; "
                             "normal(MEAN,DEVIATION); uniform(LOW,HIGH)")
    parser.add_argument("--runs", type=int, help="number of runs (default: each point of the grid once)")
    parser.add_argument("--seed", type=int, default=0, help="of random values (default 0)")
    parser.add_argument("--duration", type=float, required=True, help="simulated time of each run, s")
    parser.add_argument("--instants", type=int, default=1, metavar="K",
                        help="states kept of each run, in equal steps up to the duration (default 1: the end)")
    parser.add_argument("--output", nargs="+", required=True, metavar="FILE", help="a .csv, an .npz, or both")
    parser.add_argument("--overwrite", action="store_true", help="replace files that are complete")
    parser.add_argument("--chunk", type=int, default=500, metavar="RUNS",
                        help="runs that are computed, and kept on disk, together (default 500)")
    parser.add_argument("--scheduler", metavar="ADDRESS",
                        help="of a Dask scheduler, such as tcp://host:8786; its workers need planar_chain")
    return parser.parse_args()


def sweep_from(given):
    for path in given.output:
        if os.path.splitext(path)[1] not in WRITERS:
            raise BadSweep(f"--output: expected names that end in .csv or .npz, got {path}")
    for name, fits, expected in (("runs", given.runs is None or given.runs > 0, "a number > 0"),
                                 ("seed", given.seed >= 0, "a number >= 0"), ("instants", given.instants > 0, "a number > 0"),
                                 ("chunk", given.chunk > 0, "a number > 0"),
                                 ("duration", 0 < given.duration < float("inf"), "a number > 0, in s")):
        if not fits:
            raise BadSweep(f"--{name}: expected {expected}, got {getattr(given, name)}")
    if not given.vary:
        raise BadSweep("--vary: expected at least one, got none")
    parts = given.output[0] + ".parts"
    for path in given.output:
        if os.path.exists(path) and not os.path.exists(parts) and not given.overwrite:
            raise BadSweep(f"--output: expected a new file, got {path}, which is complete (--overwrite replaces it)")
    paths, values = table_of([varied_from(text) for text in given.vary], given.runs, given.seed)
    times = given.duration * np.arange(1, given.instants + 1) / given.instants
    return Sweep(Scene.from_file(given.scene), paths, values, times.tolist(), parts, given.chunk)


def main():
    given = arguments()
    try:
        sweep = sweep_from(given)
    except (BadSweep, Refused, OSError) as problem:
        print(f"sweep: {problem}", file=sys.stderr)
        return 2
    runs = len(sweep.values)
    ended = runs - sum(len(sweep.arguments(start)[2]) for start in sweep.missing())
    try:
        for more in run_there(sweep, given.scheduler) if given.scheduler else run_here(sweep):
            ended += more
            show_progress(ended, runs)
        for path in given.output:
            WRITERS[os.path.splitext(path)[1]](sweep, path)
    except KeyboardInterrupt:
        print(f"\nsweep: interrupted after {ended} of {runs} runs; the same command goes on from there", file=sys.stderr)
        return 130
    except (ImportError, OSError, RuntimeError) as problem:
        print(f"\nsweep: {problem}", file=sys.stderr)
        return 1
    failed = [text for *_, reasons in sweep.chunks() for text in reasons.values()]
    print(f"{runs} runs written to {' and '.join(given.output)}" +
          (f"; {len(failed)} failed, the first: {failed[0]}" if failed else ""))
    sweep.forget()
    return 0


if __name__ == "__main__":
    sys.exit(main())
