"""Many runs of a scene with varied values, in chunks that are kept on disk as they end. The tool `sweep` is its face."""

import asyncio
import atexit
import concurrent.futures
import contextlib
import fcntl
import hashlib
import io
import json
import math
import os
import re
import shutil
import struct
import sys
import threading
import time
import warnings
import zipfile

import numpy as np

from planar_chain import Scene, simulate_many
from planar_chain.user_input import read_number, require_moving


LONGEST_WAIT = 20  # s, for a scheduler, and for its first worker


class BadSweep(ValueError):
    """Where a fault is, what was expected, what was found."""


class SweepFailed(RuntimeError):
    """Why a sweep ended early. What it computed is kept."""


class Damaged(SweepFailed):
    """Which file of a chunk cannot be used, and why: it is damaged, or holds other runs."""


# ---- What varies -------------------------------------------------------------------------------

NUMBER = r"\s*([^,:()]+?)\s*"
MOST_RUNS = 10 ** 8
KINDS = {  # how a value is written; what it means
    "grid": re.compile(f"{NUMBER}:{NUMBER}:{NUMBER}"),
    "normal": re.compile(rf"normal\({NUMBER},{NUMBER}\)"),
    "uniform": re.compile(rf"uniform\({NUMBER},{NUMBER}\)"),
    "list": re.compile(r"(.+)"),
}


IS_SOUND = {  # whether finite numbers of a kind have a meaning
    "grid": lambda first, last, count: (1 if first == last else 2) <= count <= MOST_RUNS and count == int(count)
            and math.isfinite(last - first),
    "normal": lambda mean, deviation: deviation >= 0,
    "uniform": lambda low, high: low <= high and math.isfinite(high - low),
    "list": lambda *numbers: True,
}


def column_of(text):
    """The kind and the numbers of `--vary PATH=text`."""
    for kind, pattern in KINDS.items():
        match = pattern.fullmatch(text.strip())
        if not match:
            continue
        try:
            numbers = [read_number(part) for group in match.groups() for part in group.split(",")]
        except ValueError:
            break
        if not all(map(math.isfinite, numbers)) or not IS_SOUND[kind](*numbers):
            break
        if kind == "grid":
            return "list", np.linspace(numbers[0], numbers[1], int(numbers[2])).tolist()
        return kind, numbers
    points = re.sub(r"(\d),(\d)", r"\1.\2", text)
    note = " (a decimal point, not a comma?)" * (points != text and is_column(points))
    raise BadSweep("--vary: expected FIRST:LAST:COUNT, A,B,…, normal(MEAN,DEVIATION) or uniform(LOW,HIGH) of finite numbers, "
                   f"COUNT >= 2, DEVIATION >= 0, LOW <= HIGH, got {text!r}{note}")


def is_column(text):
    try:
        return bool(column_of(text))
    except BadSweep:
        return False


