"""Finds bad fits, and the likely mistake. A fit is bad if its errors are far above what the samples' noise explains, and a sizeable
part of the motion.

A mistake in how the angles count is found by a trial: the first seconds are fitted again, with the angles as they should have been."""

import numpy as np

from .problem import Problem, has_laws
from .recordings import LONG_REST, Recording, noise_of_samples

PART, OF_NOISE = 0.05, 10.0  # errors above this part of a joint's motion, and so many times the noise of its samples, are bad
MOST_MOTION = 1.0  # rad: larger motions, such as turns, do not excuse larger errors
BULK = 0.9  # of the errors: the rest are outliers
HARDLY = 0.1  # a fit that follows less than this part of the samples is bad
TRIAL, BETTER = 0.6, 5.0  # s of a trial; it explains if its error is so many times smaller than that of the angles as they are
SLOW = 1.0  # s between samples: t is not in s
COUNTS = {  # how the angles of a file count, of revolute joints: as they should have been
    "the angle of {first} from hanging, not from +x (subtract π/2)": lambda q, turn: q - turn * np.eye(q.shape[1])[0],
    "the angle of {first} from upright, not from +x (add π/2)": lambda q, turn: q + turn * np.eye(q.shape[1])[0],
    "all angles from +x, not from the link before (take differences)": lambda q, turn: np.diff(q, axis=1, prepend=0.0),
    "all angles from hanging (subtract π/2, and take differences)": lambda q, turn: np.diff(q - turn, axis=1, prepend=0.0),
    "all angles clockwise, or that of {first} from −x (change all signs, or subtract π)": lambda q, turn: -q,
}


def size_of(errors):
    """The deviation of errors without their outliers."""
    known = abs(errors[np.isfinite(errors)])
    return np.quantile(known, BULK) / 1.645 if len(known) else 0.0


def badness(recordings, joints, errors, samples):
    """A sentence on the worst joint of a bad fit, or "". errors: for each recording, times × n, at its samples."""
    if sum(map(len, samples)) < HARDLY * sum(map(len, recordings)):
        return "it follows less than a tenth of the data: the numbers are wrong, and their deviations mean nothing"
    worst = (PART, "")
    for recording, error, indices in zip(recordings, errors, samples):
        for j, joint in enumerate(joints):
            size, noise, q = size_of(np.nan_to_num(error[:, j], posinf=1e3)), noise_of_samples(recording.q[:, j]), recording.q[indices, j]
            part = size / max(min(np.nanstd(q), MOST_MOTION), 1e-9)
            if part > worst[0] and size > OF_NOISE * noise:
                worst = part, (f"the errors of {joint} in {recording.name} are {100 * part:.0f} % of its motion"
                               + (f" and {size / noise:.0f} times the noise of its samples" if size < 1e4 * noise else "")
                               + ": the numbers are wrong, and their deviations mean nothing")
    return worst[1]


def sparse(problem, solution):
    """A sentence on a recording with too few samples, or ""."""
    for r, (recording, indices) in enumerate(zip(problem.recordings, solution.samples)):
        if problem.is_sparse(solution.x, r, indices):
            return (f"{recording.name} has too few samples for its vibrations, and the errors are no noise: other numbers may fit better, "
                    "and the deviations mean nothing")
    return ""


def mistakes(solver, scene, problem, states):
    """Sentences on what was likely done wrong. solver(problem, states, until): the error of a fit of the first seconds, rad."""
    said = []
    for recording in problem.recordings:
        if np.median(np.diff(recording.t)) >= SLOW:
            said.append(f"{recording.name}: its samples are {np.median(np.diff(recording.t)):.3g} s apart: t has to be in s")
        elif recording.rest and not recording.loads and not has_laws(problem.values):
            said.append(f"{recording.name} moves from rest, but has no command and no torque: was one left out (commands_taken in a bag, "
                        "tau_<joint>, --effort)?")
    if said:
        return said
    revolute = np.flatnonzero(~np.array(scene.prismatic))
    if not len(revolute):
        return said
    as_it_is, trials = solver(problem, states), {}
    for words, change in COUNTS.items():
        def counted(values, turn, change=change):
            """values: a row for each instant, a column for each joint."""
            values = values.copy()
            values[:, revolute] = change(values[:, revolute], turn)
            return values
        changed = [Recording(one.name, one.t, counted(one.q, np.pi / 2), None, one.loads, one.start) for one in problem.recordings]
        other = Problem(scene, changed, problem.numbers, problem.has_offsets, problem.has_delay)
        trials[words] = solver(other, [np.concatenate([counted(half[None], turn)[0] for half, turn in zip(np.split(state, 2), (np.pi / 2, 0.0))])
                                       for state in states])
    best = min(trials, key=trials.get)
    if BETTER * trials[best] < as_it_is:
        said.append(f"it looks as if the data count {best.format(first=problem.joints[revolute[0]])}")
    return said

