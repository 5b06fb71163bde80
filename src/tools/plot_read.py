"""What plot reads: a motion from a CSV of `simulate` or from a bag, runs from a CSV of `sweep`."""

import csv

import numpy as np
from chain import NoChain, read_chain
from drawing.body import Body, base_under
from drawing.track import Track
from files import tree_of
from plot_runs import Runs
from plot_signals import REFERENCE, SENSOR, Ticks, commands_of, measured, scene_times
from program import say
from unread import full, opened, topics_of
from user_input import read_number, rows_of

LARGEST = 1e300  # of larger numbers, matplotlib cannot find the height of an axis


class Refused(Exception):
    """A fault of the input: where, what was expected, what was found."""


class Motion:
    """t: time of each state; q, qd, effort: one column for each joint. events: {k: name} where the motion is not
    continuous between the states k - 1 and k. energy: times and curves by name. balance, error: times and values.
    prismatic: names of the joints whose q is in m; None if that is not known. body: what is drawn of its scene, None if that is not known.
    rounding: the error estimate that the rounding of an angle makes. scene_time: the t of the scene's loads at each state.
    first: x, y, angle of the first link's centre of mass, m, rad, one row for each state. effort, energy, balance, error
    and first may be None. signals: of plot_signals. imus: times, angular rate (rad/s), acceleration (m/s², 2 columns) by name."""

    def __init__(self, joints, t, q, qd, effort=None):
        self.joints, self.t, self.q, self.qd, self.effort = joints, t, q, qd, effort
        self.energy = self.balance = self.error = self.first = self.prismatic = self.body = self.scene_time = None
        self.events, self.rounding, self.signals, self.imus = {}, 0.0, [], {}

    def know(self, body):
        self.body, self.prismatic = body, [name for name, axis in zip(body.joints, body.axis) if axis != 0]

    def track(self, body):
        """The motion of this body, to be drawn."""
        base = base_under(body, self.first, body.com[0], self.q) if body.moves else None
        return Track(body, self.t, self.q, base, self.scene_time, self.events)

    def cut(self, first, last):
        """Leaves what is from `first` to `last`, s."""
        kept = (self.t >= first) & (self.t <= last)
        before = np.cumsum(kept) - kept
        self.events = {int(before[k]): name for k, name in self.events.items() if kept[k] and before[k] > 0}
        for name in ("q", "qd", "effort", "first", "scene_time", "t"):
            if getattr(self, name) is not None:
                setattr(self, name, getattr(self, name)[kept])
        for name in ("balance", "error"):
            if getattr(self, name):
                t, values = getattr(self, name)
                setattr(self, name, (t[(t >= first) & (t <= last)], values[(t >= first) & (t <= last)]))
        if self.energy:
            t, parts = self.energy
            inside = (t >= first) & (t <= last)
            self.energy = t[inside], {name: part[inside] for name, part in parts.items()}
        self.signals = [part for part in (signal.between(first, last) for signal in self.signals) if part is not None]
        self.imus = {name: tuple(each[(imu[0] >= first) & (imu[0] <= last)] for each in imu) for name, imu in self.imus.items()}

    def curves(self, j, wrap=False):
        """t, q, q̇, τ of a joint, with NaN where lines must not join them. wrap: q in (−π, π]."""
        q, breaks = self.q[:, j], set(self.events)
        if wrap and self.joints[j] not in (self.prismatic or ()):
            q = q - 2 * np.pi * np.ceil((q - np.pi) / (2 * np.pi))
            breaks |= set(np.flatnonzero(abs(np.diff(q)) > np.pi) + 1)
        effort = np.zeros(len(q)) if self.effort is None else self.effort[:, j]
        return np.insert(np.array([self.t, q, self.qd[:, j], effort]), sorted(breaks), np.nan, axis=1)

    def broken(self, t, values):
        """The curve of values at other times, with gaps where lines must not join them."""
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
    motion.scene_time = motion.t
    motion.energy = motion.t, {"T + V, less that of the start": table[:, -1] - table[0, -1]}
    return motion


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
    by_status = Ticks(stamps, statuses)
    for tick, name in ticks:
        k = by_status.state_of(tick)
        if k:
            events[k] = f"{events[k]}, {name.lower()}" if k in events else name.lower()
    return events


