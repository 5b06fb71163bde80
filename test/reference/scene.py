"""Reads a scene (config/README.md) into plain values, apart from the program's own reader.

Numbers stay the doubles that the program sees; the scripts of this folder take them over exactly into
wider arithmetic. No checks: these scenes are known to be right.
"""

import math
from types import SimpleNamespace

import yaml


def read(path):
    with open(path, encoding="utf-8") as text:
        tree = yaml.safe_load(text)
    scene = SimpleNamespace(
        gravity=[float(g) for g in tree.get("gravity", [0.0, -9.81])], links=[], loads=[],
        tip=(tree.get("tip") or {}).get("pin"),
        base=[motion_law(tree.get("base", {}).get(key)) for key in ("x", "y", "angle")])

    # The chain, from the ground outwards; `repeat` unrolled.
    link_index, joint_index = {}, {}
    for name in tree["chain"]:
        for copy in copies(name, tree["links"][name]):
            link_index[copy.name] = joint_index[copy.joint] = len(scene.links)
            scene.links.append(copy)

    for name, keys in (tree.get("loads") or {}).items():
        link = link_index[keys["link"]] if "link" in keys else None
        at_com = scene.links[link].com if link is not None else [0.0, 0.0]
        scene.loads.append(SimpleNamespace(
            name=name,
            link=link,
            force=[float(x) for x in keys.get("force", [0, 0])],
            point=[float(x) for x in keys.get("point", at_com)],
            moment=float(keys.get("moment", 0)),
            joint=joint_index[keys["joint"]] if "joint" in keys else None,
            torque=float(keys.get("torque", 0)),
            law=time_law(keys),
            start=float(keys.get("start", 0)),
            stop=float(keys.get("stop", math.inf))))
    return scene


def copies(name, keys):
    count = keys.get("repeat", 1)
    joint = keys.get("joint", {})
    initial = keys.get("initial", {})
    for number in range(1, count + 1):
        own = name if count == 1 else f"{name}_{number}"
        yield SimpleNamespace(
            name=own,
            joint=joint.get("name", f"{own}_joint"),
            mass=float(keys["mass"]),
            inertia=float(keys["inertia"]),
            com=[float(x) for x in keys["com"]],
            pin=[float(x) for x in keys["pin"]],
            stiffness=float(joint.get("stiffness", 0)),
            damping=float(joint.get("damping", 0)),
            rest_angle=float(joint.get("rest_angle", 0)),
            rotor_inertia=float(joint.get("rotor_inertia", 0)),
            friction=float(joint.get("friction", 0)),
            breakaway=float(joint.get("breakaway", joint.get("friction", 0))),
            drive=motion_law(joint["drive"]) if "drive" in joint else None,
            angle=float(initial.get("angle", 0)),
            velocity=float(initial.get("velocity", 0)))


def time_law(keys):
    """("constant",), ("sine", frequency, phase) or ("ramp", times, values)"""
    if "frequency" in keys:
        return ("sine", float(keys["frequency"]), float(keys.get("phase", 0)))
    if "times" in keys:
        return ("ramp", [float(t) for t in keys["times"]], [float(v) for v in keys["values"]])
    return ("constant",)


def motion_law(keys):
    """("sine", amplitude, frequency, phase, offset) or ("spline", times, values); `hold` or None: 0 for ever"""
    if not isinstance(keys, dict):
        return ("sine", 0.0, 0.0, 0.0, 0.0)
    if "times" in keys:
        return ("spline", [float(t) for t in keys["times"]], [float(x) for x in keys["values"]])
    return ("sine", *(float(keys.get(key, 0)) for key in ("amplitude", "frequency", "phase", "offset")))
