"""What plot reads: a motion from a CSV of `simulate` or from a bag, runs from a CSV of `sweep`."""

import csv

import numpy as np
from chain import NoChain, read_chain
from user_input import read_number, rows_of
from plot_runs import Runs
from program import say
from unread import opened, topics_of

LARGEST = 1e300  # of larger numbers, matplotlib cannot find the height of an axis


class Refused(Exception):
    """A fault of the input: where, what was expected, what was found."""


class Motion:
    """t: time of each state; q, qd, effort: one column for each joint. events: {k: name} where the motion is not
    continuous between the states k - 1 and k. energy: times and curves by name. balance, error: times and values.
    prismatic: names of the joints whose q is in m; None if that is not known.
    rounding: the error estimate that the rounding of an angle makes.
    first: x, y, angle of the first link's centre of mass, m, rad, one row for each state. effort, energy, balance, error
    and first may be None."""

    def __init__(self, joints, t, q, qd, effort=None):
        self.joints, self.t, self.q, self.qd, self.effort = joints, t, q, qd, effort
        self.energy = self.balance = self.error = self.first = self.prismatic = None
        self.events, self.rounding = {}, 0.0

    def curves(self, j, wrap=False):
        """t, q, q̇, τ of a joint, with NaN where lines must not join them. wrap: q in (−π, π]."""
        q, breaks = self.q[:, j], set(self.events)
        if wrap and self.joints[j] not in (self.prismatic or ()):
            q = q - 2 * np.pi * np.ceil((q - np.pi) / (2 * np.pi))
            breaks |= set(np.flatnonzero(abs(np.diff(q)) > np.pi) + 1)
        effort = np.zeros(len(q)) if self.effort is None else self.effort[:, j]
        return np.insert(np.array([self.t, q, self.qd[:, j], effort]), sorted(breaks), np.nan, axis=1)

    def broken(self, t, values):
        """The same for values at other times."""
        places = np.searchsorted(t, [(self.t[k - 1] + self.t[k]) / 2 for k in sorted(self.events)])
        return np.insert(t, places, np.nan), np.insert(values, places, np.nan)


# ---- Reading -----------------------------------------------------------------------------------


def require_file(path):
    try:
        with open(path, "rb"):
            pass
    except OSError as problem:
        raise Refused(f"{path}: expected a .csv or .bag that can be read, got nothing: {problem.strerror}") from problem


def require_times(path, what, t):
    """what: has a time, such as a row."""
    if len(t) < 2:
        raise Refused(f"{path}: expected two states or more, got {len(t)}")
    for k in np.flatnonzero(~(np.diff(t) > 0))[:1] + 1:
        raise Refused(f"{path}, {what} {k + 1}: expected a time after {t[k - 1]:.12g} s, got {t[k]:.12g} s")


def require_drawable(path, name, values):
    beyond = values[abs(values) > LARGEST]  # NaN is a gap
    if len(beyond):
        raise Refused(f"{path}, {name}: expected numbers up to {LARGEST:g}, got {beyond[0]:g}")


def read_rows(path):
    try:
        rows, cut = rows_of(path)
        if cut:
            say(f"note: {cut}")
        return [row for _, row in rows]
    except (UnicodeDecodeError, csv.Error) as problem:
        raise Refused(f"{path}: expected a table in text, got other bytes ({problem})") from problem


def numbers_of(path, header, rows, texts=0):
    """The numbers of rows that have as many cells as the header has names. The last `texts` cells are text."""
    last = len(header) - texts
    table = np.empty((len(rows), last))
    for k, row in enumerate(rows):
        try:
            if len(row) != len(header):
                raise ValueError(f"{len(row)} cells")
            table[k] = [read_number(cell) for cell in row[:last]]
        except ValueError as problem:
            raise Refused(f"{path}, row {k + 1}: expected {last} numbers{' and a reason' if texts else ''}, got {problem}") from problem
    for name, column in zip(header, table.T):
        require_drawable(path, name, column)
    return table


def read_csv(path):
    header, *rows = read_rows(path) or [[]]
    joints = [name[2:] for name in header if name.startswith("q_")]
    if Runs.are_in(header) and joints:
        if not np.isfinite(numbers_of(path, header, rows, texts=1)[:, header.index("t")]).any():
            raise Refused(f"{path}: expected runs with finite times t, got none")
        return Runs(header, rows)
    if not joints or len(set(header)) < len(header) or header != ["t", *("q_" + j for j in joints), *("qd_" + j for j in joints), "energy"]:
        raise Refused(f"{path}: expected the columns t, q_<joint>…, qd_<joint>…, energy, each once, got "
                      f"{', '.join(header)[:80] or 'nothing'}")
    table = numbers_of(path, header, rows)
    unknown = np.isnan(table)  # throughout: left out
    for row, column in np.argwhere(unknown & ~unknown.all(axis=0))[:1]:
        raise Refused(f"{path}, row {row + 1}, {header[column]}: expected a number, got nan")
    require_times(path, "row", table[:, 0])
    n = len(joints)
    motion = Motion(joints, table[:, 0], table[:, 1:n + 1], table[:, n + 1:2 * n + 1])
    motion.energy = motion.t, {"T + V, less that of the start": table[:, -1] - table[0, -1]}
    return motion


