#!/usr/bin/python3
"""Rotors, drives, dry friction, a moving base, rest: simulate and equations against test/reference/machines.

    machines_test.py BIN [unittest options]        BIN: the folder that holds both
"""
import collections
import csv
import json
import os
import subprocess
import sys
import unittest

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../support"))
from in_folder import InFolder  # noqa: E402

BIN = ""
FOLDER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../reference", "machines")
METHODS = ("auto", "dop853", "rodas5p", "taylor")
# Asked of each step, and allowed at the end: a thousand steps add up, and dry friction passes an error of the
# moment of a stop on. The reference is certain to 1e-10. A wrong term or a missed stop shows as 1e-3 and more.
TOLERANCE, ALLOWED = 1e-10, 1e-6


def stored(name):
    """A table of the folder: {(scene, t): {quantity: values}}"""
    table = collections.defaultdict(lambda: collections.defaultdict(list))
    with open(os.path.join(FOLDER, name), newline="") as file:
        for row in csv.DictReader(file):
            table[row["scene"], row["t"]][row["quantity"]].append(float(row["value"]))
    return table


def joined(numbers):
    return ",".join(map(repr, numbers))


class Machines(InFolder):
    def run_tool(self, tool, scene, *arguments):
        command = [os.path.join(BIN, tool), os.path.join(FOLDER, scene + ".yaml"), *arguments]
        result = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True,
                                timeout=60)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stdout

    def states(self, scene, duration, method):
        """q and qd of the first row and of the last."""
        self.run_tool("simulate", scene, "--duration", duration, "--rate", "1", "--method", method,
                      "--tolerance", str(TOLERANCE), "--csv", self.path("out.csv"))
        with open(self.path("out.csv"), newline="") as file:
            _, *rows = csv.reader(file)
        return [[float(entry) for entry in row[1:-1]] for row in (rows[0], rows[-1])]

    def assert_close(self, got, expected, allowed):
        self.assertEqual(len(got), len(expected))
        for a, b in zip(got, expected):
            self.assertLessEqual(abs(a - b), allowed, (got, expected))

    def test_motions_end_where_the_reference_does(self):
        for (scene, duration), end in stored("motions.csv").items():
            for method in METHODS:
                with self.subTest(scene=scene, method=method):
                    _, last = self.states(scene, duration, method)
                    self.assert_close(last, end["q"] + end["qd"], ALLOWED)

    def test_dry_friction_shortens_each_half_swing_by_twice_friction_over_stiffness(self):
        # k = 20, c = 1, I = 1/3: ω = √60. Four half swings of π/ω bring 1 rad to 0.6; then the rod swings about
        # c/k = 0.05: q(2) = 0.05 + 0.55 cos(2 ω − 4 π).
        for method in METHODS:
            _, last = self.states("rod_1", "2", method)
            self.assertLessEqual(abs(last[0] - -0.487215884), 1e-9)

    def test_dry_friction_stops_it_for_good(self):
        # Nine half swings bring 1 rad to −0.1, the tenth to 0. There the spring is weaker than the friction.
        for method in METHODS:
            _, last = self.states("rod_1", "5", method)
            self.assert_close(last, [0, 0], 1e-9)
            self.assertEqual(last[1], 0)

    def test_equilibria(self):
        # Newton's method ends at rounding, and what starts at rest stays there.
        for (scene, _), end in stored("rest.csv").items():
            for method in METHODS:
                with self.subTest(scene=scene, method=method):
                    for state in self.states(scene, "1", method):
                        self.assert_close(state, end["q"] + [0] * len(end["q"]), 1e-9)

    def test_inverse_dynamics(self):
        # By the O(n) recursion, and by the dense matrices: tau = M qdd - f.
        for (scene, t), state in stored("torques.csv").items():
            with self.subTest(scene=scene, t=t):
                at = ("--json", "--t", t, "--q=" + joined(state["q"]), "--qd=" + joined(state["qd"]))
                allowed = 1e-12 * max(map(abs, state["tau"]))
                inverse = json.loads(self.run_tool("equations", scene, *at, "--inverse",
                                                   "--qdd=" + joined(state["qdd"])))
                self.assert_close(inverse["tau"], state["tau"], allowed)
                dense = json.loads(self.run_tool("equations", scene, *at))
                tau = [sum(m * a for m, a in zip(row, state["qdd"])) - f for row, f in zip(dense["M"], dense["f"])]
                self.assert_close(tau, state["tau"], allowed)

    def test_rest_is_found_from_other_angles(self):
        for (scene, _), end in stored("rest.csv").items():
            with self.subTest(scene=scene):
                near = joined([angle + 0.125 for angle in end["q"]])
                found = json.loads(self.run_tool("equations", scene, "--json", "--equilibrium", "--q=" + near))
                self.assert_close(found["q"], end["q"], 1e-9)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    BIN = sys.argv.pop(1)
    unittest.main()
