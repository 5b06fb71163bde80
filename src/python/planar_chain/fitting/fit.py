"""fit(): from recordings to the numbers of a scene. The tool `fit` is its face."""

import copy
import math
import os
import warnings

import numpy as np

from planar_chain import Refused, Scene

from .diagnosis import TRIAL, badness, mistakes, sparse
from .bags import read_bag
from .deviations import Deviations
from .hints import hints
from .varied import AT_BOUND, numbers_of, scene_with
from .problem import EXACT, Problem, drive_of, joint_links
from .recordings import (LEAST_SAMPLES, BadFit, Recording, from_arrays, is_number, long_enough, moved_loads, read_csv, require_angles,
                         require_motion, require_radians, require_samples)
from .report import as_text
from .solve import LAST_PRIOR, WINDOWS, Solver, first_state, samples_of
from .unread import ENDINGS
from .words import not_told

LOST = 0.9  # of a recording: if less of it is followed, a warning says so


class Found:
    """A number after a fit: path, value, deviation, first, low, high; at_bound: "low", "high" or ""."""

    def __init__(self, number, value, deviation):
        self.path, self.first, self.low, self.high = number.path, number.first, number.low, number.high
        self.value, self.deviation = float(value), float(deviation)
        near = [name for name in ("low", "high") if abs(value - getattr(number, name)) <= AT_BOUND * number.scale]
        self.at_bound = near[0] if near else ""

    def __repr__(self):
        return f"<{self.path}: {self.value:.6g} ± {self.deviation:.2g}{', at its bound' if self.at_bound else ''}>"


class Prediction:
    """How well the fitted numbers predict a recording: root mean square errors of each joint, rad or m, from the first sample; with the
    initial state fitted on the first window; and with it fitted on the whole recording."""

    def __init__(self, name, from_first_sample, from_first_window, from_fitted_start):
        self.name, self.from_first_sample = name, from_first_sample
        self.from_first_window, self.from_fitted_start = from_first_window, from_fitted_start

    def __repr__(self):
        return (f"<{self.name}: errors from the first sample {self.from_first_sample}, from the first window {self.from_first_window}, "
                f"from a fitted start {self.from_fitted_start}>")


