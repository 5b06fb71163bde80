"""Measured motions: times, angles, and what acted on the joints and links meanwhile. From a CSV, from a bag, or from arrays."""

import csv
import math
import numbers
import os

import numpy as np

from planar_chain.user_input import read_number, rows_of

MOST_ANGLE = 50.0  # rad; above it an angle is rather in degrees
LEAST_MOTION = 1e-6  # rad
LEAST_SAMPLES = 10
MOST_GAP, MOST_SPACINGS = 1000.0, 100  # s, between two samples, or so many times the usual spacing: the run between them takes long
LONG_REST, KEPT_REST = 0.5, 0.1  # s: a longer rest before the first motion is cut; so much of it stays
MOVED, MOST_MOVED = 0.02, 0.02  # a joint has moved by this part of its range, or by so much, rad,
NOISY, MOST_NOISY = 8.0, 0.1  # or by so many times the noise of its samples if that is more; by so much, rad, in any case
RESOLUTION = 1e-9  # s, of stamps


class BadFit(ValueError):
    """Where a fault of the input is, what was expected, what was found."""


def is_number(value):
    """True for a real number that a double holds, but not for a bool, nor for a time of numpy, whose unit would be lost."""
    if not isinstance(value, numbers.Real) or isinstance(value, (bool, np.timedelta64)):
        return False
    try:
        float(value)
    except OverflowError:
        return False
    return True


def array_of(name, what, values):
    """Numbers, NaN for a gap. numpy would forget masks and imaginary parts."""
    masked = any(map(np.ma.isMaskedArray, [values, *(values if isinstance(values, (list, tuple)) else ())]))
    try:
        array = np.asarray(values)
        if masked or np.iscomplexobj(array):
            raise TypeError("a masked array (filled(numpy.nan) makes gaps)" if masked else "complex ones")
        if array.dtype.kind in "mM":  # numpy would drop their unit
            raise TypeError(f"one of {array.dtype}")
        for one in array.ravel().tolist() if array.dtype.kind in "SUbO" else ():  # and read texts
            if isinstance(one, (str, bytes, bool, np.bool_)):
                raise TypeError(repr(one))
        return array.astype(float)
    except (OverflowError, TypeError, ValueError) as problem:
        raise BadFit(f"{name}: expected an array of numbers as {what}, got {problem}") from None


class Recording:
    """One motion without a break.

    t: s, N, the first is 0, increasing. q: rad, N × n in the scene's order of joints, NaN where nothing was measured. qd: rad/s, N × n or
    None. loads: what acted, as entries of a scene's `loads`, in this t. start: t of the scene's own laws at t = 0, s. rest: a Recording
    of the rest that was cut before it, or None. cut: words, if a number at its end may be cut off, or on what was left out. is_piece: of a bag with jumps."""

    rest, cut, is_piece = None, "", False

    def __init__(self, name, t, q, qd=None, loads=None, start=0.0):
        self.name, self.start, self.loads = name, float(start), dict(loads or {})
        self.t, self.q = array_of(name, "t", t), array_of(name, "q", q)
        self.qd = None if qd is None else array_of(name, "qd", qd)

    def __len__(self):
        return len(self.t)

    def __repr__(self):
        return f"<Recording {self.name}: {len(self)} samples>"

    @property
    def duration(self):
        return self.t[-1]

    def shows_delay(self):
        """True if a load changes during the recording. Otherwise the motion does not determine a delay."""
        return any(changes_within(load, self.duration) for load in self.loads.values())

    def pieces(self, seconds):
        """Equal ones, about so long."""
        if max(self.duration / seconds, 1) * LEAST_SAMPLES > len(self):
            raise BadFit(f"{self.name}: expected at least {LEAST_SAMPLES} samples in a piece (--pieces), got pieces of {seconds:g} s of "
                         f"{len(self)} samples in {self.duration:g} s")
        count = max(round(self.duration / seconds), 1)
        edges = [*np.searchsorted(self.t, self.duration / count * np.arange(count)), len(self)]
        return [self.part(first, last) for first, last in zip(edges, edges[1:])] if count > 1 else [self]

    def without_rest(self):
        """The recording from shortly before its first motion, if a long rest precedes it: a rest determines no numbers."""
        known = self.q[:, np.isfinite(self.q).any(axis=0)]
        if not known.size:
            return self
        first = np.array([column[np.isfinite(column)][0] for column in known.T])
        least = np.minimum(MOVED * (np.nanmax(known, axis=0) - np.nanmin(known, axis=0)), MOST_MOVED)
        noise = np.array([noise_of_samples(column) for column in known.T])
        away = abs(np.nan_to_num(known - first)) > np.maximum(least, np.minimum(NOISY * noise, MOST_NOISY))
        moved = np.flatnonzero(away.any(axis=1))
        if not len(moved) or self.t[moved[0]] < LONG_REST:
            return self
        begin = self.t[moved[0]] - (KEPT_REST if self.loads else 0.0)  # what moves without a load was held
        first = np.searchsorted(self.t, begin)
        moving = self.part(first, len(self))
        moving.rest = self.part(0, first)
        return moving

    def part(self, first, last):
        """The samples first … last - 1 as a recording of its own."""
        shift = self.t[first]
        loads = moved_loads(self.loads, shift)
        name = f"{self.name}, {shift:g} to {self.t[last - 1]:g} s"
        part = Recording(name, self.t[first:last] - shift, self.q[first:last],
                         None if self.qd is None else self.qd[first:last], loads, self.start + shift)
        part.cut, part.is_piece = self.cut if last == len(self) else "", self.is_piece
        part.rest = self.rest if first == 0 else None
        return part


