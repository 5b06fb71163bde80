"""Random machines: the same seed always gives the same one. chaos_test.py and differential_test.py use them.

Their scenes mix rotors, drives, dry friction, springs, dampers, stops, loads and moving bases; those of everything() also
prismatic joints anywhere, held tips, drag, motors and commands.
"""
import math
import pathlib
import random

import yaml


def law(chance, size):
    if chance.random() < 0.6:
        return {"amplitude": chance.uniform(0, size), "frequency": chance.uniform(0.2, 3), "phase": chance.uniform(-3, 3)}
    return {"times": [0.1, 0.3 + chance.random() / 3, 0.9], "values": [chance.uniform(-size, size) for _ in range(3)]}


def joint(chance):
    if chance.random() < 0.15:
        made = {"drive": law(chance, 1) if chance.random() < 0.7 else "hold"}
    else:
        made = {}
        if chance.random() < 0.5:
            made["friction"] = 10 ** chance.uniform(-2, 1)
            if chance.random() < 0.3:
                made["breakaway"] = made["friction"] * chance.uniform(1, 2)
        if chance.random() < 0.4:
            made.update(stiffness=10 ** chance.uniform(-1, 3), rest_angle=chance.uniform(-1, 1))
        if chance.random() < 0.4:
            made["damping"] = 10 ** chance.uniform(-2, 1)
        if chance.random() < 0.25:
            middle = chance.uniform(-1, 1)
            made.update(lower=middle - chance.uniform(0.2, 2), upper=middle + chance.uniform(0.2, 2),
                        stop_stiffness=10 ** chance.uniform(2, 5), stop_damping=chance.uniform(0, 5))
    if chance.random() < 0.3:
        made["rotor_inertia"] = 10 ** chance.uniform(-3, 1)
    return made


def link(chance, made):
    length, mass = chance.uniform(0.2, 1), 10 ** chance.uniform(-1, 1)
    made = made(chance)
    one = {"mass": mass, "inertia": mass * length ** 2 * chance.uniform(0.02, 0.2),
           "com": [length * chance.random(), chance.uniform(-0.1, 0.1)], "pin": [length, 0], "joint": made}
    if "drive" not in made:
        one["initial"] = {"angle": chance.uniform(-1, 1), "velocity": chance.choice((0, 0, chance.uniform(-3, 3)))}
    return one


def loads(chance, names):
    made = {}
    for k in range(chance.choice((0, 0, 1, 2))):
        load = {"link": chance.choice(names), "force": [chance.uniform(-20, 20), chance.uniform(-20, 20)]}
        load.update(chance.choice(({}, {"frequency": chance.uniform(0.5, 4)}, {"start": 0.2, "stop": 0.7},
                                   {"times": [0, 0.3, 0.8], "values": [0, 1, -1]})))
        made[f"f{k}"] = load
    return made


def machine(seed):
    chance = random.Random(seed)
    names = [f"l{k}" for k in range(chance.choice((1, 2, 3, 4, 6, 8, 12, 16)))]
    links = {name: link(chance, joint) for name in names}
    scene = {"chain": names, "links": links, "loads": loads(chance, names)}
    if chance.random() < 0.3:
        scene["base"] = {axis: law(chance, 0.3) for axis in ("x", "y", "angle") if chance.random() < 0.6} or {"x": law(chance, 1)}
    return scene


# ---- Everything at once ------------------------------------------------------------------------------

def moved_joint(chance):
    """As joint(), with drag and motors. A motor has no friction beside it."""
    made = joint(chance)
    if "drive" in made:
        return made
    if chance.random() < 0.25:
        made["drag"] = 10 ** chance.uniform(-2, 0)
    if "friction" not in made and chance.random() < 0.5:
        made["effort_limit"] = chance.uniform(2, 20)
        if chance.random() < 0.7:
            made.update(motor={"time_constant": chance.choice((0, chance.uniform(0.01, 0.1)))},
                        command_delay=chance.choice((0, chance.uniform(0, 0.1))))
            if chance.random() < 0.5:
                made["motor"]["no_load_speed"] = chance.uniform(1, 10)
    return made


def make_prismatic(chance, one):
    one["joint"].update(type="prismatic", axis=[chance.uniform(-1, 1), chance.uniform(0.1, 1)])
    if "initial" in one:
        one["initial"] = {"position": 0.3 * one["initial"]["angle"], "velocity": one["initial"]["velocity"]}


def cart(chance):
    one = link(chance, moved_joint)
    one["pin"] = [chance.uniform(-0.4, 0.4), chance.uniform(-0.4, 0.4)]
    make_prismatic(chance, one)
    return one


def sine(chance, size, offset=0.0):
    phase = chance.uniform(-3, 3)
    return {"amplitude": size, "frequency": chance.uniform(0.2, 1.5), "phase": phase, "offset": offset - size * math.sin(phase)}


def first(one):
    """Where a joint is at the start."""
    drive = one["joint"].get("drive")
    if drive is None:
        return next(value for key, value in one["initial"].items() if key != "velocity")
    return 0 if drive == "hold" else drive["values"][0] if "values" in drive else drive["amplitude"] * math.sin(drive["phase"])


