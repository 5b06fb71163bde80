"""Scenes whose formulas are compared with the program: those that ship and random ones, each at a state."""

import functools
import glob
import json
import os
import warnings

import numpy as np

from planar_chain import Failed, Scene, Simulation, equations, formulas, linearize
from planar_chain.symbolic.chain import read

SCENES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../config/scenes")
MOST_LINKS = 10
RANDOM = int(os.environ.get("FORMULAS_RANDOM", 50))  # chains
AGREE = 1e-12  # of the largest number of a matrix: both sides round a few hundred times
SIZES = (1, 2, 3, 4, 2, 3, 5, 2, 3, 4)  # of random chains; one in twenty is longer


def shipped():
    """{name: Scene} of those with few links."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # initial angles that are moved to close a chain
        scenes = {os.path.basename(path)[:-5]: Scene.from_file(path) for path in sorted(glob.glob(SCENES + "/*.yaml"))}
    return {name: scene for name, scene in scenes.items() if len(scene) <= MOST_LINKS}


def random_law(rng):
    kind = rng.integers(3)
    if kind == 0:
        return {"amplitude": rng.normal(), "frequency": rng.uniform(0.2, 2), "phase": rng.normal(), "offset": rng.normal()}
    if kind == 1:
        return {"times": np.cumsum(rng.uniform(0.2, 1, 4)).tolist(), "values": rng.normal(size=4).tolist()}
    return {"offset": rng.normal()}


def random_joint(rng):
    joint = {}
    if rng.random() < 0.3:
        joint["rotor_inertia"] = rng.uniform(0.01, 0.5)
    if rng.random() < 0.2:
        return {**joint, "drive": "hold" if rng.random() < 0.2 else random_law(rng)}
    for key, share, value in (("damping", 0.5, rng.uniform(0, 2)), ("stiffness", 0.4, rng.uniform(0, 20)),
                              ("rest_angle", 0.3, rng.normal()), ("friction", 0.3, rng.uniform(0.1, 3)), ("drag", 0.2, rng.uniform(0.1, 3))):
        if rng.random() < share:
            joint[key] = value
    if rng.random() < 0.3:
        joint.update(lower=rng.uniform(-1, 0), upper=rng.uniform(0.01, 1), stop_damping=rng.uniform(0, 3))
    if rng.random() < 0.2:  # what concerns commands is in no formula
        joint.update(motor={"no_load_speed": 5.0, "time_constant": 0.1}, effort_limit=1e-3, command_delay=0.1, velocity_limit=0.1)
    return joint


def random_load(rng, links):
    load = {"start": rng.uniform(0, 1), "stop": rng.uniform(1, 4)} if rng.random() < 0.4 else {}
    kind = rng.integers(3)
    if kind == 0:
        load.update(frequency=rng.uniform(0.1, 3), phase=rng.normal())
    elif kind == 1:
        load.update(times=np.cumsum(rng.uniform(0.2, 1, 3)).tolist(), values=rng.normal(size=3).tolist())
    kinds = {name: link["joint"].get("type") for name, link in links.items()}
    free = [name for name, link in links.items() if "drive" not in link["joint"] and kinds[name] != "floating"]
    if free and rng.random() < 0.4:
        load.update(joint=rng.choice(free) + "_joint", torque=rng.normal())
    if "joint" not in load or rng.random() < 0.5:
        load.update(link=rng.choice(list(links)), force=rng.normal(size=2).tolist(), moment=rng.normal())
        if kinds[load["link"]] == "prismatic":
            del load["moment"]
        if rng.random() < 0.7:
            load["point"] = rng.normal(size=2).tolist()
    return load


def make_prismatic(rng, links, places):
    """The links at these places have prismatic joints."""
    for i in places:
        link = list(links.values())[i]
        link["joint"].update(type="prismatic", axis=rng.normal(size=2).tolist() if rng.random() < 0.7 else [0, 1])
        if i < 2 and rng.random() < 0.3 and set(range(i)) <= set(places):
            link["mass"] = 0.0
            link["joint"].pop("rotor_inertia", None)
            del link["inertia"], link["com"]


def hold_tip(rng, scene):
    """The tip is held about where the first angles have it, at a point that moves or on a line."""
    for k, link in enumerate(scene["links"].values(), 2):
        joint = link["joint"]
        joint.pop("friction", None)  # the tip needs two joints without it
        if k >= len(scene["links"]):
            joint.pop("drive", None)  # two joints must be free
        if "upper" in joint:
            joint["stop_stiffness"] = 20.0  # stiff ones take digits of q̈ where the tip determines all angles
        if "drive" in joint:
            joint["drive"] = {"amplitude": 0.1, "frequency": 0.5}
        elif joint.get("type") != "floating":
            link["initial"] = {"position" if "type" in joint else "angle": rng.normal()}
    if "base" in scene:
        other = "angle" if "angle" in scene["base"] else "x"
        scene["base"] = {"y": {"amplitude": 0.05, "frequency": 0.7}, other: {"amplitude": 0.1, "frequency": 0.5, "phase": 1}}
    made = Scene(json.loads(json.dumps(scene)))
    chain, at, place = read(made), equations(made), np.zeros(2)
    for link, q, S in zip(chain["links"], at["q"], at["S"]):
        place += (np.array(link["pin"]) + q * np.array(link["joint"].get("axis", (0, 0)))) @ S
    place = place.tolist()
    if rng.random() < 0.3:
        scene["tip"] = {"line": {"point": place, "direction": rng.normal(size=2).tolist()}}
    else:
        scene["tip"] = {"pin": {axis: {"amplitude": 0.05, "frequency": 0.6, "offset": x} for axis, x in zip("xy", place)}}


def add_point_forces(rng, scene):
    """Air drag and springs to the ground, of which about half are slack."""
    for name, link in scene["links"].items():
        if rng.random() < 0.3:
            link["drag"] = rng.uniform(0.1, 2) if rng.random() < 0.5 else {"coefficient": rng.uniform(0.1, 2), "point": rng.normal(size=2).tolist()}
        if rng.random() < 0.3:
            spring = {"link": name, "ground": rng.normal(size=2).tolist(), "stiffness": rng.uniform(1, 20), "damping": rng.uniform(0, 3)}
            if rng.random() < 0.7:
                spring.update(rest_length=rng.uniform(0.1, 3), slack=bool(rng.random() < 0.7))
            if rng.random() < 0.6:
                spring["point"] = rng.normal(size=2).tolist()
            scene.setdefault("springs", {})["to_" + name] = spring


def random_scene(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(6, MOST_LINKS + 1)) if seed % 25 == 24 else SIZES[seed % len(SIZES)]
    straight = rng.random() < 0.3
    links = {}
    for i in range(n):
        com, pin = ([x, 0.0 if straight else y] for x, y in rng.normal(size=(2, 2)).tolist())
        links[f"link_{i}"] = {"mass": rng.uniform(0.5, 2), "inertia": rng.uniform(0.05, 0.5), "com": com, "pin": pin,
                              "joint": random_joint(rng)}
    scene = {"chain": list(links), "links": links}
    if rng.random() < 0.3:
        scene["gravity"] = rng.normal(size=2).tolist()
    if seed % 9 == 8:
        links["link_0"]["joint"] = {"type": "floating"}
    elif seed % 3 == 2:  # carriages
        make_prismatic(rng, links, range(min(1 + seed // 3 % 2, n - 1)))
    if seed % 3 != 1 and n > 1:  # within the chain
        make_prismatic(rng, links, {int(rng.integers(1, n)) for _ in range(1 + n // 3)})
    if seed % 9 != 8 and rng.random() < 0.45:
        scene["base"] = {axis: random_law(rng) for axis in ("x", "y", "angle") if axis == "y" or rng.random() < 0.7}
    if rng.random() < 0.6:
        scene["loads"] = {f"load_{k}": random_load(rng, links) for k in range(int(rng.integers(1, 4)))}
    if seed % 2:
        add_point_forces(np.random.default_rng([seed, 1]), scene)
    if seed % 5 == 3:
        hold_tip(rng, scene)
    return Scene(json.loads(json.dumps(scene)))


def state_with_tip(scene, t):
    """A state of its motion, as the tip must be where it is held; before the chain gets to a pose in which it may not go on."""
    simulation = Simulation(scene)
    try:
        simulation.advance_to(t)
    except Failed:
        return state_with_tip(scene, t / 2)
    return t, simulation.q, simulation.qd


class State:
    """A scene at a random state, in which every joint moves; and what the program computes there."""

    def __init__(self, name, scene, seed, numbers):
        rng = np.random.default_rng(seed)
        self.name, self.scene, self.numbers, self.t = name, scene, numbers, float(rng.uniform(0.05, 2.5))
        at = equations(scene, t=self.t)
        self.formulas = formulas(scene)
        self.q, self.qd = rng.normal(size=(2, len(scene)))
        for j in self.formulas.driven:
            self.q[j], self.qd[j] = at["q"][j], at["qd"][j]
        if self.formulas.chain.rows:
            self.t, self.q, self.qd = state_with_tip(scene, self.t / 16)
        if numbers:
            self.formulas = self.formulas.with_numbers()
        self.expected = equations(scene, self.q, self.qd, self.t)
        turns = ~np.array(scene.prismatic)
        self.sums = np.where(np.outer(turns, turns), np.triu(np.ones((len(scene), len(scene)))), np.diag(~turns))  # T, of x
        self.expected["M_ext"][~np.logical_or.accumulate(turns)] = 0  # what does not turn has its moment in no formula
        self.tau = rng.normal(size=len(scene))  # about which A and B are
        self.tau[self.formulas.driven] = 0
        self.expected["A"], self.expected["B"] = linearize(scene, self.q, self.qd, t=self.t, tau=self.tau)

        self.cancels = {}
        if self.formulas.chain.rows:  # B is M⁻¹ less what the tip takes of it, which may be all; q̈ has a part of each force
            inverse = np.linalg.inv(self.expected["M"])
            self.cancels = {"B": abs(inverse).max(), "qdd": abs(inverse @ self.expected["J_c"].T @ self.expected["phi"]).max(),
                            "c": abs(self.expected["J_c"]).max() * np.square(np.cumsum(self.qd * turns)).max()}  # links of a ring go round

    @property
    def outputs(self):
        return ("M", "f", "qdd", *(("J_c", "c", "phi") if self.formulas.chain.rows else ()), "A", "B")

    def check(self, test, values, road):
        for output in self.outputs:
            expected = self.expected[output]
            got = np.array(values[output], dtype=float).reshape(expected.shape)
            size = max(abs(expected).max(), self.cancels.get(output, 0), np.finfo(float).tiny)
            test.assertLessEqual(abs(got - expected).max() / size, AGREE, f"{self.name}: {output} in {road}")


@functools.lru_cache(maxsize=None)
def states():
    """What ships and random scenes, in letters and in numbers by turns."""
    both = [State(name, scene, k, k % 2 == 0) for k, (name, scene) in enumerate(shipped().items())]
    return both + [State(f"random {seed}", random_scene(seed), seed, seed % 2 == 0) for seed in range(RANDOM)]