def changes_within(load, end):
    """True if a load changes at a time between 0 and `end`, s."""
    if any(0 < float(load[key]) < end for key in ("start", "stop") if key in load):
        return True
    if "times" not in load:
        return "frequency" in load
    inside = [t for t in load["times"] if 0 < t < end]
    return bool(np.ptp(np.interp([0.0, *inside, end], load["times"], load["values"])))


def noise_of_samples(values):
    """The noise of one joint, from third differences, to which a smooth motion adds little."""
    known = values[np.isfinite(values)]
    return np.median(abs(np.diff(known, 3))) / (0.6745 * np.sqrt(20)) if len(known) > 3 else 0.0


# ---- Checks ------------------------------------------------------------------------------------


def require_stamps(path, t, names):
    """names: what names each stamp, such as its line."""
    for k in np.flatnonzero(~np.isfinite(t))[:1]:
        raise BadFit(f"{path}: {names(k)}: expected a finite time, got {t[k]:g}")
    for k in np.flatnonzero(np.diff(t) <= 0)[:1] + 1:
        raise BadFit(f"{path}: {names(k)}: expected a time after {t[k - 1]:.12g} s, got {t[k]:.12g} s"
                     + (", a repeated stamp" if t[k] == t[k - 1] else ", an unsorted stamp"))


def long_enough(recordings, least):
    """Those that can be fitted. Pieces of bags that are shorter are left out, as the last one tells; if there is nothing else, none is.

    least: s."""
    short = [one for one in recordings if one.is_piece and (len(one) < LEAST_SAMPLES or one.duration < least)]
    rest = [one for one in recordings if one not in short]
    if short and rest:
        words = (f"{', '.join(one.name for one in short)}: left out, with fewer than {LEAST_SAMPLES} samples or shorter than {least:g} s, "
                 "the first window (--windows)")
        rest[-1].cut = "; ".join(filter(None, [*(one.cut for one in (*short, rest[-1])), words]))
    return rest or recordings


def require_samples(name, t, arrays, joints):
    """arrays: by name, times × n."""
    for key, array in arrays.items():
        if t.ndim != 1 or array.shape != (len(t), len(joints)):
            raise BadFit(f"{name}: expected {key} of {t.size} x {len(joints)} numbers, got {' x '.join(map(str, array.shape))}")
    require_stamps(name, t, lambda k: f"sample {k}")
    if len(t) < LEAST_SAMPLES:
        raise BadFit(f"{name}: expected at least {LEAST_SAMPLES} samples, got {len(t)}")