def table_of(varied, runs, seed):
    """varied: (path, text) for each column. runs: None for one run for each point of the grid.

    Returns paths and values, runs × columns. Run r has point r of the grid, the first path slowest, and begins again
    after the last point. Each random column has a stream of its own."""
    paths = [path for path, _ in varied]
    for path in paths:
        if paths.count(path) > 1:
            raise BadSweep(f"--vary: expected each path once, got {path} {paths.count(path)} times")
        require_moving(path, BadSweep)
    columns = [column_of(text) for _, text in varied]
    points = math.prod(len(numbers) for kind, numbers in columns if kind == "list")
    runs = points if runs is None else runs
    if not points <= runs <= MOST_RUNS:
        raise BadSweep(f"--runs: expected a number from {points}, the points of the grid, to {MOST_RUNS}, got {runs}")
    values, inner = np.empty((runs, len(columns))), points
    for k, (kind, numbers) in enumerate(columns):
        if kind == "list":
            inner //= len(numbers)
            values[:, k] = np.array(numbers)[np.arange(runs) // inner % len(numbers)]
        else:
            values[:, k] = getattr(np.random.default_rng([seed, k]), kind)(*numbers, size=runs)
    return paths, values


# ---- Files -------------------------------------------------------------------------------------


def partial_of(path):
    """Beside the file that a link leads to."""
    return os.path.realpath(path) + ".partial"


@contextlib.contextmanager
def whole(path):
    """A binary file that is there when it is complete, and not before."""
    partial = partial_of(path)
    try:
        with open(partial, "wb") as file:
            yield file
        os.replace(partial, os.path.realpath(path))
    except BaseException as problem:
        with contextlib.suppress(OSError):
            os.remove(partial)
        if isinstance(problem, OSError):
            raise SweepFailed(f"cannot write {path}: {problem.strerror}") from problem
        raise


def save_npz(path, **arrays):
    packed = io.BytesIO()  # on a full disk, a ZipFile fails again when it is collected
    np.savez(packed, **arrays)
    with whole(path) as file:
        file.write(packed.getbuffer())


# ---- Runs --------------------------------------------------------------------------------------


def run_chunk(scene, paths, values, times, threads=1):
    """Returns states, done, reasons and notes. scene: a dict. It runs where the work is done, perhaps on another machine."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # notes on the scene came when it was read; those of runs are returned
        runs = simulate_many(Scene(scene), times, parameters=dict(zip(paths, np.transpose(values))), threads=threads)
    return np.array(runs.states), runs.done, runs.reasons, runs.notes


class Sweep:
    """All runs of a sweep, and those that have ended, in a folder of its own that no other sweep may use meanwhile."""

    def __init__(self, scene, paths, values, times, outputs, chunk=500, overwrite=False):
        self.scene, self.paths, self.values, self.times, self.outputs = scene, paths, values, times, outputs
        self.folder = os.path.realpath(outputs[0]) + ".parts"  # one, by whatever name the output is given
        self.chunk = chunk  # runs
        self.starts = range(0, len(values), chunk)
        run_chunk(scene.to_dict(), paths, values[:1], [])  # refuses paths that lead nowhere
        self._lock = self._locked()
        self._taken = []  # files
        atexit.register(self._release)
        self._enter(overwrite)
        self._require_sound_chunks()

    def _locked(self):
        """The lock of the folder. It ends with the process."""
        for path in self.outputs:
            if os.path.realpath(path).startswith(self.folder + os.sep):
                raise BadSweep(f"--output: expected a file outside of {self.folder}, which is removed at the end, got {path}")
        for name in os.listdir(self.folder) if os.path.isdir(self.folder) else []:
            if not re.fullmatch(r"lock|(sweep\.json|\d{9}\.npz)(\.partial)?", name):
                raise BadSweep(f"--output: expected {self.folder} to be a sweep's own folder, got {name} in it")
        try:
            os.makedirs(self.folder, exist_ok=True)
        except FileExistsError:
            raise BadSweep(f"--output: expected {self.folder} to be a sweep's own folder, got a file") from None
        name = os.path.join(self.folder, "lock")
        lock = open(name, "a", encoding="utf-8")  # pylint: disable=consider-using-with
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if os.path.exists(name):  # else another sweep has just ended
                return lock
        except BlockingIOError:
            pass
        lock.close()
        raise BadSweep(f"--output: expected a file that no other sweep writes, got {self.outputs[0]}")

    def _enter(self, overwrite):
        """Takes up the results of an interrupted sweep if it is the same sweep."""
        about = {"scene": self.scene.to_dict(), "paths": self.paths, "times": list(self.times), "chunk": self.chunk,
                 "runs": len(self.values), "values": hashlib.sha256(self.values.tobytes()).hexdigest(),
                 "plain_kernel": os.environ.get("PLANAR_CHAIN_PLAIN_KERNEL") == "1"}
        self._mark = hashlib.sha256(json.dumps(about, sort_keys=True).encode()).hexdigest()[:16]
        name = os.path.join(self.folder, "sweep.json")
        known, is_new = set(), not os.path.exists(name)
        if not is_new:
            try:
                with open(name, encoding="utf-8") as file:
                    kept = json.load(file)
                others = [key for key in about if kept.get(key) != about[key]]
                known.update(map(os.fspath, kept.get("outputs", ())))
            except (ValueError, AttributeError, TypeError, RecursionError):
                raise BadSweep(f"{name}: expected the description of a sweep, got a damaged file; remove the folder") from None
            if others:
                raise BadSweep(f"{self.folder}: expected the chunks of this sweep, got those of another, which differs in its "
                               f"{', '.join(others)}. Remove that folder, or give its command again")
        try:
            for path in self.outputs:
                self._take(path, os.path.realpath(path) in known, overwrite)
        except BadSweep:
            if is_new:
                self.forget()
            raise
        about["outputs"] = sorted(known.union(map(os.path.realpath, self.outputs)))
        if is_new or len(about["outputs"]) > len(known):
            with whole(name) as file:
                file.write(json.dumps(about).encode())

    def _holds(self, start):
        """The identity of a chunk, which its file states, so that none stands for another."""
        return f"runs {start} to {min(start + self.chunk, len(self.values)) - 1} of the sweep {self._mark}"

    def _take(self, path, is_own, overwrite):
        """Takes an output by its partial file, which keeps other sweeps off until this one ends."""
        try:
            taken = open(partial_of(path), "ab")  # pylint: disable=consider-using-with
            fcntl.flock(taken, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if taken.tell() > 0 and not is_own:  # an empty one is what a killed sweep left
                raise FileExistsError
            self._taken.append(taken)
        except (BlockingIOError, FileExistsError):
            raise BadSweep(f"--output: expected no file {partial_of(path)}, which a sweep of {path} has while it runs, got one") from None
        if os.path.exists(path) and not is_own and not overwrite:
            raise BadSweep(f"--output: expected a new file, got {path}, which is complete (--overwrite replaces it)")

    def _release(self):
        for file in self._taken:
            with contextlib.suppress(FileNotFoundError):  # it has become the output
                os.remove(file.name)

    def _path(self, start):
        return os.path.join(self.folder, f"{start:09d}.npz")

    def missing(self):
        return [start for start in self.starts if not os.path.exists(self._path(start))]

    def arguments(self, start):
        return self.scene.to_dict(), self.paths, self.values[start:start + self.chunk], self.times

    def keep(self, start, result):
        states, done, *words = result
        reasons, notes = (json.dumps({int(k): text for k, text in of_runs.items()}) for of_runs in words)
        save_npz(self._path(start), holds=self._holds(start), states=states, done=done, reasons=reasons, notes=notes)

    def _chunk(self, start):
        """start, states, done, reasons, notes. Raises Damaged."""
        def damaged(why):
            return Damaged(f"{self._path(start)}: damaged ({why})")

        try:
            with np.load(self._path(start)) as kept:
                holds = str(kept["holds"]) if "holds" in kept else "one of an older version, which does not say its runs"
                reasons, notes = ({int(k): text for k, text in json.loads(str(kept[name])).items()} for name in ("reasons", "notes"))
                states, done = kept["states"], kept["done"]
        except (ValueError, LookupError, AttributeError, EOFError, MemoryError, NotImplementedError, SyntaxError, struct.error,
                zipfile.BadZipFile, RecursionError) as problem:
            raise damaged(" ".join(str(problem).split()) or type(problem).__name__) from None
        if holds != self._holds(start):
            raise Damaged(f"{self._path(start)}: expected {self._holds(start)}, got {holds}")
        runs = len(self.values[start:start + self.chunk])
        for name, array, kind, shape in (("states", states, float, (runs, len(self.times), 2 * len(self.scene))),
                                         ("done", done, bool, (runs,))):
            if array.shape != shape:
                raise damaged(f"{name} of {' x '.join(map(str, array.shape))}, not {' x '.join(map(str, shape))}")
            if array.dtype != kind:
                raise damaged(f"{name} of {array.dtype}, not {np.dtype(kind)}")
        if not all(0 <= k < runs and isinstance(text, str) for k, text in [*reasons.items(), *notes.items()]):
            raise damaged("reasons or notes that are not a text for a run")
        return start, states, done, reasons, notes

    def _require_sound_chunks(self):
        damaged = []
        for start in self.starts:
            try:
                if os.path.exists(self._path(start)):
                    self._chunk(start)
            except Damaged as problem:
                damaged.append(f"\n{problem}")
        if damaged:
            raise SweepFailed("expected the chunks of this sweep, got other or damaged files; remove them:" + "".join(damaged))

    def chunks(self):
        """start, states, done, reasons, notes of each, in order."""
        return map(self._chunk, self.starts)

    def forget(self):
        for start in set(self.starts).difference(self.missing()):
            os.remove(self._path(start))  # before its description: else, if this is killed, another sweep would take it
        shutil.rmtree(self.folder)


def run_here(sweep):
    """Runs a sweep on all cores. Yields the number of runs after each chunk."""
    for start in sweep.missing():
        values = sweep.arguments(start)
        sweep.keep(start, run_chunk(*values, threads=0))
        yield len(values[2])


def run_there(sweep, address):
    """Runs a sweep on the workers of a Dask scheduler, which gives the work of one that dies to others. Yields as run_here()."""
    for start, result in results_there(sweep, address):
        sweep.keep(start, result)
        yield len(result[1])


def wait_for_workers(client, address):
    if client.scheduler_info()["workers"]:
        return
    print(f"sweep: the scheduler {address} has no workers; waiting {LONGEST_WAIT} s for one", file=sys.stderr)
    end = time.monotonic() + LONGEST_WAIT
    while not client.scheduler_info()["workers"]:
        if time.monotonic() > end:
            raise SweepFailed(f"the scheduler {address} has had no workers for {LONGEST_WAIT} s; start one with: dask-worker {address}")
        time.sleep(0.2)


def results_there(sweep, address):
    try:
        from distributed import Client, as_completed  # pylint: disable=import-outside-toplevel
    except ImportError as missing:
        raise SweepFailed(f"--scheduler needs Dask (Debian: python3-distributed): {missing}") from missing
    note = threading.Timer(1, print, [f"sweep: the scheduler {address} does not answer; waiting {LONGEST_WAIT} s for it"], {"file": sys.stderr})
    note.daemon = True
    note.start()
    try:
        with Client(address, timeout=LONGEST_WAIT) as client:
            note.cancel()
            wait_for_workers(client, address)
            starts = {client.submit(run_chunk, *sweep.arguments(start), retries=3): start for start in sweep.missing()}
            completed = as_completed(list(starts))
            for future in completed:
                if future.status in ("lost", "pending"):  # its worker died before it was fetched; another one computes it
                    completed.add(future)
                    continue
                if future.status == "cancelled":  # lost with its scheduler: Dask raises None then, a TypeError
                    raise concurrent.futures.CancelledError
                result = future.result()
                yield starts.pop(future), result
                future.release()
    except SweepFailed:
        raise
    except (asyncio.CancelledError, concurrent.futures.CancelledError, OSError) as problem:  # Dask's own are OSErrors
        raise SweepFailed(f"the scheduler {address} does not answer") from problem
    except Exception as problem:  # pylint: disable=broad-except
        raise SweepFailed(" ".join(f"scheduler {address}: {type(problem).__name__}: {problem}".split())) from problem
    finally:
        note.cancel()
