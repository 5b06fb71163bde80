#!/usr/bin/python3
"""Chaos or a fault: random machines that start beyond a stop, with other output times and with the plain kernel.

    chaos_test.py BIN [unittest options]        BIN is not used; PYTHONPATH finds planar_chain

Both change rounding and steps, and no more. So a motion may change by the tolerance times the growth of errors. Growth is
measured: the scene runs again after each of a few changes of its initial angles by the tolerance.
"""
import copy
import os
import random
import sys
import unittest

try:
    import numpy as np
except ImportError:
    print("numpy not found: skipped")
    sys.exit(77)

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../fuzz"))
from machines import machine  # noqa: E402
from planar_chain import Scene, simulate  # noqa: E402

TOLERANCE = 1e-10
AGREED = 1e-7  # of the larger of 1 and the number: a thousand tolerances, which a motion without chaos keeps
BLUR = 30      # errors of the tolerance arise all along the motion; the change of 1e-10 is made once
CHANGES = 4
TIMES = np.linspace(0, 1, 11)


def beyond_a_stop(seed):
    """A machine of which one joint starts beyond its upper limit. None if it has no limits."""
    chance, scene = random.Random(seed), machine(seed)
    limited = [link for link in scene["links"].values() if "upper" in link["joint"]]
    if not limited:
        return None
    link = chance.choice(limited)
    link["initial"]["angle"] = link["joint"]["upper"] + chance.uniform(0.01, 0.3)
    scene["integrator"] = {"tolerance": TOLERANCE}
    return scene


def motion(scene, times=TIMES):
    return simulate(Scene(scene), times)[::(len(times) - 1) // (len(TIMES) - 1)]


def apart(a, b):
    """How far two motions are apart at each time, up to then."""
    return np.maximum.accumulate((abs(a - b) / np.maximum(1, abs(a))).max(axis=1))


def growth(scene, ours, seed):
    """The effect of the tolerance at the start, at each time."""
    chance, effect = random.Random(seed), np.zeros(len(TIMES))
    for _ in range(CHANGES):
        other = copy.deepcopy(scene)
        for link in other["links"].values():
            if "initial" in link:
                link["initial"]["angle"] += TOLERANCE * chance.choice((-1, 1))
        effect = np.maximum(effect, apart(ours, motion(other)))
    return effect


def fault(scene, seed, theirs):
    """The difference of another motion of the scene, if it is more than the growth of errors explains."""
    ours = motion(scene)
    difference = apart(ours, theirs)
    if (difference <= AGREED).all():
        return None
    effect = growth(scene, ours, seed)
    at = int(np.argmax(difference > np.maximum(AGREED, BLUR * effect)))
    if difference[at] <= max(AGREED, BLUR * effect[at]):
        return None
    return f"seed {seed}, t = {TIMES[at]:.1f} s: {difference[at]:.1e}, where {TOLERANCE} makes {effect[at]:.1e}"


class BeyondAStop(unittest.TestCase):
    SEEDS = range(120)

    def scenes(self):
        for seed in self.SEEDS:
            scene = beyond_a_stop(seed)
            if scene:
                yield seed, scene

    def test_output_times_and_kernel_change_rounding_alone(self):
        faults, count = [], 0
        for seed, scene in self.scenes():
            plain = copy.deepcopy(scene)
            plain["integrator"]["plain_kernel"] = True
            for name, theirs in (("times", motion(scene, np.linspace(0, 1, 331))), ("kernel", motion(plain))):
                count += 1
                found = fault(scene, seed, theirs)
                if found:
                    faults.append(name + ", " + found)
        self.assertGreater(count, 60)
        self.assertEqual(faults, [])

    def test_a_fault_is_told_from_chaos(self):
        found = []
        for seed, scene in self.scenes():
            if len(found) == 20:
                break
            wrong = copy.deepcopy(scene)
            next(iter(wrong["links"].values()))["mass"] *= 1 + 1e-5
            found.append(fault(scene, seed, motion(wrong)) is not None)
        self.assertGreater(sum(found), 10)  # elsewhere the mass does not count, or there is chaos


if __name__ == "__main__":
    del sys.argv[1:2]
    unittest.main()