class Fit:
    """What fit() returns.

    numbers: a list of Found. scene: the Scene with their values. covariance: of the numbers, in their units. correlation_time: how many
    samples of a residual count as one. units: of each joint, rad or m. noise: the deviation of the residuals of each joint, robust.
    errors: for each recording its name and the root mean square residual of each joint until this time, s (until). states, offsets,
    delays: of each recording; None for a delay that it does not determine. not_told, warnings: sentences. open: the paths of the
    numbers that the data do not determine, in so many combinations. predictions: a list of Prediction. converged, interrupted, reason.
    pair: the two numbers that hang together most, or None. bad: why the model does not follow the data, or empty."""

    def __init__(self, scene, problem, solution):
        self.joints = problem.joints
        self.units = ["m" if is_prismatic else "rad" for is_prismatic in scene.prismatic]
        samples = solution.samples
        self.converged, self.interrupted, self.reason = not solution.reason, solution.interrupted, solution.reason
        self.runs, self.evaluations = problem.runs, solution.calls
        exact = Problem(scene, problem.recordings, problem.numbers, problem.has_offsets, problem.has_delay, EXACT)
        deviations = Deviations(exact, solution, samples, LAST_PRIOR)
        many = len(problem.numbers)
        self.numbers = [Found(*one) for one in zip(problem.numbers, deviations.values, deviations.deviations)]
        self.scene = scene_with(scene, problem.numbers, deviations.values)
        self.covariance = deviations.covariance[:many, :many] * np.outer(deviations.scales, deviations.scales)
        self.correlation_time, self.noise, self.pair = deviations.tau, solution.noise, deviations.most_correlated()
        self.not_told = not_told(deviations, scene.to_dict())
        self.open, self.combinations = deviations.open, len(deviations.lost)
        self.recordings, self.angles = problem.recordings, problem.angles(solution.x, samples_of(problem.recordings, np.inf))
        parts = [problem.parts(solution.x, r) for r in range(len(self.recordings))]
        self.states = [problem.states(solution.x, r, [0])[0] for r in range(len(self.recordings))]
        self.offsets = [part[2] for part in parts]
        self.delays = [part[3] if one.shows_delay() or not problem.has_delay else None for part, one in zip(parts, self.recordings)]
        hidden = ", ".join(one.name for one, delay in zip(self.recordings, self.delays) if delay is None)
        self.not_told += [f"the delay of {hidden}, in which no torque or force changes"] * bool(hidden)
        self.errors = [(recording.name, error_of(angles[indices], recording.q[indices])) for recording, angles, indices in
                       zip(self.recordings, self.angles, samples)]
        self.until = [float(recording.t[indices[-1]]) for recording, indices in zip(self.recordings, samples)]
        self.warnings = [f"{found.path} ran to its bound {getattr(found, found.at_bound):g}" for found in self.numbers if found.at_bound]
        self.warnings += beyond(scene, problem.numbers, deviations.values)
        self.bad = badness(self.recordings, self.joints, problem.errors(solution.x, samples), samples)
        if not deviations.are_noise and max(error.max() for _, error in self.errors) > problem.errors_of_runs:
            self.bad = self.bad or sparse(problem, solution)
        if not self.interrupted:
            self.warnings += hints(problem, solution) + lost(self.recordings, samples)
        self.predictions = []

    def __repr__(self):
        return as_text(self)

    def explain(self, scene, problem):
        """Adds to a bad fit the likely mistakes."""
        states = [first_state(one) for one in problem.recordings]

        def error(problem, states):
            return Solver(problem, states, (TRIAL,)).first_error()
        self.warnings = mistakes(error, scene, problem, states) + self.warnings


def beyond(scene, numbers, values):
    """Sentences on numbers that stand where a rule of the scene ends their range."""
    said = []
    for k, number in enumerate(numbers):
        for side in (1, -1):
            moved = np.array(values)
            moved[k] += side * AT_BOUND * number.scale
            if not number.low <= moved[k] <= number.high:
                continue
            try:
                scene_with(scene, numbers, moved)
            except Refused as error:
                said.append(f"{number.path} cannot be {'more' if side > 0 else 'less'} than {values[k]:.6g}: {error}")
    return said


def lost(recordings, samples):
    """A sentence on recordings that could not be followed to their ends, or none."""
    short = [(recording, recording.t[indices[-1]]) for recording, indices in zip(recordings, samples) if len(indices) < LOST * len(recording)]
    which = ", ".join(f"{recording.name} ({end:.3g} of {recording.duration:.3g} s)" for recording, end in short)
    return [f"could only be followed, and fitted, so far: {which}; --pieces {0.7 * min(end for _, end in short):.2g} uses the rest too"
            ] if short else []


def error_of(angles, measured):
    """The root mean square error of each joint. It is infinite where a run failed."""
    error = np.where(np.isfinite(measured), np.nan_to_num(angles, nan=np.inf) - measured, np.nan)
    return np.sqrt(np.nanmean(error ** 2, axis=0))


def is_bag(one):
    return isinstance(one, (str, os.PathLike)) and os.fspath(one).endswith(ENDINGS)


