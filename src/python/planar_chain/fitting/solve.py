"""The least-squares fit: windows from the start of each recording, which grow; a robust loss, calibrated to the residuals.

The last window is the whole recordings. Its loss is Σ_j s_j² C² ρ((e/(C s_j))²), ρ(z) = 2 (√(1 + z) − 1), over the residuals e of
joint j; s_j is 1.4826 times their median magnitude, computed again until it stays. For normal noise s_j is its deviation."""

import numpy as np
from scipy.optimize import least_squares

from .problem import TOLERANCE

WINDOWS = (0.3, 0.6, 1.2, 2.4)  # s
LOSS = 3.0  # C
LEAST_NOISE, LEAST_SHARE = 1e-9, 1e-3  # rad, and of the noise of all joints: no s_j is smaller, or one joint would count alone
FIRST_NOISE = 1e-3  # rad: s_j before the first residuals
FAILED = 100.0  # rad: a residual of a run that failed; no residual counts more
EARLY_SAMPLES, EARLY_CALLS, LAST_CALLS = 150, 15, 100  # times of a recording in an early window; evaluations
SHORTEST = 5  # samples of the first of the shorter windows, each twice as long as the last, that a search which does not end begins with
EARLY_PRECISION, PRECISION = 1e-3, 1e-9
STALLED, GAIN = 25, 1e-3  # evaluations that together lower the loss by less than this part of it: the best so far is the minimum
CALIBRATIONS = 6
NARROW, STEEPEST = 3e-8, 1e5  # width of the differences of a Jacobian, relative; rad: samples from a steeper one on tell nothing
LOST, LOST_SAMPLES = 0.5, 20  # rad or m: a motion is lost where most errors of a twentieth of a window are larger
SAME_NOISE = 0.02  # relative change of s_j at which it stays
PRIOR, LAST_PRIOR = 1.0, 10.0  # deviation of a number from its first value, in scales, or of a delay from 0, in DELAY_SCALE, as it is
# taken to be before the data come: in an early window; in the last. What the data cannot tell thus stays near its first value
FARTHEST = 1000.0  # scales: a step that takes a number farther from its first value is refused, as if the run had failed


class Stalled(Exception):
    """The loss stays, though the steps of a search that doubts its Jacobian do not: where runs are no more precise than that."""


class Solution:
    """x and the noise s_j of each joint. samples: the indices of the times that were fitted, for each recording; they end where a
    chaotic motion is lost. reason: why it did not converge, or empty."""

    def __init__(self, x, noise, samples):
        self.x, self.noise, self.samples, self.reason, self.interrupted, self.calls = x, noise, samples, "", False, 0


def first_state(recording, window=0.02):
    """The angles and rates at the first sample: as measured, or where rates or angles are missing from a parabola through the next."""
    n = recording.q.shape[1]
    state = np.concatenate([recording.q[0], recording.qd[0] if recording.qd is not None else np.full(n, np.nan)])
    for j in range(n):
        if np.isfinite(state[[j, n + j]]).all():
            continue
        known = np.flatnonzero(np.isfinite(recording.q[:, j]))
        near = known[:max(6, np.searchsorted(recording.t[known], recording.t[known[0]] + window))]
        parabola = np.polynomial.Polynomial.fit(recording.t[near], recording.q[near, j], min(2, len(near) - 1))
        if np.isnan(state[j]):
            state[j] = parabola(0.0)
        if np.isnan(state[n + j]):
            state[n + j] = parabola.deriv()(0.0)
    return state


def stages(recordings, windows):
    """The ends of the windows: those given, then twice as long each, then the whole."""
    longest = max(recording.duration for recording in recordings)
    ends = [end for end in windows if end < longest]
    while ends and 2 * ends[-1] < longest:
        ends.append(2 * ends[-1])
    return [*ends, np.inf]


