"""The residuals of a fit and their Jacobian: all runs in one batch.

The unknowns, x: the numbers over their scales; then for each recording its initial state (the angles and rates of the joints that are
not driven), and if asked for the offset of each encoder and the delay between torque and motion, s. A residual is an angle of the
model plus the offset minus the measured one, rad."""

import re

import numpy as np

from planar_chain import Refused, Scene, simulate_many

from .recordings import BadFit, moved_loads, moved_scene
from .varied import scene_with

TOLERANCE, EXACT = 1e-9, 1e-13  # of the runs, rad per second: of a fit; where small singular values of a Jacobian count
OF_THE_RUNS = 100  # residuals below so many tolerances of the runs are errors of integration
DIFFERENCE, DELAY_DIFFERENCE = 1e-5, 1e-4  # of an unknown for its column, relative; of a delay, s
DELAY_SCALE = 0.1  # s, of a delay: an early window in which no torque changes does not tell it
HIDDEN = 0.3  # of the motion: with 3.5 samples a period so much of it is not seen, and many numbers are the best of their neighbours
FEW = 8  # runs of a batch that take less time than to start threads
MOST_STEPS = 20_000  # of a run, for each second; a good fit takes some hundred. Larger, wild runs far from the data cost minutes
CLOSE = 8e-3  # s: between such times angles are interpolated, where a step would have to end at each time