def require_radians(recording, joints, prismatic):
    for joint, values in ((joint, values) for joint, values, is_prismatic in zip(joints, recording.q.T, prismatic) if not is_prismatic):
        most = abs(values[np.isfinite(values)]).max(initial=0.0)
        if most > MOST_ANGLE:
            raise BadFit(f"{recording.name}: expected angles in rad, got {most:g} in {joint}, which looks like degrees "
                         "(--many-turns takes it as rad)")


def require_angles(recording, joints):
    name = recording.name
    if len(recording) < LEAST_SAMPLES:
        raise BadFit(f"{name}: expected at least {LEAST_SAMPLES} samples, got {len(recording)}")
    gaps, most = np.diff(recording.t), max(MOST_GAP, MOST_SPACINGS * np.median(np.diff(recording.t)))
    for k in np.flatnonzero(gaps > most)[:1]:
        raise BadFit(f"{name}: expected samples at most {most:g} s apart, got {gaps[k]:g} s before t = {recording.start + recording.t[k + 1]:g} s "
                     "(a wrong stamp?)")
    for values, what in ((recording.q, "angle"), (recording.qd, "rate")):
        for k, j in np.argwhere(np.isinf(values))[:1] if values is not None else ():
            raise BadFit(f"{name}: expected a finite {what} of {joints[j]}, got {values[k, j]:g} at t = {recording.t[k]:g} s")
    for j, joint in enumerate(joints):
        if not np.isfinite(recording.q[:, j]).any():
            raise BadFit(f"{name}: expected angles of the joint {joint}, got none")


def require_motion(recordings, joints, given):
    """given: for each joint, whether its motion is given by the scene."""
    for j, joint in enumerate(joints):
        spans = [np.nanmax(recording.q[:, j]) - np.nanmin(recording.q[:, j]) for recording in recordings]
        if not given[j] and max(spans) < LEAST_MOTION:
            raise BadFit(f"{', '.join(r.name for r in recordings)}: expected a motion of the joint {joint}, got one that never moves")


# ---- CSV ---------------------------------------------------------------------------------------


def columns_of(path, header, joints):
    """The columns of t, q, q̇ and τ. q̇, τ: those that are there, by joint."""
    known = {"t", "energy", *(kind + joint for kind in ("q_", "qd_", "tau_") for joint in joints)}
    for name in header:
        if name not in known or header.count(name) > 1:
            raise BadFit(f"{path}: line 1: expected the columns t, q_<joint>, qd_<joint>, tau_<joint>, each once, of the joints "
                         f"{', '.join(joints)}, got {name!r}{' twice' if name in known else ''}")
    missing = [name for name in ["t", *("q_" + joint for joint in joints)] if name not in header]
    if missing:
        raise BadFit(f"{path}: line 1: expected the columns {', '.join(missing)}, got {', '.join(header)[:200] or 'none'}")
    return (header.index("t"), [header.index("q_" + joint) for joint in joints],
            *({joint: header.index(kind + joint) for joint in joints if kind + joint in header} for kind in ("qd_", "tau_")))


def number_in(path, line, name, field):
    field = field.strip()
    if not field:
        return math.nan
    try:
        value = read_number(field)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise BadFit(f"{path}: line {line}: expected a finite number of {name}, or an empty field for a gap, got {field!r}")
    return value


def read_csv(path, joints):
    try:
        rows, cut = rows_of(path)
    except (UnicodeDecodeError, csv.Error) as problem:
        raise BadFit(f"{path}: expected a CSV in UTF-8, got {problem}") from None
    header = [name.strip() for name in rows[0][1]] if rows else []
    time, angles, rates, torques = columns_of(path, header, joints)
    lines, table = [], []
    for line, row in rows[1:]:
        if not row:
            continue
        if len(row) != len(header):
            raise BadFit(f"{path}: line {line}: expected {len(header)} fields, got {len(row)}")
        lines.append(line)
        table.append([number_in(path, line, name, field) for name, field in zip(header, row)])
    table = np.array(table).reshape(-1, len(header))
    t = table[:, time]
    require_stamps(path, t, lambda k: f"line {lines[k]}")
    if len(t) < LEAST_SAMPLES:
        raise BadFit(f"{path}: expected at least {LEAST_SAMPLES} samples, got {len(t)}")
    measured = np.flatnonzero(np.isfinite(table[:, angles]).any(axis=1))
    kept = slice(measured[0], measured[-1] + 1) if len(measured) else slice(None)
    loads = {f"tau_{joint}": load for joint, k in torques.items()
             for load in [sampled_torque(path, joint, t - t[kept][0], table[:, k])] if load}
    table = table[kept]
    start = table[0, time]
    unknown = np.full(len(table), np.nan)
    qd = np.column_stack([table[:, rates[joint]] if joint in rates else unknown for joint in joints])
    recording = Recording(os.path.basename(path), table[:, time] - start, table[:, angles], qd, loads, start)
    recording.cut = cut
    return recording


