#!/usr/bin/python3
"""What derivatives of a motion cost: its processor time with all of them, over that without, beside central differences
in one call of simulate_many. All are measured by turns; the least of many times counts, less what a motion of no length
takes: scenes are read, and memory is reserved, once.

    derivatives_speed.py [REPETITIONS]
"""
import sys
import time

import numpy as np
from planar_chain import Scene, Simulation, simulate, simulate_many

# scene, s, numbers
CASES = [("double_pendulum", 1.0, ["links/upper/mass", "links/lower/mass", "links/upper/pin/0"]),
         ("cart_pole", 1.0, ["links/cart/mass", "links/pole/mass", "links/pole/com/0"]),
         ("robot_arm", 3.0, ["links/tool/mass", "links/tool/com/0", "links/tool/joint/stiffness"])]


def processor_times(calls, repetitions):
    """The least time of each, s."""
    least = [float("inf")] * len(calls)
    for _ in range(repetitions):
        for k, call in enumerate(calls):
            start = time.process_time_ns()
            call()
            least[k] = min(least[k], (time.process_time_ns() - start) * 1e-9)
    return least


def differences(scene, numbers):
    """simulate_many's arguments for central differences by the state, by a torque in each joint, and by numbers."""
    tree = scene.to_dict()
    free = [joint for joint in scene.joints if not any("drive" in link.get("joint", {}) and
                                                       link["joint"].get("name", f"{name}_joint") == joint
                                                       for name, link in tree["links"].items())]
    tree.setdefault("loads", {}).update({f"held_{joint}": {"joint": joint, "torque": 0.0} for joint in free})
    given = [f"loads/held_{joint}/torque" for joint in free] + numbers
    simulation = Simulation(scene)
    start = np.concatenate([simulation.q, simulation.qd])
    moving = [k for k in range(len(start)) if scene.joints[k % len(scene.joints)] in free]
    runs, step = 2 * (len(moving) + len(given)), 1e-6
    initial = np.tile(start, (runs, 1))
    parameters = {path: np.full(runs, number_at(tree, path)) for path in given}
    changed = [initial[:, k] for k in moving] + list(parameters.values())
    for k, column in enumerate(changed):
        column[2 * k] += step
        column[2 * k + 1] -= step
    return dict(scene=Scene(tree), initial=initial, parameters=parameters, threads=1)


def number_at(tree, path):
    for key in path.split("/"):
        tree = tree[int(key) if isinstance(tree, list) else key]
    return tree


def main():
    repetitions = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    for name, end, numbers in CASES:
        scene = Scene.from_file(name)
        simulation = Simulation(scene)
        start = simulation.save()

        def from_start(call, to):
            simulation.restore(start)
            call(simulation, to)

        def derivatives(to):
            simulate(scene, [to], derivatives=["state", "torques", *numbers])

        many = differences(scene, numbers)
        calls = []
        for to in (0.0, end):
            calls += [lambda to=to: from_start(Simulation.advance_to, to),
                      lambda to=to: from_start(Simulation.transition, to), lambda to=to: derivatives(to),
                      lambda to=to: simulate_many(times=[to], **many)]
        times = processor_times(calls, repetitions)
        motion, transition, nine, central = (after - before for before, after in zip(times, times[4:]))
        print(f"{name}, {end:g} s: motion {motion * 1e6:.1f} µs; transition {transition / motion:.1f} times that, "
              f"derivatives by state, torques and {len(numbers)} numbers {nine / motion:.1f}, "
              f"central differences {central / motion:.1f}; before the first step {times[1] * 1e6:.0f} µs and "
              f"{times[2] * 1e6:.0f} µs")


main()