def recordings_of(data, scene, least, effort=False, node=None, many_turns=False, pieces=None):
    """data: a path, a Recording, a dict of arrays, or a list of these. least: s, of a piece of a bag. pieces: s, about how long a piece is;
    None: all is one."""
    values, joints, recordings, arrays = scene.to_dict(), scene.joints, [], {}
    for k, one in enumerate(data if isinstance(data, (list, tuple)) else [data]):
        if isinstance(one, Recording):
            require_samples(one.name, one.t, {"q": one.q} if one.qd is None else {"q": one.q, "qd": one.qd}, joints)
            read = [one]
        elif isinstance(one, dict):
            read = [from_arrays(one, joints, f"recording {k + 1}")]
        elif not isinstance(one, (str, os.PathLike)):
            raise BadFit(f"recording {k + 1}: expected a path, a Recording or a dict of arrays, got {one!r}")
        elif is_bag(one):
            read = read_bag(os.fspath(one), values, joints, effort, node)
        else:
            read = [read_csv(os.fspath(one), joints)]
        if not isinstance(one, (str, os.PathLike)):
            same = arrays.setdefault((read[0].t.tobytes(), read[0].q.tobytes()), k)
            if same < k:
                raise BadFit(f"recording {k + 1}: expected each recording once, got the times and angles of recording {same + 1}")
        if not many_turns and not is_bag(one):  # joint_states are in rad
            for recording in read:
                require_radians(recording, joints, scene.prismatic)
        recordings += read
    recordings = long_enough([recording.without_rest() for recording in recordings], least)
    if pieces is not None:
        recordings = [piece for recording in recordings for piece in recording.pieces(pieces)]
    for recording in recordings:
        require_angles(recording, joints)
    if not recordings:
        raise BadFit("--data: expected at least one recording, got none")
    return recordings


def require_once(data):
    """Twice the same file would count as twice the data."""
    files = [os.path.realpath(one) for one in (data if isinstance(data, (list, tuple)) else [data]) if isinstance(one, (str, os.PathLike))]
    for file in files:
        if files.count(file) > 1:
            raise BadFit(f"--data: expected each recording once, got {file} {files.count(file)} times")


def require_delay(is_fitted, recordings):
    if is_fitted and not any(recording.shows_delay() for recording in recordings):
        raise BadFit("--delay: expected torques or forces that change in a recording, as tau_<joint> of a CSV or commands of a bag, got none")


def require_pieces(seconds):
    if seconds is not None and not (is_number(seconds) and 0 < seconds < math.inf):
        raise BadFit(f"--pieces: expected a time > 0 s, got {seconds!r}")


def windows_of(windows):
    ends = list(windows) if np.iterable(windows) else []
    if not ends or not all(is_number(end) and 0 < end < math.inf for end in ends) or ends != sorted(set(ends)):
        raise BadFit(f"--windows: expected increasing times > 0, in s, got {windows!r}")
    return ends


def require_first_window(recordings, least):
    for recording in recordings:
        if recording.duration < least:
            raise BadFit(f"{recording.name}: expected at least {least:g} s, the first window (--windows), got {recording.duration:g} s")


