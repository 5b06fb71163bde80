"""The commands that a node took, as loads of a scene: exact, from start to end."""

import math

from .recordings import BadFit, moved_load

FOREVER = math.inf


def commanded(name, scene, joints, taken, since):
    """Loads by name, in a time whose 0 is the scene's time `since`. taken: CommandTaken messages in order. scene: the values.

    A target is ("joint" or "link", its name). A command held on it lasts until the next, or for the scene's command_timeout."""
    timeout = float(scene.get("command_timeout") or 0) or FOREVER
    held, acting = [], []  # (target, action, start, stop)
    for message in taken:
        t = message.scene_time
        if message.base_pose or message.kind in (message.JOINT_TRAJECTORY, message.BASE_TRAJECTORY):
            raise BadFit(f"{name}: expected commands of torques and forces, got a trajectory or a motion of the base at {t:g} s, "
                         "which fit does not take")
        if message.kind == message.CLEAR_COMMANDS:
            acting = [(target, action, start, min(stop, t)) for target, action, start, stop in acting + in_turn(held)]
            held = []
        elif message.kind in (message.JOINT_TORQUES, message.STEP):
            if len(message.joint_torques) not in (len(joints), 0 if message.kind == message.STEP else len(joints)):
                raise BadFit(f"{name}: expected {len(joints)} joint_torques of a command, got {len(message.joint_torques)} at {t:g} s")
            held += [(("joint", joint), {"torque": torque}, t, t + timeout) for joint, torque in zip(joints, message.joint_torques)]
        elif message.kind in (message.JOINT_TORQUE, message.LINK_FORCE):
            command, target, action = of_one(message)
            given = t if command.start.is_zero() else message.start
            if command.duration > 0:
                acting.append((target, action, max(given, t), given + command.duration))
            else:
                held.append((target, action, max(given, t), given + timeout))
    acting += in_turn(held)
    require_no_motors(name, scene, acting)
    limits = effort_limits(scene, joints)
    is_limited = [target[0] == "joint" and target[1] in limits for target, *_ in acting]
    loads = [load_of(*one) for one, limited in zip(acting, is_limited) if not limited]
    for joint, limit in limits.items():
        loads += cut_off([one for one in acting if one[0] == ("joint", joint)], joint, limit)
    moved = (moved_load(load, since) for load in loads if load["start"] < load.get("stop", FOREVER))
    return {f"command_{k}": load for k, load in enumerate(load for load in moved if load)}


def in_turn(held):
    """Each lasts until the next one in its target starts. Those that are nothing are left out."""
    ended = []
    for target in dict.fromkeys(target for target, *_ in held):
        turn = sorted((one for one in held if one[0] == target), key=lambda one: one[2])
        for (_, action, start, stop), after in zip(turn, turn[1:] + [(None, None, FOREVER, FOREVER)]):
            if any(map(any_number, action.values())):
                ended.append((target, action, start, min(stop, after[2])))
    return ended


def any_number(value):
    return any(value) if isinstance(value, list) else bool(value)


def of_one(message):
    if message.joint_torque:
        command = message.joint_torque[0]
        return command, ("joint", command.joint), {"torque": command.torque}
    command = message.link_force[0]
    action = {"force": [command.force.x, command.force.y], "point": [command.point.x, command.point.y], "moment": command.moment}
    return command, ("link", command.link), action


def load_of(target, action, start, stop):
    load = {target[0]: target[1], **action, "start": max(start, 0.0)}
    return load if stop == FOREVER else {**load, "stop": stop}


def require_no_motors(name, scene, acting):
    for link, values in scene["links"].items():
        found = [key for key in ("motor", "command_delay") if key in (values.get("joint") or {})]
        if found and any(target[0] == "joint" for target, *_ in acting):
            raise BadFit(f"{name}: expected no links/{link}/joint/{found[0]} beside recorded commands (fit takes recorded torques)")


def effort_limits(scene, joints):
    """The effort limits by joint. Repeated links share theirs."""
    limits, k = {}, 0
    for link in scene.get("chain") or ():
        values = scene["links"][link]
        for _ in range(int(values.get("repeat", 1))):
            limit = (values.get("joint") or {}).get("effort_limit")
            if limit is not None:
                limits[joints[k]] = float(limit)
            k += 1
    return limits


def cut_off(acting, joint, limit):
    """Loads of the sum of these torques, which is cut off at ± limit."""
    edges = sorted({edge for _, _, start, stop in acting for edge in (max(start, 0.0), stop) if edge < FOREVER})
    for start, stop in zip(edges, edges[1:] + [FOREVER]):
        torque = sum(action["torque"] for _, action, begin, end in acting if begin <= start < end)
        if torque:
            yield load_of(("joint", joint), {"torque": max(-limit, min(limit, torque))}, start, stop)
