"""The numbers of a scene that a fit varies: their paths, first values, bounds and typical sizes."""

import math
import re

import numpy as np

from planar_chain import simulate_many
from planar_chain.user_input import read_number, require_moving

from .recordings import BadFit, is_number

NOT_NEGATIVE = {"mass", "inertia", "damping", "drag", "stiffness", "friction", "breakaway", "rotor_inertia", "stop_stiffness",
                "stop_damping", "rest_length", "coefficient"}
AT_BOUND = 1e-3  # of a scale
LEAST_MASS = 1e-3  # of its scale: 0 is no mass, and a far smaller one makes the equations singular
NOT_ZERO = 1e-300  # a divisor in place of 0


class Number:
    """A number at a path of a scene. first, low, high: in its unit. scale: a typical size of it or of its changes, > 0."""

    def __init__(self, path, first, low, high, scale):
        self.path, self.first, self.low, self.high, self.scale = path, first, low, high, scale

    @property
    def key(self):
        return self.path.rsplit("/", 1)[-1]


def value_at(values, path):
    """The number there, or None."""
    for key in path.split("/"):
        if isinstance(values, dict):
            values = values.get(key)
        elif isinstance(values, list) and re.fullmatch(r"\d+", key) and int(key) < len(values):
            values = values[int(key)]
        else:
            return None
    try:
        return None if values is None or isinstance(values, (bool, dict, list)) else float(values)
    except ValueError:
        return None


def parsed(text):
    """(path, [first, low, high]) of PATH[=FIRST[:LOW:HIGH]]. What is not given is None."""
    path, equals, rest = text.partition("=") if isinstance(text, str) else ("", "", "")
    if not path:
        raise BadFit(f"--vary: expected PATH[=FIRST[:LOW:HIGH]], got {text!r}")
    if not equals:
        return path, (None, None, None)
    parts = rest.split(":")
    try:
        values = [read_number(part) if part.strip() else None for part in parts]
    except ValueError:
        values = []
    if len(values) not in (1, 3):
        raise BadFit(f"--vary: expected PATH, PATH=FIRST or PATH=FIRST:LOW:HIGH of numbers, got {text!r}"
                     + " (a decimal point, not a comma?)" * ("," in rest))
    return path, (*values, None, None)[:3]


def values_of(path, value):
    """[first, low, high] of an entry of a dict. What is not given is None."""
    values = tuple(value) if isinstance(value, (tuple, list)) else (value, None, None)
    if not isinstance(path, str) or len(values) != 3 or not all(one is None or is_number(one) for one in values):
        raise BadFit(f"--vary: expected None, FIRST or (FIRST, LOW, HIGH) of numbers for a path, got {value!r} for {path!r}")
    return values


def sizes(scene):
    """Mass, length and the rate of a swing, of the whole chain, by which a number that is 0 at first is measured."""
    values = scene.to_dict()
    links = [values["links"].get(name) or {} for name in values.get("chain") or ()]
    def sum_of(path):
        return sum(abs(value_at(link, path) or 0) * float(link.get("repeat", 1)) for link in links)
    mass = sum_of("mass") or 1.0
    length = max(sum_of("pin/0") + sum_of("pin/1"), sum_of("com/0") + sum_of("com/1")) or 1.0
    gravity = math.hypot(*map(float, values.get("gravity", [0, -9.81])))
    return mass, length, math.sqrt((gravity or 9.81) / length)