def since_jump(messages):
    """The messages as they were published: rosbag sorts by the time of receipt, which goes back with the clock. If the clock went back,
    only those after that."""
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
        others = {(topic, about.msg_type): since_jump(messages_of(topic, about.msg_type))
                  for topic, about in bag.get_type_and_topic_info().topics.items() if is_signal(topic, about.msg_type, below)}
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

    def since_start(times):
        return np.array([(time - states[0].header.stamp).to_sec() for time in times])

    motion = Motion(names, since_start(times_of(states)), *fields_of(path, states, "position", "velocity", *["effort"] * (efforts > 0)))
    motion.events = events_of(stamps, statuses, taken)
    motion.scene_time = scene_times(motion.t, statuses, since_start, motion.events)
    timeout = 0.0
    if scenes:
        motion.know(body_of(path, scenes[0].data))
        timeout = (tree_of(scenes[0].data) or {}).get("command_timeout") or 0.0
    links = [message for message in links if message.pose]
    if links:
        poses = np.array([(pose.x, pose.y, pose.theta) for pose in (message.pose[0] for message in links)])
        motion.first = np.column_stack([np.interp(motion.t, since_start(times_of(links)), column) for column in poses.T])
    add_statuses(path, motion, [status for status in statuses if not status.standstill], since_start)
    motion.signals = commands_of(taken, names, motion.t, Ticks(stamps, statuses), float(timeout))
    for (topic, kind), messages in others.items():
        if messages and kind == "sensor_msgs/Imu":
            motion.imus[topic.rpartition("/")[2]] = (since_start(times_of(messages)), np.array([each.angular_velocity.z for each in messages]), np.array(
                [(each.linear_acceleration.x, each.linear_acceleration.y) for each in messages]))
        elif messages and topic != states_topic:
            is_sensor = below and full(topic).startswith(full(below) + "/")
            motion.signals += measured(SENSOR if is_sensor else REFERENCE, messages, names, since_start(times_of(messages)))
    return motion


def is_signal(topic, kind, below):
    """True for topics of the node's sensors, and those that may be followed; not for the states of another node."""
    return (kind == "sensor_msgs/JointState" and not full(topic).endswith("/joint_states")
            or kind == "sensor_msgs/Imu" and bool(below) and full(topic).startswith(full(below) + "/"))


def times_of(messages):
    return [message.header.stamp for message in messages]


def fields_of(path, messages, *fields):
    values = [np.array([getattr(message, field) for message in messages]) for field in fields]
    for field, each in zip(fields, values):
        require_drawable(path, field, each)
    return values


def body_of(path, text):
    """The body of a recorded scene."""
    try:
        return Body(read_chain("/dev/stdin", text))
    except NoChain as problem:
        raise Refused(f"{path}: the scene is refused:\n" + str(problem).replace("/dev/stdin: ", "").replace("/dev/stdin:", "line ")) from problem


def add_statuses(path, motion, running, since_start):
    if not running:
        return
    t = since_start(times_of(running))
    parts = fields_of(path, running, "kinetic", "potential", "work_supplied", "dissipated", "energy_balance", "error_estimate")
    motion.energy = t, dict(zip(("T", "V", "supplied", "dissipated"), parts))
    motion.balance, motion.error = (t, parts[4]), (t, parts[5])
    loosest = max(status.tolerance for status in running)  # 0: a fixed step has no error estimate
    motion.rounding = np.finfo(float).eps * max(1.0, abs(motion.q).max()) / loosest if loosest else 0.0