def sampled_torque(path, joint, t, torque):
    """A load whose torque is linear between the samples. None if there is no torque."""
    for k in np.flatnonzero(np.isinf(torque))[:1]:
        raise BadFit(f"{path}: expected a finite torque of {joint}, or nan for a gap, got {torque[k]:g} at t = {t[k]:g} s")
    measured = np.isfinite(torque)
    if measured.sum() < 2:
        raise BadFit(f"{path}: expected torques of the joint {joint} in tau_{joint}, got {measured.sum()}")
    if not torque[measured].any():
        return None
    return {"joint": joint, "torque": 1.0, "times": t[measured].tolist(), "values": torque[measured].tolist()}


def from_arrays(values, joints, name):
    """values: a dict with t, q (N × n), optional qd (N × n), tau (N × n) and name."""
    unknown = set(values) - {"t", "q", "qd", "tau", "name"}
    if unknown or values.get("t") is None or values.get("q") is None:
        raise BadFit(f"{name}: expected a path, a Recording or a dict of t, q and, if known, qd, tau, name, got {', '.join(map(str, values))}")
    name = values.get("name", name)
    t = array_of(name, "t", values["t"])
    arrays = {key: array_of(name, key, values[key]) for key in ("q", "qd", "tau") if values.get(key) is not None}
    require_samples(name, t, arrays, joints)
    columns = zip(joints, arrays["tau"].T) if "tau" in arrays else ()
    loads = {f"tau_{joint}": load for joint, column in columns for load in [sampled_torque(name, joint, t - t[0], column)] if load}
    return Recording(name, t - t[0], arrays["q"], arrays.get("qd"), loads, t[0])


# ---- Laws of time, seen from a later instant ---------------------------------------------------


def moved_law(law, shift):
    """A sine or a curve of a law, or a load, whose time begins `shift` s later."""
    law = dict(law)
    if "frequency" in law:
        law["phase"] = math.remainder(float(law.get("phase", 0)) + 2 * math.pi * float(law["frequency"]) * shift, 2 * math.pi)
    if "times" in law:
        law["times"] = [float(t) - shift for t in law["times"]]
    return law


def moved_load(load, shift):
    """None if it is over."""
    load = moved_law(load, shift)
    if "stop" in load:
        load["stop"] = float(load["stop"]) - shift
        if load["stop"] <= 0:
            return None
    if "start" in load:
        load["start"] = max(float(load["start"]) - shift, 0.0)
    return load


def moved_loads(loads, shift):
    """The loads by name, moved in time, without those that are over."""
    return {name: moved for name, load in loads.items() for moved in [moved_load(load, shift)] if moved}


def moved_scene(values, shift):
    """The values of a scene whose time begins `shift` s later."""
    if shift == 0:
        return values
    values = dict(values)
    values["loads"] = moved_loads(values.get("loads") or {}, shift)
    if values.get("base"):
        values["base"] = {name: moved_law(law, shift) for name, law in values["base"].items()}
    pin = (values.get("tip") or {}).get("pin")
    if isinstance(pin, dict):
        values["tip"] = {**values["tip"], "pin": {name: moved_law(law, shift) for name, law in pin.items()}}
    values["links"] = dict(values["links"])
    for name, link in values["links"].items():
        drive = ((link or {}).get("joint") or {}).get("drive")
        if isinstance(drive, dict):
            values["links"][name] = {**link, "joint": {**link["joint"], "drive": moved_law(drive, shift)}}
    return values