def prismatic_in(chain):
    return [link["joint"]["name"] for link in chain["links"] if "axis" in link["joint"]]


def events_of(stamps, statuses, taken):
    """stamps: of the states, s. taken: the messages on commands_taken, if it was recorded."""
    period = np.median(np.diff(stamps))
    events = {}
    for k in np.flatnonzero(np.diff(stamps) > 1.5 * period) + 1:
        within = [status for status in statuses if stamps[k - 1] < status.header.stamp.to_sec() < stamps[k]]
        events[k] = ("fault" if any(status.fault for status in within) else
                     "pause" if any(status.paused for status in within) else "gap")

    # The first tick of each. A reset begins the scene's time at 0: without commands_taken, that is seen if it lies after the status
    # before. A settle shifts the time by one tick.
    ticks = [(message.tick, name) for message in taken for name in ("RESET", "SET_STATE", "SETTLE") if message.kind == getattr(message, name)]
    if not taken:
        ticks = [(start, "RESET") for before, status in zip(statuses, statuses[1:]) if 0 < status.scene_time < 2 ** 32
                 for start in [status.tick - round(status.scene_time / period)] if start > before.tick]
    # Its state: a status says when its tick was.
    known = [(status.tick, k) for status in statuses for k in [np.argmin(abs(stamps - status.tick_stamp.to_sec()))]
             if abs(stamps[k] - status.tick_stamp.to_sec()) < period / 2]
    for tick, name in ticks if known else ():
        nearest, k = min(known, key=lambda pair: abs(pair[0] - tick))  # pylint: disable=cell-var-from-loop
        k += tick - nearest
        if 0 < k < len(stamps):
            events[k] = f"{events[k]}, {name.lower()}" if k in events else name.lower()
    return events


def since_jump(messages):
    """As they were published: rosbag sorts by the time of receipt, which goes back with the clock. Of a motion whose clock went back, what
    came after that."""
    if len({message.header.seq for message in messages}) == len(messages):
        messages = sorted(messages, key=lambda message: message.header.seq)
    stamps = [message.header.stamp for message in messages]
    back = [k for k in range(1, len(stamps)) if stamps[k] < stamps[k - 1]]
    return messages[back[-1]:] if back and len(stamps) - back[-1] > 1 else messages


def read_bag(path, node):
    with opened(path, Refused) as (bag, messages_of):
        states_topic, below = topics_of(bag, path, node, Refused)
        states = messages_of(states_topic, "sensor_msgs/JointState")
        statuses, taken, links, scenes = (messages_of(below and f"{below}/{name}", kind) for name, kind in (
            ("status", "planar_chain/SimStatus"), ("commands_taken", "planar_chain/CommandTaken"),
            ("link_states", "planar_chain/LinkStates"), ("scene", "std_msgs/String")))
    recorded = len(states)
    states, statuses, links = map(since_jump, (states, statuses, links))
    if len(states) < recorded:
        say(f"note: {path}: the clock went back; only the {len(states)} states after that are drawn, of {recorded}")
    stamps = np.array([state.header.stamp.to_sec() for state in states])
    require_times(path, f"message of {states_topic}", stamps)

    names, efforts = list(states[0].name), len(states[0].effort)  # robots may have none
    if not names or efforts not in (0, len(names)) or any(
            list(state.name) != names or not len(state.position) == len(state.velocity) == len(names) or len(state.effort) != efforts for state in states):
        raise Refused(f"{path}, {states_topic}: expected an angle, a rate and perhaps an effort of the same joints in each state, got others")

    def of(messages, *fields):
        values = [np.array([getattr(message, field) for message in messages]) for field in fields]
        for field, each in zip(fields, values):
            require_drawable(path, field, each)
        return values

    def since_start(messages):
        return np.array([(message.header.stamp - states[0].header.stamp).to_sec() for message in messages])

    motion = Motion(names, since_start(states), *of(states, "position", "velocity", *["effort"] * (efforts > 0)))
    motion.events = events_of(stamps, statuses, taken)
    if scenes:
        try:
            motion.prismatic = prismatic_in(read_chain("/dev/stdin", scenes[0].data))
        except NoChain as problem:
            raise Refused(f"{path}: the scene is refused:\n" + str(problem).replace("/dev/stdin: ", "").replace("/dev/stdin:", "line ")) from problem
    links = [message for message in links if message.pose]
    if links:
        poses = np.array([(pose.x, pose.y, pose.theta) for pose in (message.pose[0] for message in links)])
        motion.first = np.column_stack([np.interp(motion.t, since_start(links), column) for column in poses.T])
    running = [status for status in statuses if not status.standstill]
    if running:
        t = since_start(running)
        parts = of(running, "kinetic", "potential", "work_supplied", "dissipated", "energy_balance", "error_estimate")
        motion.energy = t, dict(zip(("T", "V", "supplied", "dissipated"), parts))
        motion.balance, motion.error = (t, parts[4]), (t, parts[5])
        loosest = max(status.tolerance for status in running)  # 0: a fixed step has no error estimate
        motion.rounding = np.finfo(float).eps * max(1.0, abs(motion.q).max()) / loosest if loosest else 0.0
    return motion
