#!/usr/bin/python3
"""A stuck joint bears at most its breakaway torque: closed chains around those of reference/sticking/passes_rest*.

    stuck_test.py BIN [RUNS [SEED]]        BIN is not used; PYTHONPATH finds planar_chain

Starts, springs, masses, friction, methods, tolerances and the times of results are random. The invariant needs no other
program. By hand, run thousands: once, one to three of a thousand failed. Prints each run that fails.
"""
import os
import random
import sys
import warnings

try:
    import numpy  # noqa: F401 (planar_chain needs it)
except ImportError:
    print("numpy not found: skipped")
    sys.exit(77)
import yaml
from planar_chain import Failed, Scene, Simulation

FOLDER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../reference", "sticking")
SCENES = ("passes_rest", "passes_rest", "passes_rest_with_motors", "passes_rest_on_a_line")
METHODS = ("auto", "dop853", "dopri5", "rodas5p", "radau13", "ros34pw2")
DURATION, ROWS, MOST_STEPS = 1, 8, 60000
BAND = 1e-3  # of the breakaway torque; bands are far smaller, but for the coarsest tolerances


def machine(chance):
    with open(os.path.join(FOLDER, chance.choice(SCENES) + ".yaml"), encoding="utf-8") as file:
        scene = yaml.safe_load(file)
    for link in scene["links"].values():
        link["initial"]["velocity"] *= chance.uniform(0.8, 1.2)
        link["mass"] *= chance.uniform(0.8, 1.25)
        joint, friction = link.get("joint", {}), 10 ** chance.uniform(-0.5, 0.5)
        for key, factor in (("stiffness", chance.uniform(0.5, 2)), ("friction", friction), ("breakaway", friction)):
            if key in joint:
                joint[key] *= factor
    method = chance.choice(METHODS)
    finest = -7 if method == "ros34pw2" else -9
    scene["integrator"] = {"method": method, "tolerance": 10.0 ** chance.randint(finest, -4)}
    return scene


def borne(joint, q, torque):
    """The torque of friction in a joint at rest: springs and stops taken away, N m."""
    torque += joint.get("stiffness", 0) * (q - joint.get("rest_angle", 0))
    beyond = max(q - joint.get("upper", q), 0) + min(q - joint.get("lower", q), 0)
    return torque + joint.get("stop_stiffness", 0) * beyond


def fault_of(scene, times):
    """The first joint that sticks under more than its breakaway torque; None: there is none."""
    simulation = Simulation(Scene(scene))
    for t in times:
        simulation.advance_to(t, most_steps=MOST_STEPS)
        q, qd, torques = simulation.q, simulation.qd, simulation.joint_torques()
        for i, name in enumerate(scene["chain"]):
            joint = scene["links"][name].get("joint", {})
            breakaway = joint.get("breakaway", joint.get("friction"))
            if breakaway is None or qd[i] != 0:
                continue
            load = borne(joint, q[i], torques[i])
            if abs(load) > breakaway * (1 + BAND):
                return f"t = {t:.4f} s: {name} sticks under {load:.4g} N m with a breakaway of {breakaway:.4g} N m"
    return None


def main():
    warnings.simplefilter("ignore")  # on how far the tip is moved at the start
    runs, seed = int((sys.argv[2:] or ["300"])[0]), int((sys.argv[3:] or ["3"])[0])
    faults = 0
    for run in range(runs):
        chance = random.Random(f"{seed} {run}")
        scene = machine(chance)
        times = sorted(chance.uniform(0, DURATION) for _ in range(ROWS))
        try:
            fault = fault_of(scene, times)
        except Failed as failed:
            fault = str(failed)
        if fault:
            faults += 1
            print(f"run {run} of seed {seed}, {scene['integrator']}: {fault}", flush=True)
    print(f"{faults} of {runs} runs fail")
    sys.exit(1 if faults else 0)


main()