class Problem:
    """scene: a Scene. recordings: as in recordings.py. numbers: as in varied.py."""

    def __init__(self, scene, recordings, numbers, offsets=False, delay=False, tolerance=TOLERANCE):
        self.recordings, self.numbers = recordings, numbers
        self.joints = scene.joints
        self.values = prepared(scene.to_dict(), tolerance)
        self.scene = Scene(self.values)
        driven = [drive_of(self.values, k) for k in joint_links(self.values)]
        self.free = np.flatnonzero(np.logical_not(driven))
        self.has_offsets, self.has_delay = offsets, delay
        n = len(self.joints)
        self.per_recording = 2 * len(self.free) + (n if offsets else 0) + (1 if delay else 0)
        self.size = len(numbers) + self.per_recording * len(recordings)
        self.runs = 0  # simulated so far
        self.is_plain = is_plain(self.values)
        self.moves_drives = any(re.match("links/[^/]*/joint/drive/", number.path) for number in numbers)
        self.moves_laws = self.moves_drives or any(re.match("(loads|base|tip)/", number.path) for number in numbers)
        self.reason = ""  # of the last run that failed
        self.errors_of_runs = OF_THE_RUNS * TOLERANCE * max(recording.duration for recording in recordings)  # rad or m
        self._scenes = {}

    # ---- Unknowns ------------------------------------------------------------------------------

    def first(self, states):
        """x of the first values. states: 2n numbers for each recording."""
        rest = np.zeros(self.per_recording - 2 * len(self.free))
        own = [np.concatenate([state[self.columns], rest]) for state in states]
        return np.concatenate([[number.first / number.scale for number in self.numbers], *own])

    def priors(self):
        """The values expected before the data come: their indices in x, values, and sizes of the deviations from them. First the numbers,
        then the delays."""
        delays = [self.own(r).stop - 1 for r in range(len(self.recordings))] if self.has_delay else []
        numbers = [number.first / number.scale for number in self.numbers]
        return (np.array([*range(len(numbers)), *delays], dtype=int), np.array(numbers + [0.0] * len(delays)),
                np.array([1.0] * len(numbers) + [DELAY_SCALE] * len(delays)))

    @property
    def columns(self):
        """The indices of the free joints in a state."""
        return np.concatenate([self.free, self.free + len(self.joints)])

    def bounds(self):
        low, high = np.full(self.size, -np.inf), np.full(self.size, np.inf)
        for k, number in enumerate(self.numbers):
            low[k], high[k] = number.low / number.scale, number.high / number.scale
        if self.has_delay:
            low[[self.own(r).stop - 1 for r in range(len(self.recordings))]] = 0
        return low, high

    def own(self, r):
        """The slice of x with the unknowns of recording r."""
        first = len(self.numbers) + r * self.per_recording
        return slice(first, first + self.per_recording)

    def parts(self, x, r):
        """The values of the numbers, the initial state, the offsets and the delay of recording r."""
        values = x[:len(self.numbers)] * [number.scale for number in self.numbers]
        own = x[self.own(r)]
        f, n = 2 * len(self.free), len(self.joints)
        scene = self.scene_of(r, 0.0, values) if f < 2 * n else None
        state = scene.state if scene else np.full(2 * n, np.nan)
        state[self.columns] = own[:f]
        return values, state, own[f:f + n] if self.has_offsets else np.zeros(n), float(own[-1]) if self.has_delay else 0.0

    def steps(self, x):
        steps = DIFFERENCE * np.maximum(np.abs(x), 1.0)
        if self.has_delay:
            steps[[self.own(r).stop - 1 for r in range(len(self.recordings))]] = DELAY_DIFFERENCE
        high = self.bounds()[1]
        return np.where(x + steps > high, -steps, steps)

    # ---- Runs ----------------------------------------------------------------------------------

    def has_numbers(self, r):
        """True if the scenes of recording r are made with the numbers' values: a driven joint starts on its law, and a recording that
        starts later moves the laws of time."""
        return self.moves_drives or (self.moves_laws and self.recordings[r].start != 0)

    def scene_of(self, r, delay, values):
        """The scene of recording r, with what acted on it. Recordings of free motion share theirs. None if it is refused."""
        recording = self.recordings[r]
        delay = delay if recording.shows_delay() else 0.0
        has_time = recording.loads or (recording.start and has_laws(self.values))
        key = (r if has_time else None, delay, tuple(values) if self.has_numbers(r) else None)
        if key not in self._scenes:
            if len(self._scenes) > 4 * len(self.recordings) * (1 + len(self.numbers)) + 16:  # those of a Jacobian stay
                self._scenes.clear()
            self._scenes[key] = self._scene(recording, delay, has_time, values if self.has_numbers(r) else None)
        return self._scenes[key]

    def _scene(self, recording, delay, has_time, values):
        try:
            tree = self.values if values is None else scene_with(self.scene, self.numbers, values).to_dict()
            tree = moved_scene(tree, recording.start) if has_time else tree
            own = tree.get("loads") or {}
            return Scene({**tree, "loads": {**own, **unlike(moved_loads(recording.loads, -delay), own)}})
        except Refused as error:
            self.reason = str(error)
            return None

    def parameters(self, r, rows):
        """The values of the numbers by their paths, a row each, of runs of a scene of recording r."""
        columns = np.transpose(rows)
        return {} if self.has_numbers(r) else {number.path: column for number, column in zip(self.numbers, columns)}

    def motions(self, rows, samples):
        """rows: (recording, values, state, delay) of each run. samples: the indices of the times, for each recording.

        Returns for each row the angles, times × n, NaN where a run failed."""
        groups = {}
        results = [np.full((len(samples[r]), len(self.joints)), np.nan) for r, *_ in rows]
        for k, (r, values, _, delay) in enumerate(rows):
            scene = self.scene_of(r, delay, values) if len(samples[r]) else None
            if scene:
                groups.setdefault(id(scene), (scene, []))[1].append(k)
        for scene, members in groups.values():
            times = {r: np.round(self.recordings[r].t[samples[r]], 12) for r in {rows[k][0] for k in members}}
            grid = self._grid(np.unique(np.concatenate(list(times.values()))), bool(scene.to_dict().get("loads")))
            runs = simulate_many(scene, grid, initial=np.array([rows[k][2] for k in members]),
                                 parameters=self.parameters(rows[members[0]][0], [rows[k][1] for k in members]),
                                 most_steps=most_steps(grid),
                                 threads=1 if self.is_plain and len(members) <= FEW else 0)
            self.runs += len(members)
            self.reason = next(iter(runs.reasons.values()), self.reason)
            readers = {r: between(grid, t) for r, t in times.items()}
            for row, k in enumerate(members):
                results[k] = readers[rows[k][0]](runs.states[row])
        return results

    def _grid(self, times, has_loads):
        """The times of a run: those given, or fewer if a step has to end at each and they are close."""
        if (self.is_plain and not has_loads) or len(times) < 3 or np.median(np.diff(times)) > CLOSE / 2:
            return times
        return np.linspace(0.0, times[-1], int(np.ceil(times[-1] / CLOSE)) + 1)

    def states(self, x, r, indices):
        """The states of recording r at these samples. The first is that from which the run goes, which closes a closed chain."""
        values, state, _, delay = self.parts(x, r)
        times = np.round(self.recordings[r].t[indices], 12)
        return simulate_many(self.scene_of(r, delay, values), times, initial=[state], parameters=self.parameters(r, [values]),
                             most_steps=most_steps(times)).states[0]

    def is_sparse(self, x, r, indices):
        """True if these samples of recording r hide much of the motion between them. Otherwise angles change by nearly the mean of the
        rates at both ends, times the time."""
        angles, rates = np.hsplit(self.states(x, r, indices), 2)
        change, time = np.diff(angles, axis=0), np.diff(self.recordings[r].t[indices])[:, None]
        return np.linalg.norm(change - time * (rates[1:] + rates[:-1]) / 2) > HIDDEN * np.linalg.norm(change)

    def angles(self, x, samples):
        """The angles that encoders would have shown, for each recording."""
        parts = [self.parts(x, r) for r in range(len(self.recordings))]
        motions = self.motions([(r, values, state, delay) for r, (values, state, _, delay) in enumerate(parts)], samples)
        return [motion + offset for motion, (_, _, offset, _) in zip(motions, parts)]

    # ---- Residuals -----------------------------------------------------------------------------

    def measured(self, samples):
        """Which angles were measured, for each recording: times × n."""
        return [np.isfinite(recording.q[indices]) for recording, indices in zip(self.recordings, samples)]

    def errors(self, x, samples):
        """rad, for each recording: times × n, NaN where nothing was measured."""
        return [motion - recording.q[indices] for motion, recording, indices in zip(self.angles(x, samples), self.recordings, samples)]

    def residuals(self, x, samples):
        """rad, of all that was measured."""
        return np.concatenate([error[mask] for error, mask in zip(self.errors(x, samples), self.measured(samples))])

    def joints_of(self, samples):
        """The joint of each residual."""
        return np.concatenate([np.nonzero(mask)[1] for mask in self.measured(samples)])

    def jacobian(self, x, samples, width=None):
        """Residuals × unknowns, by differences: one-sided, or central ones of this relative width. A recording's own unknowns move its
        residuals alone. Where one side cannot run, such as beyond a rule of the scene, the other one counts."""
        steps = self.steps(x) * (width / DIFFERENCE if width else 1)
        masks = self.measured(samples)
        edges = np.concatenate([[0], np.cumsum([mask.sum() for mask in masks])])
        columns = [(r, k) for r in range(len(self.recordings)) for k in [*range(len(self.numbers)), *range(self.own(r).start, self.own(r).stop)]]
        motions = self._moved(x, steps, [(r, None, 0) for r in range(len(self.recordings))]
                              + [(r, k, sign) for r, k in columns for sign in ((1, -1) if width else (1,))], samples)
        runs = {side: np.isfinite(motion).all() for side, motion in motions.items()}
        lower = self._moved(x, steps, [(r, k, -1) for r, k in columns if not runs[r, k, 1] and (r, k, -1) not in runs], samples)
        motions.update(lower)
        runs.update((side, np.isfinite(motion).all()) for side, motion in lower.items())
        jacobian = np.zeros((edges[-1], self.size))
        for r, k in columns:
            present, above, below = motions[r, None, 0], motions[r, k, 1], motions.get((r, k, -1))
            if not runs.get((r, k, -1), False):
                change = (above - present) / steps[k]
            else:
                change = (above - below) / (2 * steps[k]) if runs[r, k, 1] else (present - below) / steps[k]
            jacobian[edges[r]:edges[r + 1], k] = np.nan_to_num(change[masks[r]], nan=0.0)
        return jacobian

    def _moved(self, x, steps, sides, samples):
        """The angles of recording r when unknown k moves by a step of this sign, by (r, k, sign). k: None for the present ones."""
        rows, offsets = [], []
        for r, k, sign in sides:
            moved = x.copy()
            if k is not None:
                moved[k] += sign * steps[k]
            values, state, offset, delay = self.parts(moved, r)
            rows.append((r, values, state, delay))
            offsets.append(offset)
        return {side: motion + offset for side, motion, offset in zip(sides, self.motions(rows, samples), offsets)}

    def require_runs(self, x, samples):
        """Refuses a scene that cannot run at its first values."""
        for recording, motion in zip(self.recordings, self.angles(x, samples)):
            if not np.isfinite(motion).all():
                raise BadFit(f"{recording.name}: expected a scene that moves from the first values, got: {self.reason or 'no motion'}")


