"""Recordings from a bag: joint_states; what the node took, from commands_taken; or the effort as the torque that was applied."""

import os

import numpy as np

from .commands import commanded
from .recordings import BadFit, Recording, require_stamps, sampled_torque
from .unread import full, opened, topics_of

FIELDS = "JOINT_TORQUE", "LINK_FORCE", "JOINT_TRAJECTORY", "BASE_TRAJECTORY"  # kinds of commands with one entry in the field of that name
JUMPS = ("RESET", "SET_STATE", "SETTLE")  # of the state
AGES = {kind: kind.lower() + "_age" for kind in ("JOINT_TORQUES", *FIELDS)}  # in a status


def read_bag(path, scene, joints, effort=False, node=None):
    """A list of recordings, without a jump of the state in any. scene: the values. effort: it is the torque that was applied, in
    column of commands."""
    with opened(path, BadFit) as (bag, messages_of):
        topic, below = topics_of(bag, path, node, BadFit)
        if below is None:
            require_no_commands(path, bag, node)
        states, statuses, taken = (messages_of(name, kind) for name, kind in (
            (topic, "sensor_msgs/JointState"), (below and below + "/status", "planar_chain/SimStatus"),
            (below and below + "/commands_taken", "planar_chain/CommandTaken")))
    stamps = np.array([state.header.stamp.to_nsec() for state in states], dtype=np.int64)
    require_stamps(path, stamps * 1e-9, lambda k: f"message {k + 1} of {topic}")
    columns = {field: column_of(path, topic, states, joints, field) for field in ("position", "velocity", "effort")}
    if columns["position"] is None:
        raise BadFit(f"{path}: expected positions on {topic}, got none")
    if effort and columns["effort"] is None:
        raise BadFit(f"{path}: expected an effort on {topic}, got none")
    require_one_run(path, below, statuses, taken)
    pieces, left_out = pieces_of(path, stamps, statuses, taken)
    recordings = []
    for k, (inside, t, commands) in enumerate(pieces):
        name = os.path.basename(path) + (f", piece {k + 1}" if len(pieces) > 1 else "")
        q, qd, torque = (None if column is None else column[inside] for column in columns.values())
        loads = commanded(name, scene, joints, commands, t[0]) if not effort else {
            f"tau_{joint}": load for joint, column in zip(joints, torque.T) for load in [sampled_torque(name, joint, t - t[0], column)] if load}
        recordings.append(Recording(name, t - t[0], q, qd, loads, t[0]))
        recordings[-1].is_piece = len(pieces) > 1
    recordings[-1].cut = left_out
    return recordings


def require_no_commands(path, bag, node):
    """Refuses commands of a node without a status: its scene's time and the jumps of its state are unknown."""
    for topic, about in bag.get_type_and_topic_info().topics.items():
        its = full(topic).rpartition("/")[0]
        if about.msg_type == "planar_chain/CommandTaken" and (node is None or full(node.rstrip("/")) == its):
            raise BadFit(f"{path}: expected a status of {its} beside its commands_taken, got none")


def column_of(path, topic, states, joints, field):
    """states × joints, or None if the field is empty."""
    if not states or not any(getattr(state, field) for state in states):
        return None
    values = np.empty((len(states), len(joints)))
    columns = {}
    for k, state in enumerate(states):
        names = tuple(state.name)
        if names not in columns:
            missing = [joint for joint in joints if joint not in names]
            if missing:
                raise BadFit(f"{path}: expected the joints {', '.join(missing)} on {topic}, got {', '.join(names) or 'none'}")
            columns[names] = [names.index(joint) for joint in joints]
        row = getattr(state, field)
        if len(row) != len(names):
            raise BadFit(f"{path}: message {k + 1} of {topic}: expected {len(names)} numbers in {field}, got {len(row)}")
        values[k] = [row[column] for column in columns[names]]
    for k, j in np.argwhere(~np.isfinite(values))[:1]:
        raise BadFit(f"{path}: message {k + 1} of {topic}: expected a finite {field} of {joints[j]}, got {values[k, j]:g}")
    return values


# ---- The node's time ---------------------------------------------------------------------------


def ticks_of(path, stamps, statuses):
    """The tick of each state. A status gives a tick and its stamp; each state is one tick more. Stamps jump over a pause."""
    known = {status.tick_stamp.to_nsec(): status.tick for status in statuses}
    anchors = [(k, known[stamp]) for k, stamp in enumerate(stamps.tolist()) if stamp in known]
    if not anchors:
        raise BadFit(f"{path}: expected a status of the node for some of its states, got none")
    period = np.median(np.diff(stamps))
    steps = np.ones(len(stamps) - 1, dtype=np.int64)
    for (k, tick), (after, tick_after) in zip(anchors, anchors[1:]):
        if tick_after - tick != after - k:  # messages were lost
            steps[k:after] = np.round(np.diff(stamps[k:after + 1]) / period)
            if tick_after <= tick:
                raise BadFit(f"{path}: expected ticks of its status that do not go back, got {tick_after} after {tick}")
            if steps[k:after].sum() != tick_after - tick:
                raise BadFit(f"{path}: expected {tick_after - tick} states from tick {tick} on, got {after - k}")
    ticks = np.concatenate([[0], np.cumsum(steps)])
    return ticks + anchors[0][1] - ticks[anchors[0][0]]


