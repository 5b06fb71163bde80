#!/usr/bin/python3
"""Simulates a scene many times with varied values, on all cores or on the workers of a Dask scheduler.

Called again, it continues an interrupted sweep. A run that fails is kept, with its reason. Exit status: 0 done;
1 every run or the sweep failed; 2 bad arguments or scene; 3 some runs failed; 130 interrupted."""

from program import Parser, put, run, say  # isort: skip

import argparse
import csv
import io
import logging
import os
import re
import sys

from chain import scene_from
from files import BadOutput, require_outputs, scene_file, words_of
try:
    import numpy as np

    from planar_chain import Refused
    from planar_chain.sweeps import BadSweep, Sweep, SweepFailed, run_here, run_there, save_npz, table_of, whole
except ImportError as missing:
    sys.exit(f"sweep: {missing}")


def varied_from(text):
    path, equals, values = text.partition("=")
    if not equals or not path:
        raise BadSweep(f"--vary: expected PATH=VALUES, got {text!r}")
    return path, values


def write_csv(sweep, path):
    """One row for each run and instant."""
    joints = sweep.scene.joints
    with whole(path) as binary, io.TextIOWrapper(binary, encoding="utf-8", newline="") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(["run", *sweep.paths, "t", *("q_" + j for j in joints), *("qd_" + j for j in joints), "reason"])
        for start, states, _, reasons, _ in sweep.chunks():
            for k, motion in enumerate(states):
                values = [f"{value:.17g}" for value in sweep.values[start + k]]
                for t, state in zip(sweep.times, motion):
                    rows.writerow([start + k, *values, f"{t:.17g}", *(f"{x:.17g}" for x in state), reasons.get(k, "")])


def write_npz(sweep, path):
    starts, states, done, reasons, notes = zip(*sweep.chunks())

    def texts(chunks):
        said = {start + run: text for start, each in zip(starts, chunks) for run, text in each.items()}
        return [said.get(run, "") for run in range(len(sweep.values))]
    save_npz(path, paths=sweep.paths, values=sweep.values, times=sweep.times, joints=sweep.scene.joints,
             states=np.concatenate(states), done=np.concatenate(done), reasons=texts(reasons), notes=texts(notes))


MOST_NUMBERS = 10 ** 8  # in memory at once
WRITERS = {".csv": write_csv, ".npz": write_npz}


PROGRESS = []  # the runs that have ended and all


def so_far():
    return f" (after {PROGRESS[0]} of {PROGRESS[1]} runs; the same command goes on from there)" if PROGRESS else ""


def show_progress(ended, runs):
    if sys.stderr.isatty():
        bar = "#" * (40 * ended // runs)
        sys.stderr.write(f"\r[{bar:.<40}] {ended} of {runs} runs\033[K" if ended < runs else "\r\033[K")
        sys.stderr.flush()


def arguments():
    parser = Parser(prog="sweep", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", metavar="SCENE", help="a YAML file, a URDF, or the name of a scene that ships")
    parser.add_argument("--vary", action="append", default=[], metavar="PATH=VALUES",
                        help="a number of the scene, such as links/lower/mass, and its values: FIRST:LAST:COUNT; A,B,…; "
                             "normal(MEAN,DEVIATION); uniform(LOW,HIGH)")
    parser.add_argument("--runs", type=int, help="number of runs (default: each point of the grid once)")
    parser.add_argument("--seed", type=int, default=0, help="of random values (default 0)")
    parser.add_argument("--duration", type=float, required=True, help="simulated time of each run, s")
    parser.add_argument("--instants", type=int, default=1, metavar="K",
                        help="states kept of each run, in equal steps up to the duration (default 1: the end)")
    parser.add_argument("--output", nargs="+", action="extend", required=True, metavar="FILE", help="a .csv, an .npz, or both")
    parser.add_argument("--overwrite", action="store_true", help="replace files that are complete")
    parser.add_argument("--chunk", type=int, default=500, metavar="RUNS",
                        help="runs that are computed, and kept on disk, together (default 500)")
    parser.add_argument("--scheduler", metavar="ADDRESS",
                        help="of a Dask scheduler, such as tcp://host:8786; its workers need planar_chain")
    return parser.parse_args()


def sweep_from(given):
    for path in given.output:
        if os.path.splitext(path)[1] not in WRITERS or os.path.exists(path) and not os.path.isfile(path) and not os.path.isdir(path):
            raise BadSweep(f"--output: expected names of files that end in .csv or .npz, got {path}")
    require_outputs([("--output", path) for path in given.output], [scene_file(given.scene)])
    if given.scheduler is not None and not re.fullmatch(r"([a-z]+://)?[^\s/]+:\d+", given.scheduler):
        raise BadSweep(f"--scheduler: expected an address such as tcp://host:8786, got {given.scheduler!r}")
    for name, fits, expected in (("seed", given.seed >= 0, "a number >= 0"),
                                 ("instants", given.instants > 0, "a number > 0"),
                                 ("chunk", given.chunk > 0, "a number > 0"),
                                 ("duration", 0 < given.duration <= 1e6, "a number > 0, at most 1e6, in s")):
        if not fits:
            raise BadSweep(f"--{name}: expected {expected}, got {getattr(given, name)}")
    if not given.vary:
        raise BadSweep("--vary: expected at least one, got none")
    try:
        scene = scene_from(given.scene, say)
    except OSError as problem:
        raise BadSweep(words_of(problem)) from problem
    paths, values = table_of([varied_from(text) for text in given.vary], given.runs, given.seed)
    kept = given.instants * min(given.chunk, len(values)) * 2 * len(scene)
    if kept > MOST_NUMBERS:
        raise BadSweep(f"--instants, --chunk: expected at most {MOST_NUMBERS} numbers in the states of a chunk, got {kept}")
    times = given.duration * (np.arange(1, given.instants + 1) / given.instants)
    return Sweep(scene, paths, values, times.tolist(), given.output, given.chunk, given.overwrite)


def main():
    given = arguments()
    logging.disable(logging.CRITICAL)  # of Dask: say() tells why a sweep ends
    sweep = sweep_from(given)
    runs = len(sweep.values)
    PROGRESS[:] = len(sweep.values) - sum(len(sweep.arguments(start)[2]) for start in sweep.missing()), runs
    for more in run_there(sweep, given.scheduler) if given.scheduler else run_here(sweep):
        PROGRESS[0] += more
        show_progress(*PROGRESS)
    for path in given.output:
        WRITERS[os.path.splitext(path)[1]](sweep, path)
    failed, noted = [], []
    for start, *_, reasons, notes in sweep.chunks():
        failed += reasons.values()
        noted += [f"run {start + k}: {text}" for k, text in notes.items()]
    sweep.forget()
    PROGRESS.clear()
    if noted:
        say(f"note: {len(noted)} of {runs} runs have notes; of {noted[0]}")
    told = f"{runs} runs written to {' and '.join(given.output)}"
    if failed:
        say(f"{told}; {len(failed)} failed, the first: {failed[0]}")
        return 1 if len(failed) == runs else 3
    put(told + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(run(main, (BadOutput, BadSweep, Refused), (SweepFailed,), so_far))