def fit(scene, recordings, vary, *, predict=(), offsets=False, delay=False, effort=False, node=None, many_turns=False,
        pieces=None, windows=WINDOWS, progress=None):
    """Fits numbers of a scene to recordings of its joints' angles, and returns a Fit.

    scene: a Scene, or what Scene.from_file takes. recordings: paths of CSVs and bags, dicts of arrays (t, q and, if known, qd, tau), or a
    list of these. vary: a list of PATH[=FIRST[:LOW:HIGH]], or a dict from paths to None, FIRST or (FIRST, LOW, HIGH). predict:
    recordings that the fit does not see. offsets: fit an offset of each encoder in each recording. delay: fit the time between torque
    and motion. effort: of a bag, take the effort as the torque that was applied. node: whose topics of a bag. many_turns: angles above
    50 rad are in rad. pieces: s; cuts each recording into equal pieces, about so long. windows: s, growing. progress: called with the end
    of the window (s), the error (rad, m) and the evaluations.

    The initial state of each recording is always fitted. Ctrl-C ends with the best so far (interrupted). Raises BadFit, a ValueError."""
    scene = scene if isinstance(scene, Scene) else Scene.from_file(os.fspath(scene))
    if "chain" not in scene.to_dict():
        raise BadFit("the scene: expected chain and links, got a robot_description: write the robot's links as a scene to fit it")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # notes on the scene came when it was read
        warnings.simplefilter("ignore", RuntimeWarning)  # what numpy says of overflows: the result says that it is bad
        numbers = numbers_of(scene, vary)
        require_pieces(pieces)
        require_once(recordings)
        windows = windows_of(windows)
        data = recordings_of(recordings, scene, windows[0], effort, node, many_turns, pieces)
        unseen = recordings_of(predict, scene, windows[0], effort, node, many_turns, pieces) if predict else []
        require_first_window([*data, *unseen], windows[0])
        values = scene.to_dict()
        require_motion(data, scene.joints, [drive_of(values, link) for link in joint_links(values)])
        require_delay(delay, data)
        problem = Problem(scene, data, numbers, offsets, delay)
        known = sum(int(np.isfinite(recording.q).sum()) for recording in data)
        if known <= problem.size:
            raise BadFit(f"--data: expected more angles than the {problem.size} unknowns, got {known}")
        result = with_rests(solved(scene, problem, windows, progress), scene, problem, windows, progress)
        try:
            if result.bad and not result.interrupted:
                result.explain(scene, Problem(scene, result.recordings, numbers, offsets, delay))
            delays = [one for one in result.delays if one is not None] if delay else []
            later = [delayed(one, float(np.mean(delays)) if delays else 0.0) for one in unseen]
            result.predictions = [] if result.interrupted else [predicted(result.scene, one, offsets, windows[0]) for one in later]
        except KeyboardInterrupt:
            result.interrupted = True
        result.warnings += [one.cut for one in [*data, *unseen] if one.cut]
        return result


def solved(scene, problem, windows, progress):
    """The Fit of a problem; of the best so far after Ctrl-C."""
    solution = Solver(problem, [first_state(one) for one in problem.recordings], windows, progress).run()
    try:
        return Fit(scene, problem, solution)
    except KeyboardInterrupt:
        solution.interrupted, solution.reason = True, "interrupted"
        return Fit(scene, problem, solution)


def with_rests(result, scene, problem, windows, progress):
    """The Fit with the rests before the motions too, where these show what the motions leave open; else the result."""
    rests = [one.rest for one in problem.recordings if one.rest and len(one.rest) >= LEAST_SAMPLES and one.rest.duration >= windows[0]]
    if not rests or not result.open or result.bad or result.interrupted:
        return result
    names, whole = ", ".join(one.name for one in rests), [*problem.recordings, *rests]
    try:
        more = solved(scene, Problem(scene, whole, problem.numbers, problem.has_offsets, problem.has_delay), windows, progress)
    except BadFit:
        return result
    if more.bad and not more.interrupted:
        result.warnings.append(f"{names}: a rest before the motion, left out, as the scene does not follow it")
    elif more.combinations < result.combinations and not more.interrupted:
        shown = [path for path in result.open if path not in more.open] or result.open
        more.warnings.append(f"{names}: a rest before the motion, fitted too, as it alone shows {', '.join(shown)}")
        return more
    result.interrupted = more.interrupted
    return result


def delayed(recording, delay):
    """The recording with what acts in it later by the delay, s."""
    later = copy.copy(recording)
    if recording.shows_delay():
        later.loads = moved_loads(recording.loads, -delay)
    return later


def predicted(scene, recording, offsets, window):
    """What the scene says of a recording. Where offsets are fitted, they are part of the start."""
    problem = Problem(scene, [recording], [], offsets)
    samples, state = samples_of([recording], np.inf), first_state(recording)
    errors = [error_of(problem.angles(problem.first([state]), samples)[0], recording.q)]
    for end in (window, np.inf):
        solution = Solver(problem, [state], (window,)).run(end)
        if solution.interrupted:
            raise KeyboardInterrupt
        errors.append(error_of(problem.angles(solution.x, samples)[0], recording.q))
    return Prediction(recording.name, *errors)