def samples_of(recordings, ends, most=None):
    """The indices of the times up to `ends`, of all or of each, at most so many, evenly."""
    chosen = []
    for recording, end in zip(recordings, np.broadcast_to(ends, len(recordings))):
        count = max(int(np.searchsorted(recording.t, end, side="right")), 2)
        step = 1 if most is None else max(1, -(-count // most))
        chosen.append(np.arange(0, count, step))
    return chosen


def followed(t, errors):
    """Until when the errors, times × n, stay those of the same motion, s; infinite if to the end."""
    width = max(len(t) // LOST_SAMPLES, 3)
    is_large = ~(abs(np.where(np.isnan(errors), 0, errors)) < LOST).all(axis=1)
    count = np.convolve(is_large, np.ones(width))[width - 1:]
    lost = np.flatnonzero(is_large & (count > width / 2))
    return t[lost[0]] if len(lost) else np.inf


def until_steep(problem, jacobian, samples):
    """The samples before the first whose row of the Jacobian is too steep, for each recording; ten at least."""
    edge, kept = 0, []
    for indices, mask in zip(samples, problem.measured(samples)):
        times = np.nonzero(mask)[0]
        steep = times[abs(jacobian[edge:edge + len(times)]).max(axis=1) > STEEPEST]
        edge += len(times)
        kept.append(indices[:max(steep[0], 10)] if len(steep) else indices)
    return kept


def noise_of(residuals, joints, n):
    """s_j, from the magnitudes of the residuals. A joint that was hardly measured has that of all."""
    residuals = np.nan_to_num(residuals, nan=FAILED)
    every = 1.4826 * np.median(abs(residuals))
    own = [1.4826 * np.median(abs(residuals[joints == j])) if (joints == j).sum() > 5 else every for j in range(n)]
    return np.maximum(own, max(LEAST_NOISE, LEAST_SHARE * every))


class Solver:
    """progress(window, error, calls): called after each evaluation; error: root mean square, rad."""

    def __init__(self, problem, states, windows=WINDOWS, progress=None):
        self.problem, self.windows, self.progress = problem, windows, progress or (lambda *_: None)
        samples = samples_of(problem.recordings, np.inf)
        self.solution = Solution(problem.first(states), np.full(len(problem.joints), FIRST_NOISE), samples)
        self.reached = np.zeros(len(problem.recordings))  # s: until when each recording was followed
        self.calls = 0

    def run(self, until=np.inf):
        """The solution; the best so far after Ctrl-C. until: s, the end of the last window."""
        problem, solution = self.problem, self.solution
        ends = [end for end in stages(problem.recordings, self.windows) if end < until]
        try:
            problem.require_runs(solution.x, samples_of(problem.recordings, (ends + [until])[0], EARLY_SAMPLES))
            reach = np.inf
            for end in ends:
                start, samples = solution.x, samples_of(problem.recordings, np.minimum(end, 2 * reach), EARLY_SAMPLES)
                self.stage(end, samples, EARLY_CALLS, EARLY_PRECISION, PRIOR)
                if end == ends[0] and (solution.reason or any(
                        problem.is_sparse(solution.x, r, np.arange(indices[-1] + 1)) for r, indices in enumerate(samples))):
                    self.from_shorter_windows(start, end, samples)
                reach = self.followed(samples)
            self.whole(until, 2 * reach)
        except KeyboardInterrupt:
            solution.interrupted, solution.reason = True, "interrupted"
        solution.calls = self.calls
        return solution

    def from_shorter_windows(self, x, end, samples):
        """The first window once more, after shorter ones from x. It leads to the right valley where a motion vibrates within it."""
        def error():
            return np.mean(abs(np.nan_to_num(self.problem.residuals(self.solution.x, samples), nan=FAILED)))
        recordings, solution = self.problem.recordings, self.solution
        before, least = solution.x, error()
        solution.x, count = x, SHORTEST
        while count < max(map(len, samples)):
            ends = [min(recording.t[min(count, len(recording)) - 1], end) for recording in recordings]
            self.stage(max(ends), samples_of(recordings, ends), EARLY_CALLS, EARLY_PRECISION, PRIOR)
            count *= 2
        self.stage(end, samples, EARLY_CALLS, EARLY_PRECISION, PRIOR)
        if error() > least:
            solution.x = before

    def first_error(self):
        """The root mean square error after a fit of the first window, rad; infinite if it does not run."""
        samples = samples_of(self.problem.recordings, self.windows[0], EARLY_SAMPLES)
        self.stage(self.windows[0], samples, EARLY_CALLS, EARLY_PRECISION, PRIOR)
        error = np.sqrt(np.mean(self.problem.residuals(self.solution.x, samples) ** 2))
        return error if np.isfinite(error) else np.inf

    def whole(self, until, reach):
        recordings, solution = self.problem.recordings, self.solution
        few = samples_of(recordings, np.minimum(until, reach), 4 * EARLY_SAMPLES)
        if sum(map(len, few)) < sum(map(len, samples_of(recordings, until))):
            before, noise, known = solution.x, solution.noise, self.reached
            self.stage(until, few, EARLY_CALLS, EARLY_PRECISION, LAST_PRIOR)
            if (self.followed_now(few) < known).any():  # what was followed is lost: beyond, chaos leads astray
                solution.x, solution.noise = before, noise
            reach = np.minimum(reach, self.followed(few))
        near = samples_of(recordings, np.minimum(until, reach))
        gentle = until_steep(self.problem, self.problem.jacobian(solution.x, near, NARROW), near)
        ends = np.array([np.inf if len(kept) == len(indices) else recording.t[kept[-1]] for kept, indices, recording in
                         zip(gentle, near, recordings)])
        reach = np.minimum(reach, ends)
        errors_of_runs = TOLERANCE * max(recording.duration for recording in recordings)
        width = None
        for _ in range(CALIBRATIONS):
            noise, before = solution.noise, reach
            solution.samples = samples_of(recordings, np.minimum(until, reach))
            self.stage(until, solution.samples, LAST_CALLS, PRECISION, LAST_PRIOR, width)
            if solution.reason:
                width = NARROW  # wider differences make a search along a steep motion creep
            reach = np.minimum(reach, self.followed(solution.samples))
            if max(solution.noise) < errors_of_runs:
                solution.reason = ""  # no search comes closer
            stays = (abs(solution.noise - noise) < SAME_NOISE * noise).all() or max(solution.noise) < errors_of_runs
            if (reach == before).all() and stays:
                break

    def followed(self, samples):
        """Until when each recording is followed, s; infinite if to the last sample. What was followed once can be."""
        now = self.followed_now(samples)
        ends = [recording.t[indices[-1]] for recording, indices in zip(self.problem.recordings, samples)]
        self.reached = np.maximum(self.reached, np.minimum(now, ends))
        return np.maximum(now, self.reached)

    def followed_now(self, samples):
        """Until when the present x alone follows each recording, s."""
        errors = self.problem.errors(self.solution.x, samples)
        return np.array([followed(recording.t[indices], error)
                         for recording, indices, error in zip(self.problem.recordings, samples, errors)])

    def stage(self, end, samples, most, precision, prior, width=None):
        """One least-squares fit. It keeps the best x and the noise of its residuals in the solution."""
        problem, solution = self.problem, self.solution
        joints = problem.joints_of(samples)
        residuals = problem.residuals(solution.x, samples)
        noise = solution.noise = noise_of(residuals, joints, len(problem.joints))
        weights = 1 / noise[joints]
        many, (indices, first, sizes) = len(problem.numbers), problem.priors()
        best, bases = [np.inf], []

        def error(x):
            self.calls += 1
            is_far = (abs(x[:many] - first[:many]) > FARTHEST).any()
            plain = np.full(len(joints), np.nan) if is_far else problem.residuals(x, samples)
            values = np.clip(np.nan_to_num(plain, nan=FAILED), -FAILED, FAILED) * weights
            z = (values / LOSS) ** 2
            cost = np.sum(np.sqrt(1 + z) - 1)
            if cost < best[0]:
                best[0], solution.x = cost, x.copy()
                self.progress(end, float(np.sqrt(np.nanmean(plain ** 2))), self.calls)
            bases.append(best[0])
            if len(bases) > STALLED and bases[-1 - STALLED] - best[0] < GAIN * best[0]:
                raise Stalled
            return np.concatenate([values, (x[indices] - first) / (sizes * prior)])

        def slopes(x):
            jacobian = problem.jacobian(x, samples, width) * weights[:, None]
            expected = np.zeros((len(indices), problem.size))
            expected[range(len(indices)), indices] = 1 / (sizes * prior)
            return np.vstack([jacobian, expected])

        low, high = problem.bounds()
        x = np.clip(solution.x, low, high)
        try:
            result = least_squares(error, x, slopes, bounds=(low, high), loss="soft_l1", f_scale=LOSS, x_scale="jac",
                                   ftol=precision, xtol=precision, gtol=precision, max_nfev=most)
            solution.x, solution.reason = result.x, "" if result.status > 0 else f"{most} evaluations were not enough"
        except Stalled:
            solution.reason = ""
        solution.noise = noise_of(problem.residuals(solution.x, samples), joints, len(problem.joints))
