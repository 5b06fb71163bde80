"""Commands, references and sensors of a bag, to be drawn beside the states. For plot."""

import numpy as np

COMMAND, REFERENCE, SENSOR = "command", "reference", "sensor"
Q, RATE, TORQUE = 1, 2, 3  # the panels, as in the curves of a Motion


class Signal:
    """kind: of the three above. panel: where it belongs. t, values: of this joint; NaN is a gap."""

    def __init__(self, kind, joint, panel, t, values):
        self.kind, self.joint, self.panel = kind, joint, panel
        self.t, self.values = np.asarray(t, dtype=float), np.asarray(values, dtype=float)

    def between(self, first, last):
        """What is from `first` to `last`, s, with what a command holds at the first; None if that is nothing."""
        kept = (self.t >= first) & (self.t <= last)
        t, values = self.t[kept], self.values[kept]
        held = np.flatnonzero(self.t < first)[-1:]
        if self.kind == COMMAND and len(held) and (len(t) or self.t[-1] > last):
            value = self.values[held[0]]
            t, values = np.insert(t, 0, first), np.insert(values, 0, value)
        return Signal(self.kind, self.joint, self.panel, t, values) if len(t) else None


class Ticks:
    """Which state belongs to a tick, from statuses: `known` has pairs of tick and number of the state."""

    def __init__(self, stamps, statuses):
        period = np.median(np.diff(stamps))
        self.known = [(status.tick, k) for status in statuses for k in [np.argmin(abs(stamps - status.tick_stamp.to_sec()))]
                      if abs(stamps[k] - status.tick_stamp.to_sec()) < period / 2]
        self.count = len(stamps)

    def state_of(self, tick):
        """Its number; None if it was not recorded."""
        if not self.known:
            return None
        nearest, k = min(self.known, key=lambda pair: abs(pair[0] - tick))
        k += int(tick) - int(nearest)
        return k if 0 <= k < self.count else None


def scene_times(t, statuses, since_start, events):
    """The t of the scene's loads at each state, NaN where no status tells it. events: numbers of states."""
    found = np.full(len(t), np.nan)
    edges = [0, *sorted(events), len(t)]
    seen = since_start([status.tick_stamp for status in statuses])
    ahead = np.array([status.scene_time for status in statuses]) - seen
    for first, last in zip(edges, edges[1:]):
        inside = ahead[(seen >= t[first] - 1e-6) & (seen <= t[last - 1] + 1e-6)]
        if len(inside):
            found[first:last] = t[first:last] + np.median(inside)
    return found


def commands_of(taken, joints, t, ticks, timeout):
    """Signals from the messages on commands_taken: the commanded torque of each joint, and trajectories. timeout: s, of held torques."""
    steps = {joint: [] for joint in joints}  # (time, what is held from then on or None, what is added)
    signals = []
    for message in taken:
        k = ticks.state_of(message.tick)
        if k is None:
            continue
        start = t[k] + max(message.start - message.scene_time, 0)
        if message.kind in (message.JOINT_TORQUES, message.STEP):
            for joint, torque in zip(joints, message.joint_torques):
                steps[joint].append((t[k], torque, 0.0))
        elif message.kind == message.JOINT_TORQUE:
            for command in message.joint_torque:
                parts = steps.get(command.joint, [])
                if command.duration > 0:
                    parts += [(start, None, command.torque), (start + command.duration, None, -command.torque)]
                else:
                    parts.append((start, command.torque, 0.0))
        elif message.kind in (message.CLEAR_COMMANDS, message.RESET):
            for parts in steps.values():
                parts[:] = [part for part in parts if part[0] < t[k]]
                parts.append((t[k], 0.0, -sum(added for _, _, added in parts)))
        elif message.kind == message.JOINT_TRAJECTORY:
            signals += trajectory(message.joint_trajectory[0], start)
    return [stepped(joint, parts, t[-1], timeout) for joint, parts in steps.items() if any(held or added for _, held, added in parts)] + signals


def stepped(joint, parts, last, timeout):
    """The sum of what is held and added, as a line with steps up to the time `last`."""
    held = sorted(part for part in parts if part[1] is not None)
    ends = [(start + timeout, 0.0, 0.0) for (start, *_), (after, *_) in zip(held, held[1:] + [(np.inf, 0, 0)]) if timeout and start + timeout < after]
    times, values, now, sum_added = [], [], 0.0, 0.0
    for start, value, added in sorted([*parts, *ends], key=lambda part: part[0]):
        times += [start, start]
        values.append(now + sum_added)
        now, sum_added = now if value is None else value, sum_added + added
        values.append(now + sum_added)
    return Signal(COMMAND, joint, TORQUE, [*times, max(last, times[-1])], [*values, values[-1]])


def trajectory(message, start):
    for j, joint in enumerate(message.joint_names):
        yield Signal(REFERENCE, joint, Q, [start + point.time_from_start.to_sec() for point in message.points],
                     [point.positions[j] for point in message.points])


def measured(kind, messages, joints, t):
    """Signals from messages sensor_msgs/JointState at these times: of an encoder, or of what a controller follows."""
    for j in [j for j, joint in enumerate(messages[0].name) if joint in joints]:
        for panel, field in ((Q, "position"), (RATE, "velocity"), (TORQUE, "effort")):
            if all(len(getattr(message, field)) == len(message.name) for message in messages):
                yield Signal(kind, messages[0].name[j], panel, t, [getattr(message, field)[j] for message in messages])