def typical(path, scene):
    """The size of a number that is 0 at first. Joints have moments, prismatic ones forces: arm is what is between them."""
    mass, length, rate = sizes(scene)
    at = path.split("/")
    joint = (scene.to_dict()["links"].get(at[1]) or {}).get("joint") if at[0] == "links" and at[2:3] == ["joint"] else {}
    arm = 1.0 if (joint or {}).get("type") == "prismatic" else length
    inertia, force = mass * arm ** 2, mass * length * arm * rate ** 2
    key = path.rsplit("/", 1)[-1]
    if path.endswith(("com/0", "com/1", "pin/0", "pin/1")):
        return 0.1 * length
    if path.startswith("springs/"):
        return {"stiffness": 0.1 * mass * rate ** 2, "damping": 0.01 * mass * rate}.get(key, 0.1 * length)
    if key == "coefficient" or key == "drag" and "/joint/" not in path:
        return 0.01 * mass / length
    return {"mass": mass, "inertia": 0.1 * inertia, "rotor_inertia": 0.01 * inertia, "damping": 0.01 * inertia * rate,
            "drag": 0.01 * inertia * arm / length, "stop_damping": 0.1 * inertia * rate, "stiffness": 0.1 * inertia * rate ** 2,
            "stop_stiffness": 100 * inertia * rate ** 2, "friction": 0.01 * force, "breakaway": 0.01 * force,
            "torque": 0.1 * inertia * rate ** 2}.get(key, 0.1)


def numbers_of(scene, vary):
    """vary: texts PATH[=FIRST[:LOW:HIGH]], or a dict from paths to None, FIRST or (FIRST, LOW, HIGH)."""
    if isinstance(vary, str):
        vary = [vary]
    if isinstance(vary, dict):
        given = [(path, values_of(path, value)) for path, value in vary.items()]
    elif np.iterable(vary):
        given = [parsed(text) for text in vary]
    else:
        raise BadFit(f"--vary: expected a list of PATH[=FIRST[:LOW:HIGH]] or a dict, got {vary!r}")
    if not given:
        raise BadFit("--vary: expected at least one number, got none")
    numbers = [number_of(scene, path, *values) for path, values in given]
    require_different(scene, numbers)
    return numbers


def number_of(scene, path, first, low, high):
    if "/initial/" in path:
        raise BadFit(f"--vary: expected a number of the machine, got {path}: the initial state of each recording is always fitted")
    require_moving(path, BadFit)
    if re.fullmatch("integrator/.*|links/[^/]*/repeat", path):
        raise BadFit(f"--vary: expected a number of the machine that the motion follows smoothly, got {path}")
    present = value_at(scene.to_dict(), path)
    first = present if first is None else float(first)
    if first is None:
        simulate_many(scene, [], parameters={path: [1.0]})  # refuses a path that leads nowhere
        raise BadFit(f"--vary: expected a first value for {path}, which the scene does not have, as {path}=FIRST, got none")
    key = path.rsplit("/", 1)[-1]
    low = (0.0 if key in NOT_NEGATIVE and first >= 0 else -math.inf) if low is None else float(low)
    high = math.inf if high is None else float(high)
    if not low <= first <= high or not low < high or not math.isfinite(first):
        raise BadFit(f"--vary: expected LOW <= FIRST <= HIGH, LOW < HIGH, of {path}, got {first:g}, {low:g}, {high:g}")
    number = Number(path, first, low, high, max(abs(first), 0.01 * typical(path, scene)) if first else typical(path, scene))
    if key == "mass" and low == 0:
        number.low = LEAST_MASS * number.scale
    return number


def leaves(values, path=""):
    if isinstance(values, dict):
        return {leaf: value for key, item in values.items() for leaf, value in leaves(item, f"{path}/{key}").items()}
    if isinstance(values, list):
        return {leaf: value for key, item in enumerate(values) for leaf, value in leaves(item, f"{path}/{key}").items()}
    return {path: values}


def require_different(scene, numbers):
    """Each path is to lead to a number of its own."""
    simulate_many(scene, [], parameters={number.path: [number.first] for number in numbers})  # refuses paths that lead nowhere
    paths = [number.path for number in numbers]
    for path in paths:
        if paths.count(path) > 1:
            raise BadFit(f"--vary: expected each number once, got {path} {paths.count(path)} times: the same number")


def scene_with(scene, numbers, values):
    return scene.with_values({number.path: float(value) for number, value in zip(numbers, values)})