def place_of_tip(scene):
    """Where the tip is at the start, m; the base is at the origin then."""
    x, y, angle = 0.0, 0.0, 0.0
    for name in scene["chain"]:
        made, q = scene["links"][name]["joint"], first(scene["links"][name])
        ahead, left = scene["links"][name]["pin"]
        if "axis" in made:
            ahead += q * made["axis"][0] / math.hypot(*made["axis"])
            left += q * made["axis"][1] / math.hypot(*made["axis"])
        else:
            angle += q
        c, s = math.cos(angle), math.sin(angle)
        x, y = x + c * ahead - s * left, y + s * ahead + c * left
    return x, y


def hold_tip(chance, scene):
    """Holds the tip where it is, at a point that may move or on a line, if enough joints are free of friction and drives."""
    made = [one["joint"] for one in scene["links"].values()]
    free = sum("friction" not in one and "drive" not in one for one in made)
    if free >= 1 and len(made) > 1 and chance.random() < 0.3:
        scene["tip"] = {"line": {"point": list(place_of_tip(scene)), "direction": [chance.uniform(-1, 1), 1]}}
    elif free >= 2 and len(made) > 2:
        size = chance.choice((0, 0.05))
        scene["tip"] = {"pin": dict(zip("xy", (sine(chance, size, place) for place in place_of_tip(scene))))}


def rubbing_in_one(chance, links):
    """Leaves friction in one joint alone, and no drives. A spring makes the chain swing."""
    rubs, sprung = chance.sample(list(links), 2)
    links[sprung]["joint"].update(stiffness=10 ** chance.uniform(1, 3), rest_angle=chance.uniform(-1, 1))
    for name, one in links.items():
        for key in ("drive", "friction", "breakaway"):
            one["joint"].pop(key, None)
        place = "position" if "axis" in one["joint"] else "angle"
        one.setdefault("initial", {place: chance.uniform(-1, 1), "velocity": chance.uniform(-2, 2)})
        if name == rubs:
            one["joint"]["friction"] = 10 ** chance.uniform(-1, 0)
            for key in ("effort_limit", "motor", "command_delay"):
                one["joint"].pop(key, None)


def near(chance, values):
    """A copy whose numbers differ by up to 5 %."""
    if isinstance(values, dict):
        return {key: near(chance, value) for key, value in values.items()}
    if isinstance(values, list):
        return [near(chance, value) for value in values]
    return values * chance.uniform(0.95, 1.05) if isinstance(values, float) else values


def loop():
    """A closed chain of the kind in which a joint once stuck for good, at a dead centre."""
    with open(pathlib.Path(__file__).parent.parent / "reference/sticking/passes_rest.yaml", encoding="utf-8") as file:
        scene = yaml.safe_load(file)
    nothing = {"inertia": 0.0, "com": [0.0, 0.0], "joint": {}}
    return {**scene, "links": {name: {**nothing, **one} for name, one in scene["links"].items()}, "loads": {}}


def everything(seed):
    """A machine, and commands: (time, joint, torque) and (time, link, force), in order.

    Half of the machines are closed chains of three joints, one of which rubs. There sticking is singular in dead centres."""
    chance = random.Random(f"everything {seed}")
    if seed % 8 == 7:
        return near(chance, loop()), []
    few = seed % 2 == 1
    carts = [f"c{k}" for k in range(chance.choice((0, 1) if few else (0, 0, 1, 1, 2)))]
    names = carts + [f"l{k}" for k in range(3 - len(carts) if few else chance.choice((1, 2, 2, 3, 3, 4, 6)))]
    scene = {"chain": names, "links": {name: link(chance, moved_joint) for name in names}, "loads": loads(chance, names)}
    scene["links"].update({name: cart(chance) for name in carts})
    another = random.Random(f"prismatic {seed}")
    for name in names[1:]:
        if name not in carts and another.random() < 0.3:
            make_prismatic(another, scene["links"][name])
    for load in scene["loads"].values():
        load["point"] = [chance.uniform(0, 0.5), chance.uniform(-0.2, 0.2)]
    if few:
        rubbing_in_one(chance, scene["links"])
    if chance.random() < 0.3:
        scene["base"] = {axis: sine(chance, 0.2) for axis in ("x", "y", "angle") if chance.random() < 0.6} or {"x": sine(chance, 0.3)}
    if few or chance.random() < 0.8:
        hold_tip(chance, scene)
    motors = [name + "_joint" for name in names if "effort_limit" in scene["links"][name]["joint"]]
    commands = [(t, chance.choice(motors), chance.uniform(-25, 25)) for t in (0.0, 0.125, 0.25, 0.5) if motors]
    commands += [(t, chance.choice(names), [chance.uniform(-10, 10), chance.uniform(-10, 10)])
                 for t in (0.1875, 0.5625) if chance.random() < 0.5]
    return scene, sorted(commands, key=lambda command: command[0])