def pieces_of(path, stamps, statuses, taken):
    """For each piece between jumps of the state: its states, their times and the commands since the last reset; and a sentence
    on those that are left out.

    With a status, the time is the scene's; else it is that of the stamps, from 0."""
    if not statuses:
        return [(slice(0, len(stamps)), (stamps - stamps[0]) * 1e-9, [])], ""
    require_all(path, taken)
    require_last(path, statuses, taken)
    ticks = ticks_of(path, stamps, statuses)
    edges = [0, *sorted({message.tick for message in taken if kind_of(message) in JUMPS}), np.iinfo(np.int64).max]
    pieces, without = [], []  # without a status: of so many states
    for first, last in zip(edges, edges[1:]):
        inside = slice(*np.searchsorted(ticks, [first, last]))
        times = {status.tick: status.scene_time for status in statuses if first <= status.tick < last and status.tick_stamp.to_nsec()}
        if inside.stop - inside.start < 2:
            continue
        if not times:
            without.append(inside.stop - inside.start)
            continue
        low, high = min(times), max(times)
        period = (times[high] - times[low]) / (high - low) if high > low else np.median(np.diff(stamps)) * 1e-9
        t = times[low] + (ticks[inside] - low) * period
        before = [message for message in taken if message.tick <= ticks[inside.stop - 1]]
        resets = [k for k, message in enumerate(before) if kind_of(message) == "RESET"]
        pieces.append((inside, t, before[resets[-1] + 1 if resets else 0:]))
    if not pieces:
        raise BadFit(f"{path}: expected states between the jumps of the state, got none")
    left_out = (f"{os.path.basename(path)}: {len(without)} of {len(pieces) + len(without)} pieces, of {sum(without)} states, hold no "
                "status and are left out: raise publish/status_rate") if without else ""
    return pieces, left_out


def kind_of(message):
    return next((name for name in ("JOINT_TORQUES", *FIELDS, "CLEAR_COMMANDS", "SET_STATE", "STEP", "RESET", "SETTLE", "TOLERANCE")
                 if getattr(message, name) == message.kind), "")


def require_one_run(path, node, statuses, taken):
    """Refuses what a node that was started again numbers anew, as recorded_commands.cpp does."""
    numbered = [(f"its status {status.header.seq}", status.tick, status.header.stamp) for status in statuses if status.header.seq > 0]
    numbered += [(f"its command {command.number}", command.tick, k) for k, command in enumerate(taken)]
    seen = {}
    for name, *now in numbered:
        before = seen.setdefault(name, now)
        if before != now:
            raise BadFit(f"{path}: expected one run of {node}, got a second one: {name} is of tick {before[0]} and of tick {now[0]} "
                         "(the node was started again; record each run in a bag of its own)")


def require_all(path, taken):
    for expected, message in enumerate(taken, 1):
        if message.number != expected:
            changed = " (a reset that changes the scene skips a number: what follows belongs to another scene)" * (
                kind_of(message) == "RESET" and message.number == expected + 1)
            raise BadFit(f"{path}: expected every command that the node took since its start, got number {message.number} "
                         f"where {expected} is due{changed}")
        kind = kind_of(message)
        if not kind or not np.isfinite(message.scene_time) or any(len(getattr(message, name.lower())) != (name == kind) for name in FIELDS):
            raise BadFit(f"{path}: expected commands with what their kind needs, got number {expected} of kind {message.kind}")


def require_last(path, statuses, taken):
    """A status tells the age of the last command of each kind. It is missing if the recorder lost it at the end."""
    for kind, age in AGES.items():
        steps = [message for message in taken if kind_of(message) == "STEP"]
        of_steps = {"JOINT_TORQUES": "joint_torques", "BASE_TRAJECTORY": "base_pose"}.get(kind)
        times = np.sort([message.scene_time for message in taken if kind_of(message) == kind] +
                        [message.scene_time for message in steps if of_steps and getattr(message, of_steps)])
        for status in statuses:
            if not getattr(status, age) > 0:
                continue
            accepted = status.scene_time - getattr(status, age)
            if not (abs(times - accepted) <= 1e-9 * max(1, status.scene_time)).any():
                raise BadFit(f"{path}: expected every command that the node took, got none of kind {kind} at {accepted:.9g} s, which its "
                             f"status at {status.scene_time:.9g} s tells of (record ~commands_taken to the end)")