# ---- Scenes ------------------------------------------------------------------------------------


def prepared(values, tolerance):
    """Without what a run from a given state does not need."""
    values = {key: value for key, value in values.items() if key not in ("publish", "start", "real_time_factor", "command_timeout")}
    integrator = dict(values.get("integrator") or {})
    integrator.pop("loosest_tolerance", None)
    if float(integrator.get("tolerance", 1e-8)) > tolerance:
        integrator["tolerance"] = tolerance
    return {**values, "integrator": integrator}


def joint_links(values):
    """The link whose entry describes each joint, in order."""
    return [name for name in values["chain"] for _ in range(3 if is_floating(values, name) else int(values["links"][name].get("repeat", 1)))]


def is_floating(values, link):
    return (values["links"][link].get("joint") or {}).get("type") == "floating"


def drive_of(values, link):
    return bool((values["links"][link].get("joint") or {}).get("drive"))


def has_laws(values):
    tip = (values.get("tip") or {}).get("pin")
    return bool(values.get("loads") or values.get("base") or isinstance(tip, dict) or any(drive_of(values, link) for link in values["chain"]))


def is_plain(values):
    """True if runs go in lanes, where each further time costs next to nothing: see simulate_many()."""
    joints = [values["links"][link].get("joint") or {} for link in values["chain"]]
    return (len(joint_links(values)) <= 12 and not has_laws(values)
            and all(set(joint) <= {"name", "damping", "stiffness", "rest_angle"} for joint in joints))


def most_steps(times):
    """The most steps of a run to the last of these times."""
    return int(MOST_STEPS * max(1.0, times[-1]))


def between(grid, times):
    """A function of the states on the grid: their angles at the times, by the cubics that share angles and rates with them."""
    after = np.searchsorted(grid, times)
    if (grid[np.minimum(after, len(grid) - 1)] == times).all():
        return lambda states: states[after, :states.shape[1] // 2]
    k = np.clip(after, 1, len(grid) - 1)
    h = (grid[k] - grid[k - 1])[:, None]
    s = (times - grid[k - 1])[:, None] / h

    def angles(states):
        q, qd = np.hsplit(states, 2)
        return ((1 + 2 * s) * (1 - s) ** 2 * q[k - 1] + s ** 2 * (3 - 2 * s) * q[k]
                + h * (s * (1 - s) ** 2 * qd[k - 1] - s ** 2 * (1 - s) * qd[k]))
    return angles


def unlike(loads, others):
    """The loads, with names that the scene does not have."""
    return {name if name not in others else name + "_of_the_recording": load for name, load in loads.items()}
