#!/usr/bin/python3
"""Rotors, drives, dry friction, a moving base, rest: simulate and equations against answers known in closed form.

    known_motions_test.py BIN [unittest options]        BIN: the folder that holds both
"""
import csv
import itertools
import json
import math
import os
import subprocess
import sys
import unittest

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../support"))
from in_folder import InFolder  # noqa: E402

BIN = ""
SCENES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../..", "config", "scenes")
METHODS = ("auto", "dop853", "rodas5p", "taylor")
GRAVITY = 9.81
UPRIGHT = math.pi / 2


def chain(names, links, **more):
    """A scene as JSON, which is YAML: links[i] is bodies' keys of names[i]."""
    return {"chain": names, "links": dict(zip(names, links)), **more}


def rod(length, mass=1.0, **more):
    return {"mass": mass, "inertia": mass * length ** 2 / 12, "com": [length / 2, 0], "pin": [length, 0], **more}


class KnownMotions(InFolder):
    def run_tool(self, tool, scene, *arguments):
        with open(self.path("scene.yaml"), "w", encoding="utf-8") as file:
            json.dump(scene, file)
        command = [os.path.join(BIN, tool), self.path("scene.yaml"), *map(str, arguments)]
        result = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True,
                                timeout=60)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stdout

    def angles(self, scene, duration, *arguments, rate=1, tolerance=1e-10, rates=False):
        """The angles of each row; with `rates` the rates too."""
        self.run_tool("simulate", scene, "--duration", duration, "--rate", rate, "--tolerance", tolerance,
                      "--csv", self.path("out.csv"), *arguments)
        with open(self.path("out.csv"), newline="") as file:
            names, *rows = csv.reader(file)
        first = "q_" if not rates else ("q_", "qd_")
        return [[float(x) for name, x in zip(names, row) if name.startswith(first)] for row in rows]

    def equations(self, scene, *arguments):
        return json.loads(self.run_tool("equations", scene, "--json", *arguments))

    def assert_close(self, got, expected, allowed):
        self.assertEqual(len(got), len(expected))
        self.assertLessEqual(max(abs(a - b) for a, b in zip(got, expected)), allowed, (got, expected))

    def test_trials_of_auto_meet_the_tolerance(self):
        # A point on a rod of 1 m, let go level, by Jacobi's elliptic functions: test/reference/report.py.
        bob = {"mass": 1, "inertia": 0, "com": [1, 0], "pin": [1, 0]}
        last = self.angles(chain(["bob"], [bob]), 10, rate=0.1, tolerance=1e-7)[-1]
        self.assert_close(last, [-1.2921156532249148], 1e-7)

    # ---- Dry friction ----

    def test_each_half_swing_is_shorter_by_twice_friction_over_stiffness(self):
        # k = π² J makes a half swing of 1 s, whatever the friction. c/k = 0.06: 1, −0.88, 0.76, …, 0.04, which is
        # inside ±0.06: there it stays, to the last bit.
        stiffness = math.pi ** 2 / 3
        joint = {"stiffness": stiffness, "friction": 0.06 * stiffness}
        scene = chain(["a"], [rod(1.0, joint=joint, initial={"angle": 1.0})], gravity=[0, 0])
        for method in METHODS:
            with self.subTest(method=method):
                rows = self.angles(scene, 12, "--method", method, rates=True)
                for k in range(9):
                    self.assert_close(rows[k], [(-1) ** k * (1 - 0.12 * k), 0], 1e-8)
                self.assertEqual(rows[9:], 4 * [[rows[9][0], 0]])

    def test_a_rod_slides_down_where_friction_is_weaker_than_its_weight_and_else_stays(self):
        # Level, m g l/2 = 4.905: J α = 4.905 − c at the start; above, nothing moves.
        for friction in (4.9, 4.91):
            scene = chain(["a"], [rod(1.0, joint={"friction": friction})])
            (qdd,) = self.equations(scene)["qdd"]
            self.assertAlmostEqual(qdd, -3 * max(0.5 * GRAVITY - friction, 0), delta=1e-12)
            self.assertEqual(self.angles(scene, 1)[-1] == [0], friction > 4.905)

    # ---- A moving base ----

    def shaken(self, rods, length, amplitude, pulsation):
        """The largest angle from upright within 20 s, rad, of rods that start a thousandth off."""
        links = [rod(length, initial={"angle": 1e-3 + (UPRIGHT if k == 0 else 0)}) for k in range(rods)]
        law = {"amplitude": amplitude, "frequency": pulsation / (2 * math.pi), "phase": UPRIGHT}
        scene = chain(["abc"[k] for k in range(rods)], links, base={"y": law})
        rows = self.angles(scene, 20, rate=20, tolerance=1e-8)
        return max(abs(angle - (UPRIGHT if k == 0 else 0)) for row in rows for k, angle in enumerate(row))

    @staticmethod
    def slowest_shaking(squared, amplitude):
        """The limit, rad/s, for a mode of ω² = `squared` when it hangs: Mathieu's equation with q = 2 a ω²/g and the
        characteristic value a_0(q) = −4 ω²/Ω². Its first term is Kapitza's a Ω = √2 g/ω.

        Source: Abramowitz and Stegun, 20.2.25. D. J. Acheson, A pendulum theorem, Proc. R. Soc. Lond. A 443 (1993)
        239–245, for several links: each mode by itself."""
        q = 2 * amplitude * squared / GRAVITY
        return math.sqrt(4 * squared / (q ** 2 / 2 - 7 * q ** 4 / 128 + 29 * q ** 6 / 2304))

    def test_a_shaken_rod_stands_above_a_limit_and_falls_below(self):
        # About its end ω² = 3 g/(2 l).
        length, amplitude = 0.5, 0.05
        limit = self.slowest_shaking(1.5 * GRAVITY / length, amplitude)
        self.assertAlmostEqual(limit / (math.sqrt(4 * GRAVITY * length / 3) / amplitude), 1, delta=0.01)  # Kapitza's
        self.assertLess(self.shaken(1, length, amplitude, 1.005 * limit), 0.002)
        self.assertGreater(self.shaken(1, length, amplitude, 0.995 * limit), 1)

    def test_two_shaken_rods_stand_above_the_limit_of_their_slow_mode(self):
        # ω² = 3 (1 − 2/√7) g/l.
        length, amplitude = 0.5, 0.02
        limit = self.slowest_shaking(3 * (1 - 2 / math.sqrt(7)) * GRAVITY / length, amplitude)
        self.assertLess(self.shaken(2, length, amplitude, 1.005 * limit), 0.002)
        self.assertGreater(self.shaken(2, length, amplitude, 0.995 * limit), 1)

    def test_a_rod_that_is_shaken_too_far_swings_at_half_the_frequency(self):
        # Beyond b_1(q) = −4 ω²/Ω² (Abramowitz and Stegun, 20.2.25), about a = 0.450 g/ω²: Acheson's other limit. It
        # does not fall, but flutters.
        length, pulsation = 0.5, 600.0
        squared = 1.5 * GRAVITY / length

        def above(q):
            return 1 - q - q ** 2 / 8 + q ** 3 / 64 - q ** 4 / 1536 - 11 * q ** 5 / 36864 + 4 * squared / pulsation ** 2

        low, high = 0.5, 1.5
        while high - low > 1e-6:
            middle = (low + high) / 2
            low, high = (middle, high) if above(middle) > 0 else (low, middle)
        amplitude = low * GRAVITY / (2 * squared)
        self.assertAlmostEqual(amplitude * squared / GRAVITY, 0.45, delta=0.01)
        self.assertLess(self.shaken(1, length, 0.995 * amplitude, pulsation), 0.002)
        self.assertGreater(self.shaken(1, length, 1.005 * amplitude, pulsation), 0.2)

    LINKS = (rod(1.0, joint={"rotor_inertia": 0.1}), rod(0.5, mass=0.7, joint={"stiffness": 3.0}),
             {"mass": 0.4, "inertia": 0.02, "com": [0.1, 0.2], "pin": [0.3, 0.1], "joint": {"friction": 0.5}})

    def test_an_accelerated_base_is_tilted_gravity(self):
        # At t the laws accelerate by −a ω² sin(ω t + φ). Its velocity and place make no difference.
        t, laws = 0.3, {"x": (0.5, 1.25, 0.2), "y": (0.25, 2.0, 1.0)}
        base = {key: {"amplitude": a, "frequency": f, "phase": phase} for key, (a, f, phase) in laws.items()}
        tilted = [g + a * (2 * math.pi * f) ** 2 * math.sin(2 * math.pi * f * t + phase)
                  for g, (a, f, phase) in zip((1.0, -GRAVITY), laws.values())]
        at = ("--t", t, "--q=0.4,-1.1,2.0", "--qd=0.5,-2.0,1.0")
        moving = self.equations(chain(list("abc"), self.LINKS, gravity=[1.0, -GRAVITY], base=base), *at)["qdd"]
        still = self.equations(chain(list("abc"), self.LINKS, gravity=tilted), *at)["qdd"]
        self.assert_close(moving, still, 1e-13 * max(map(abs, still)))

    def test_a_turned_base_is_gravity_turned_back(self):
        turn = 0.7
        back = [-GRAVITY * math.sin(turn), -GRAVITY * math.cos(turn)]
        turned = chain(list("abc"), self.LINKS, base={"angle": {"offset": turn}, "x": {"offset": 3.0}})
        self.assert_close(self.angles(turned, 2)[-1], self.angles(chain(list("abc"), self.LINKS, gravity=back), 2)[-1],
                          1e-9)

    # ---- Drives ----

    def test_a_driven_joint_is_the_limit_of_a_stiff_servo(self):
        # The servo's torque is −k e − d ė, e = q − law: a spring, a damper and two loads. e falls as 1/k.
        amplitude, frequency = 0.5, 0.7
        pulsation = 2 * math.pi * frequency
        swings = rod(0.5, joint={"damping": 0.01}, initial={"angle": 0.5})
        law = {"amplitude": amplitude, "frequency": frequency}
        (driven,) = self.angles(chain(["a", "b"], [rod(1.0, joint={"drive": law}), swings]), 1)[1:]
        self.assertAlmostEqual(driven[0], amplitude * math.sin(pulsation), delta=1e-15)
        off = []
        for stiffness in (1e4, 1e6, 1e8):
            damping = 0.01 * stiffness
            servo = rod(1.0, joint={"stiffness": stiffness, "damping": damping},
                        initial={"velocity": amplitude * pulsation})
            loads = {"place": {"joint": "a_joint", "torque": stiffness * amplitude, "frequency": frequency},
                     "rate": {"joint": "a_joint", "torque": damping * amplitude * pulsation, "frequency": frequency,
                              "phase": UPRIGHT}}
            (last,) = self.angles(chain(["a", "b"], [servo, swings], loads=loads), 1)[1:]
            off.append(max(abs(a - b) for a, b in zip(last, driven)))
        for less, more in zip(off[1:], off):
            self.assertAlmostEqual(more / less, 100, delta=5)

    def test_inverse_dynamics_of_what_moves_by_itself_is_zero(self):
        scene = chain(list("abc"), self.LINKS, base={"x": {"amplitude": 0.5, "frequency": 1.25}},
                      loads={"push": {"link": "b", "force": [3.0, 4.0], "moment": 1.0, "frequency": 1.0}})
        at = ("--t", 0.3, "--q=0.4,-1.1,2.0", "--qd=0.5,-2.0,1.0")
        moves = self.equations(scene, *at)
        tau = self.equations(scene, *at, "--inverse", "--qdd=" + ",".join(map(repr, moves["qdd"])))["tau"]
        self.assert_close(tau, [0, 0, 0], 1e-13 * max(map(abs, moves["f"])))

    # ---- Rest ----

    def test_a_cable_pulled_aside_is_a_catenary(self):
        # Horizontal force H at the tip, weight w per metre: at the arc length s from the tip the tension is
        # √(H² + (w s)²), and tan of the slope is w s/H. A stiff piece has the slope of its middle, exactly. Below its
        # pin the continuous cable of length S hangs H/w (cosh(w x/H) − 1) deep, at x = H/w asinh(w S/H).
        force, density, length = 20.0, 1.5, 3.0
        reach = force / (density * GRAVITY)
        across = reach * math.asinh(length / reach)
        depth = math.hypot(reach, length) - reach
        off = {}
        for n in (10, 100, 1000):
            piece = length / n
            links = [rod(piece, mass=density * piece, repeat=n)]
            scene = chain(["cable"], links, start="rest",
                          loads={"pull": {"link": "cable_%d" % n, "force": [force, 0], "point": [piece, 0]}})
            theta, x, y = 0, 0, 0
            for k, angle in enumerate(self.angles(scene, 1e-3)[0]):
                theta += angle
                below = length - (k + 0.5) * piece
                self.assertAlmostEqual(math.tan(theta), -below / reach, delta=1e-10 * length / reach)
                tension = force / math.cos(theta)
                self.assertAlmostEqual(tension, math.hypot(force, density * GRAVITY * below), delta=1e-9 * tension)
                x, y = x + piece * math.cos(theta), y + piece * math.sin(theta)
            off[n] = math.hypot(x - across, y + depth)
        self.assertAlmostEqual(off[10] / off[100], 100, delta=5)
        self.assertAlmostEqual(off[100] / off[1000], 100, delta=1)

    def test_a_stiff_cable_hangs_where_its_springs_carry_its_weight(self):
        # k q = the moment of all weights further out.
        for n, stiffness in ((1000, 1e6), (1000, 1e3), (3000, 10.0)):
            piece, weight = 0.01, 0.063 * GRAVITY
            links = [rod(piece, mass=0.063, repeat=n, joint={"stiffness": stiffness})]
            q, _ = self.angles(chain(["cable"], links, start="rest"), 1e-6, "--method", "rodas5p", tolerance=0.1)
            theta = list(itertools.accumulate(q))
            moment, outer = 0, 0
            for angle, own in zip(reversed(theta), reversed(q)):
                moment += (outer + weight / 2) * piece * math.cos(angle)
                outer += weight
                self.assertAlmostEqual(stiffness * own, -moment, delta=1e-11 * n * weight * n * piece)

    def test_rest_is_no_inflexion(self):
        # V = 4 sin θ − 4 θ falls, with inflexions at 2 π k, without end or to a stop at 10 rad.
        joint = {"upper": 10.0, "stop_stiffness": 1000.0}
        for more, finds in (({}, False), ({"joint": joint}, True)):
            scene = chain(["a"], [dict(rod(1.0), **more)], gravity=[0, -8.0],
                          loads={"turn": {"joint": "a_joint", "torque": 4.0}})
            if not finds:
                with self.assertRaises(AssertionError) as refused:
                    self.equations(scene, "--equilibrium", "--q=0.5")
                self.assertIn("falls without end", str(refused.exception))
                continue
            (found,) = self.equations(scene, "--equilibrium", "--q=0.5")["q"]
            self.assertAlmostEqual(1000 * (found - 10), 4 * (1 - math.cos(found)), delta=1e-9)

    # ---- Scenes that ship do what their comments say ----

    def shipped(self, name, duration, rate):
        """Rows of time, angles and rates."""
        command = [os.path.join(BIN, "simulate"), os.path.join(SCENES, name + ".yaml"), "--duration", str(duration),
                   "--rate", str(rate), "--csv", self.path("out.csv")]
        subprocess.run(command, stdout=subprocess.DEVNULL, check=True, timeout=60)
        with open(self.path("out.csv"), newline="") as file:
            _, *rows = csv.reader(file)
        return [[float(x) for x in row[:-1]] for row in rows]

    def test_cable_and_crane_stay_at_rest_until_they_are_moved(self):
        for name in ("hanging_cable", "crane"):
            first, *rows = self.shipped(name, 2, 4)
            for row in rows:
                with self.subTest(scene=name, t=row[0]):
                    off = max(abs(a - b) for a, b in zip(row[1:], first[1:]))
                    self.assertEqual(off < 1e-9, row[0] <= 1)

    def test_the_cranes_load_does_not_sway_when_it_arrives(self):
        def sway(row):
            angles = list(itertools.accumulate(row[1:12]))
            return abs(sum(length * math.cos(angle) for length, angle in zip(10 * [0.5] + [0.6], angles)))

        rows = self.shipped("crane", 30, 50)
        self.assertGreater(max(sway(row) for row in rows if row[0] < 7.6), 0.4)
        self.assertLess(max(sway(row) for row in rows if row[0] > 7.6), 0.003)

    def test_the_brakes_slip_one_after_another_and_hold(self):
        rows = self.shipped("brake", 20, 100)
        for joint in range(5):
            slips = [row[0] for row in rows if row[6 + joint] != 0]
            self.assertAlmostEqual(slips[0], 2 * (5 - joint), delta=0.02)
            self.assertLess(slips[-1], 16.3)
        held = [row[1:] for row in rows if row[0] >= 16.3]
        self.assertEqual(held, len(held) * held[:1])


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    BIN = sys.argv.pop(1)
    unittest.main()
