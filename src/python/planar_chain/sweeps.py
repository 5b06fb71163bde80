"""Many runs of a scene with varied values, in chunks that are kept on disk as they end. The tool `sweep` is its face."""

import hashlib
import json
import math
import os
import re
import shutil

import numpy as np

from planar_chain import Scene, simulate_many


class BadSweep(ValueError):
    """Where a fault is, what was expected, what was found."""


# ---- What varies -------------------------------------------------------------------------------

NUMBER = r"\s*([^,:()]+?)\s*"
KINDS = {  # how a value is written; what it means
    "grid": re.compile(f"{NUMBER}:{NUMBER}:{NUMBER}"),
    "normal": re.compile(rf"normal\({NUMBER},{NUMBER}\)"),
    "uniform": re.compile(rf"uniform\({NUMBER},{NUMBER}\)"),
    "list": re.compile(r"(.+)"),
}


def column_of(text):
    """The kind and the numbers of `--vary PATH=text`."""
    for kind, pattern in KINDS.items():
        match = pattern.fullmatch(text.strip())
        if not match:
            continue
        try:
            numbers = [float(part) for group in match.groups() for part in group.split(",")]
        except ValueError:
            break
        if kind == "grid":
            if numbers[2] < 1 or numbers[2] != int(numbers[2]):
                break
            numbers = np.linspace(numbers[0], numbers[1], int(numbers[2])).tolist()
        elif kind == "normal" and numbers[1] < 0:
            break
        if all(map(math.isfinite, numbers)):
            return "list" if kind == "grid" else kind, numbers
        break
    raise BadSweep(f"--vary: expected FIRST:LAST:COUNT, A,B,…, normal(MEAN,DEVIATION) or uniform(LOW,HIGH), got {text!r}")


def table_of(varied, runs, seed):
    """varied: (path, text) for each column. runs: None for one run for each point of the grid.

    Returns paths and values, runs × columns. Run r has point r of the grid, the first path slowest, and begins again
    after the last point. Each random column has a stream of its own."""
    columns = [column_of(text) for _, text in varied]
    points = math.prod(len(numbers) for kind, numbers in columns if kind == "list")
    runs = points if runs is None else runs
    values, inner = np.empty((runs, len(columns))), points
    for k, (kind, numbers) in enumerate(columns):
        if kind == "list":
            inner //= len(numbers)
            values[:, k] = np.array(numbers)[np.arange(runs) // inner % len(numbers)]
        else:
            values[:, k] = getattr(np.random.default_rng([seed, k]), kind)(*numbers, size=runs)
    return [path for path, _ in varied], values


# ---- Runs --------------------------------------------------------------------------------------


def run_chunk(scene, paths, values, times, threads=1):
    """Returns states, done and reasons. scene: a dict. It runs where the work is done, perhaps on another machine."""
    runs = simulate_many(Scene(scene), times, parameters=dict(zip(paths, np.transpose(values))), threads=threads)
    return np.array(runs.states), runs.done, runs.reasons


class Sweep:
    """All runs of a sweep, and those that have ended, in a folder of its own."""

    def __init__(self, scene, paths, values, times, folder, chunk=500):
        self.scene, self.paths, self.values, self.times, self.folder = scene, paths, values, times, folder
        self.chunk = chunk  # runs
        self.starts = range(0, len(values), chunk)
        simulate_many(scene, [], parameters=dict(zip(paths, values[:1].T)))  # refuses paths that lead nowhere
        self._enter()

    def _enter(self):
        """What an interrupted sweep left behind is taken up if it is the same sweep."""
        about = {"scene": self.scene.to_dict(), "paths": self.paths, "times": list(self.times), "chunk": self.chunk,
                 "runs": len(self.values), "values": hashlib.sha256(self.values.tobytes()).hexdigest()}
        name = os.path.join(self.folder, "sweep.json")
        if os.path.exists(name):
            with open(name, encoding="utf-8") as file:
                if json.load(file) != about:
                    raise BadSweep(f"{self.folder}: expected the chunks of this sweep, got those of another")
            return
        os.makedirs(self.folder, exist_ok=True)
        with open(name, "w", encoding="utf-8") as file:
            json.dump(about, file)

    def _path(self, start):
        return os.path.join(self.folder, f"{start:09d}.npz")

    def missing(self):
        return [start for start in self.starts if not os.path.exists(self._path(start))]

    def arguments(self, start):
        return self.scene.to_dict(), self.paths, self.values[start:start + self.chunk], self.times

    def keep(self, start, result):
        states, done, reasons = result
        partial = self._path(start) + ".partial"
        with open(partial, "wb") as file:
            np.savez(file, states=states, done=done, reasons=json.dumps({int(k): text for k, text in reasons.items()}))
        os.replace(partial, self._path(start))

    def chunks(self):
        """start, states, done, reasons of each, in order."""
        for start in self.starts:
            with np.load(self._path(start)) as kept:
                reasons = {int(k): text for k, text in json.loads(str(kept["reasons"])).items()}
                yield start, kept["states"], kept["done"], reasons

    def forget(self):
        shutil.rmtree(self.folder)


def run_here(sweep):
    """On all cores. Yields the number of runs after each chunk."""
    for start in sweep.missing():
        values = sweep.arguments(start)
        sweep.keep(start, run_chunk(*values, threads=0))
        yield len(values[2])


def run_there(sweep, address):
    """On the workers of a Dask scheduler, which gives the work of one that dies to others. Yields as run_here()."""
    from distributed import Client, as_completed  # pylint: disable=import-outside-toplevel
    with Client(address) as client:
        starts = {client.submit(run_chunk, *sweep.arguments(start), retries=3): start for start in sweep.missing()}
        for future, result in as_completed(list(starts), with_results=True):
            start = starts.pop(future)
            sweep.keep(start, result)
            future.release()
            yield len(result[1])
