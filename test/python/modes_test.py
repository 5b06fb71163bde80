#!/usr/bin/python3
"""Modes, state_space() and their tools against closed forms, a textbook's matrices, differences of the simulation, driven motions.

    modes_test.py BIN [unittest options]       BIN: the folder that holds the tools; PYTHONPATH finds planar_chain
"""
import csv
import importlib.util
import os
import pathlib
import re
import subprocess
import sys
import unittest
import warnings

try:
    import numpy as np
    from scipy import signal
except ImportError:
    print("numpy or scipy not found: skipped")
    sys.exit(77)

from planar_chain import Scene, Simulation, equilibrium, linearize, modes, simulate, state_space, systems

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../support"))
from in_folder import InFolder  # noqa: E402

BIN = ""
G = 9.81
HANGS = -np.pi / 2


def rod(length, mass=1.0, **keys):
    return {"mass": mass, "inertia": mass * length ** 2 / 12, "com": [length / 2, 0], "pin": [length, 0], **keys}


def hanging(n):
    return np.append(HANGS, np.zeros(n - 1))


def omegas(mode):
    return 2 * np.pi * mode.frequencies


def cart_pole(d=0.0, c=0.0):
    """Cart 2 kg, point mass 0.5 kg at 0.7 m; dampers of the cart and of the pole."""
    return Scene({"chain": ["cart", "pole"], "links": {
        "cart": {"mass": 2.0, "joint": {"type": "prismatic", "axis": [1, 0], "damping": d}},
        "pole": {"mass": 0.5, "inertia": 0, "com": [0.7, 0], "pin": [0.7, 0], "joint": {"damping": c}, "initial": {"angle": HANGS}}}})


class KnownModes(unittest.TestCase):
    def test_equal_point_masses_have_the_roots_of_laguerre(self):
        # omega² = g/l x, L_n(x) = 0; the shapes are L_{k−1}(x) in absolute deflections of the masses from below.
        n, length = 6, 0.7
        point = {"mass": 1.3, "inertia": 0, "com": [length, 0], "pin": [length, 0], "repeat": n}
        mode = modes(Scene({"chain": ["p"], "links": {"p": point}}), hanging(n))
        roots = np.sort(np.polynomial.laguerre.lagroots([0] * n + [1]))
        np.testing.assert_allclose(omegas(mode), np.sqrt(G / length * roots), rtol=1e-12)
        np.testing.assert_array_equal(mode.damping, 0)
        deflections = np.cumsum(np.cumsum(mode.shapes, axis=0), axis=0)
        for x, w in zip(roots, deflections.T):
            expected = [np.polynomial.laguerre.lagval(x, [0] * k + [1]) for k in range(n)][::-1]
            np.testing.assert_allclose(w / w[-1], expected, atol=1e-10)

    def test_a_chain_of_rods_approaches_the_zeros_of_bessel(self):
        # omega_k = j_0k/2 √(g/L), zeros of Abramowitz and Stegun, table 9.5. The error falls with n².
        exact = np.array([2.4048255577, 5.5200781103, 8.6537279129]) / 2 * np.sqrt(G / 2.0)
        errors = []
        for n in (20, 40):
            of = omegas(modes(Scene({"chain": ["r"], "links": {"r": rod(2.0 / n, 1.0 / n, repeat=n)}}), hanging(n)))
            errors.append(of[:3] / exact - 1)
        np.testing.assert_allclose(4 * errors[1] / errors[0], 1, atol=0.06)
        self.assertLess(abs(4 * errors[1] - errors[0]).max() / 3, 5e-4)  # extrapolated

    def test_a_clamped_beam_has_its_frequencies(self):
        # cos βL cosh βL = −1. Joints n EI, the clamped one twice that; the error falls with n².
        exact = np.array([1.8751040687, 4.6940911330, 7.8547574382])
        found = []
        for n in (50, 100):
            of = {"first": rod(1 / n, 1 / n, joint={"stiffness": 2 * n}), "r": rod(1 / n, 1 / n, joint={"stiffness": n}, repeat=n - 1)}
            found.append(np.sqrt(omegas(modes(Scene({"chain": ["first", "r"], "gravity": [0, 0], "links": of})))[:3]))
        np.testing.assert_allclose((4 * found[1] - found[0]) / 3, exact, rtol=3e-7)
        self.assertGreater(abs(found[1] / exact - 1).min(), 2e-5)  # n counts

    def test_a_cart_drifts_and_its_pole_swings(self):
        mode = modes(cart_pole())
        self.assertEqual(mode.kinds, ["free", "oscillates"])
        np.testing.assert_allclose(omegas(mode), [0, np.sqrt(2.5 * G / (2.0 * 0.7))], rtol=1e-12)
        np.testing.assert_allclose(mode.shapes, [[1, -0.5 * 0.7 / 2.5], [0, 1]], atol=1e-12)
        upright = modes(cart_pole(), [0, -HANGS])
        self.assertEqual(upright.kinds, ["free", "unstable", "decays"])
        np.testing.assert_allclose(upright.poles, [0, omegas(mode)[1], -omegas(mode)[1]], rtol=1e-12)
        np.testing.assert_array_equal(upright.damping, [0, -1, 1])
        # A damped cart: one pole is 0, the others are roots of 2 0.7 s³ + 0.7 d s² + 2.5 g s + d g.
        damped = modes(cart_pole(d=1.5))
        self.assertEqual(damped.kinds, ["free", "overdamped", "oscillates"])
        roots = np.roots([1.4, 0.7 * 1.5, 2.5 * G, 1.5 * G])
        np.testing.assert_allclose(damped.poles[1:], roots[roots.imag >= 0][np.argsort(abs(roots[roots.imag >= 0]))], rtol=1e-12)
        s = damped.poles[2]
        self.assertAlmostEqual(damped.damping[2], -s.real / abs(s), delta=1e-15)

    def test_what_is_held_does_not_move(self):
        # A parallelogram: I omega² = weight, with cranks of 1 kg and a coupler of 2 kg on both.
        links = {"a": rod(0.6), "b": rod(1.0, 2.0), "c": rod(0.6)}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the first state is moved to close it
            bars = Scene({"chain": list(links), "links": links, "tip": {"pin": {"x": {"offset": 1.0}, "y": {"offset": 0.0}}}})
        mode = modes(bars, [HANGS, -HANGS, -HANGS])
        np.testing.assert_allclose(omegas(mode), [np.sqrt(G * (0.6 + 2 * 0.6) / (2 * 0.36 / 3 + 2 * 0.36))], rtol=1e-12)
        np.testing.assert_allclose(mode.shapes[:, 0], [1, -1, 1], atol=1e-12)
        # A driven joint, and one that sticks.
        for key, value in (("drive", {"offset": HANGS}), ("friction", 1.0)):
            two = Scene({"chain": ["a", "b"], "links": {"a": rod(1.0, joint={key: value}), "b": rod(1.0)}})
            mode = modes(two, [HANGS, 0])
            np.testing.assert_allclose(omegas(mode), [np.sqrt(1.5 * G)], rtol=1e-12)
            np.testing.assert_allclose(mode.shapes[:, 0], [0, 1], atol=1e-14)

    def test_torques_hold_other_poses(self):
        # I δq̈ = m g l/2 sin q δq at any angle that a torque holds.
        pendulum = Scene({"chain": ["a"], "links": {"a": rod(1.0, 2.0, joint={"effort_limit": 5.0})}})
        rate = np.sqrt(1.5 * G / 2)
        with self.assertWarnsRegex(UserWarning, "tau: 8.49570921 N m in a_joint is beyond its effort_limit, 5 N m: no command gives it"):
            up = modes(pendulum, [np.pi / 6], tau="holding")
        np.testing.assert_allclose(up.poles, [rate, -rate], rtol=1e-12)
        pendulum = Scene({"chain": ["a"], "links": {"a": rod(1.0, 2.0, initial={"angle": -np.pi / 6})}})
        np.testing.assert_allclose(omegas(modes(pendulum, tau=[G * np.cos(np.pi / 6)])), [rate], rtol=1e-12)
        with self.assertRaisesRegex(ValueError, "got a pose that 2.49571 N m in a_joint would have to hold"):
            modes(pendulum, tau=[6.0])
        run = subprocess.run([os.path.join(BIN, "modes"), "pendulum", "--q", "0", "--tau", "holding"], stdout=subprocess.PIPE, check=True)
        self.assertRegex(run.stdout.decode(), r"^pendulum at q = 0; tau = [0-9.]+\n")

    def test_other_poses_are_refused_with_what_is_left(self):
        pendulum = Scene({"chain": ["a"], "links": {"a": rod(1.0, 2.0)}})
        self.assertAlmostEqual(modes(pendulum).q[0], HANGS, delta=1e-8)
        with self.assertRaisesRegex(ValueError, r"^q: expected an equilibrium .*, got a pose that 8.49571 N m in a_joint would have to hold"):
            modes(pendulum, [np.pi / 6])
        modes(pendulum, [HANGS + 9e-6])
        with self.assertRaisesRegex(ValueError, "expected an equilibrium"):
            modes(pendulum, [HANGS + 2e-5])
        with self.assertRaisesRegex(ValueError, "joints are all held"):
            modes(Scene({"chain": ["a"], "links": {"a": rod(1.0, joint={"friction": 20.0})}}))
        with self.assertRaisesRegex(ValueError, "^expected drives, base and tip at rest"):
            modes(Scene({"chain": ["a"], "links": {"a": rod(1.0, joint={"drive": {"amplitude": 1.0, "frequency": 1.0}})}}))


class StateSpace(InFolder):
    def test_it_is_the_cart_pole_of_textbooks(self):
        M, m, l, d, c = 2.0, 0.5, 0.7, 1.5, 0.2
        A = np.array([[0, 0, 1, 0], [0, 0, 0, 1], [0, m * G / M, -d / M, c / (M * l)],
                      [0, -(M + m) * G / (M * l), d / (M * l), -(M + m) * c / (M * m * l ** 2)]])
        B = np.array([[0], [0], [1 / M], [-1 / (M * l)]])
        C = np.array([[1, 0, 0, 0], [1, l, 0, 0]])
        scene = cart_pole(d, c)
        got = state_space(scene, ["cart_joint"], ["cart_joint/position", "tip/x"])
        for ours, theirs in zip(got, (A, B, C, np.zeros((2, 1)))):
            np.testing.assert_allclose(ours, theirs, atol=1e-14 * max(1, abs(theirs).max()))
        # bode: 300 frequencies and more beside the poles.
        path = self.path("scene.yaml")
        with open(path, "w", encoding="utf-8") as file:
            file.write(str(scene.to_dict()))
        run = subprocess.run([os.path.join(BIN, "bode"), path, "--input", "cart_joint", "--output", "tip/x", "cart_joint/position", "--from",
                              "0.01", "--to", "50", "--points", "300", "--csv", self.path("out.csv"), "--plot", self.path("out.png")],
                             stderr=subprocess.PIPE, universal_newlines=True, check=False)
        self.assertEqual(run.returncode, 0, run.stderr)
        with open(self.path("out.csv"), encoding="utf-8") as file:
            names, *rows = csv.reader(file)
        self.assertEqual(names[:3], ["frequency_Hz", "tip/x from cart_joint (dB)", "tip/x from cart_joint (degrees)"])
        table = np.array(rows, dtype=float)
        self.assertGreater(len(table), 300)
        for k, row in enumerate((1, 0)):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # its polynomial has small coefficients
                _, H = signal.freqresp(signal.StateSpace(A, B, C[row:row + 1], [[0]]), 2 * np.pi * table[:, 0])
            ours = 10 ** (table[:, 2 * k + 1] / 20) * np.exp(1j * np.radians(table[:, 2 * k + 2]))
            np.testing.assert_allclose(ours, H, rtol=1e-9)
        with open(self.path("out.png"), "rb") as file:
            self.assertEqual(file.read(4), b"\x89PNG")

    def test_inputs_and_outputs_are_those_of_the_simulation(self):
        # At a state in motion. Central differences of 1e-5 are exact to 1e-9; inputs are linear.
        rng = np.random.default_rng(3)

        def link(**keys):
            return {"mass": rng.uniform(.5, 2), "inertia": rng.uniform(.05, .2), "com": list(rng.uniform(-.3, .5, 2)),
                    "pin": list(rng.uniform(.2, .6, 2)), **keys}
        n = 4
        scene = Scene({"chain": list("abcd"), "links": {
            "a": link(joint={"damping": .3, "stiffness": 2.}),
            "b": link(joint={"type": "prismatic", "axis": [1, .3], "stiffness": 20., "damping": .2}, initial={"position": .2, "velocity": .3}),
            "c": link(initial={"angle": .4, "velocity": -1.}), "d": link(initial={"angle": -1, "velocity": .6}, joint={"rotor_inertia": .1})},
            "loads": {"f": {"link": "c", "force": [1, 2], "point": [.1, .2]}}, "frames": {"grip": {"link": "c", "point": [.1, .3], "angle": .5}},
            "sensors": {"enc": {"joints": "all"}, "imu": {"link": "c", "point": [.1, .2], "angle": .3}}})
        inputs = ["a_joint", "b_joint", "c,0.2,0.1/force_x", "d/force_y", "b/moment"]
        tau = [1.5, -2.0, 0.7, 0.3]
        outputs = ["b_joint/position", "c_joint/velocity", "c/x", "grip/y", "tip/angle", "d/velocity_x", "d/velocity_y", "b/rate",
                   "tip/acceleration_x", "tip/acceleration_y", "c/pin_force_x", "b/pin_force_y", "enc/a_joint", "imu/gyro",
                   "imu/accelerometer_x", "imu/accelerometer_y"]
        A, B, C, D = state_space(scene, inputs, outputs, tau=tau)
        same = state_space(scene, inputs, ["c,0.1,0.3/y" if name == "grip/y" else name for name in outputs], tau=tau)
        np.testing.assert_array_equal(same[2], C)
        np.testing.assert_array_equal(state_space(scene, ["grip/force_x"], [])[1], state_space(scene, ["c,0.1,0.3/force_x"], [])[1])

        def turned(angle, x, y):
            return np.array([np.cos(angle) * x - np.sin(angle) * y, np.sin(angle) * x + np.cos(angle) * y])

        def quantities(x, u):
            simulation = Simulation(scene)
            simulation.set_state(x[:n], x[n:])
            simulation.hold_torques(np.add(tau, [u[0], u[1], 0, 0]))
            simulation.hold_force("c", [u[2], 0], [.2, .1])
            simulation.hold_force("d", [0, u[3]])
            simulation.hold_force("b", [0, 0], None, u[4])
            at = simulation.link_motions()

            def acceleration(k, point):
                x, y = at["inner_pin"][k] + turned(at["angle"][k], *point) - at["com"][k]
                return at["acceleration"][k] + at["alpha"][k] * np.array([-y, x]) - at["omega"][k] ** 2 * np.array([x, y])
            specific = turned(-at["angle"][2] - .3, *(acceleration(2, (.1, .2)) + [0, G]))
            return np.concatenate([
                [x[1], x[n + 2], at["com"][2][0], (at["inner_pin"][2] + turned(at["angle"][2], .1, .3))[1], at["angle"][3]], at["velocity"][3],
                [at["omega"][1]], acceleration(3, scene.pins[3]), [at["pin_force"][2][0], at["pin_force"][1][1], x[0], at["omega"][2]],
                specific, simulation.accelerations()])

        h, x, none = 1e-5, scene.state, np.zeros(5)
        of_x = np.array([quantities(x + h * e, none) - quantities(x - h * e, none) for e in np.eye(2 * n)]).T / (2 * h)
        of_u = np.array([quantities(x, e) - quantities(x, -e) for e in np.eye(5)]).T / 2
        np.testing.assert_allclose(np.vstack([C, A[n:]]), of_x, atol=1e-9 * abs(of_x).max())
        np.testing.assert_allclose(np.vstack([D, B[n:]]), of_u, atol=1e-13 * abs(of_u).max())

    def test_a_joint_at_rest_slips_on_request(self):
        links = {"a": rod(1.0), "b": rod(1.0, joint={"friction": 1.0})}
        rough, smooth = (Scene({"chain": ["a", "b"], "links": {**links, "b": b}}) for b in (links["b"], rod(1.0)))
        about = ["b_joint"], ["b_joint/acceleration"], [HANGS, 0.0], np.zeros(2)
        for ours, theirs in zip(state_space(rough, *about, friction="slips"), state_space(smooth, *about)):
            np.testing.assert_allclose(ours, theirs, atol=1e-12)
        with self.assertWarnsRegex(UserWarning, "b_joint sticks"):
            self.assertEqual(state_space(rough, *about)[3][0, 0], 0)
        np.testing.assert_allclose(modes(rough, about[2], friction="slips").poles, modes(smooth, about[2]).poles, rtol=1e-12)

    def test_commands_pass_the_lags_of_motors(self):
        # H/(1 + s T) of a joint's torque; forces on links and the base do not pass it.
        T, pose, s = 0.05, [0.4, -0.3], 4j
        plain = {"chain": ["a", "b"], "links": {"a": rod(1.0), "b": rod(0.8)}}
        lagging = {**plain, "links": {**plain["links"], "b": rod(0.8, joint={"motor": {"time_constant": T}, "command_delay": 0.01})}}
        about = ["a_joint", "b_joint", "tip/force_x", "base/angle"], ["tip/acceleration_y", "b_joint/position"], pose, np.zeros(2)

        def answer(A, B, C, D):
            return C @ np.linalg.solve(s * np.eye(len(A)) - A, B) + D
        with self.assertWarnsRegex(UserWarning, r"A and B have no command delays, of b_joint \(command_delay 0.01 s\)$"):
            system = state_space(Scene(lagging), *about, tau="holding", motors=True)
        self.assertEqual(system[0].shape, (7, 7))
        self.assertEqual((system[0][4, 4], system[1][4, 1]), (-1 / T, 1 / T))
        expected = answer(*state_space(Scene(plain), *about, tau="holding"))
        expected[:, 1] /= 1 + s * T
        np.testing.assert_allclose(answer(*system), expected, rtol=1e-12)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            *_, C, D = state_space(Scene(lagging), *about[:1], ["b_joint/torque", "tip/x"], *about[2:], tau="holding", motors=True)
            with self.assertRaisesRegex(ValueError, "outputs/0: expected a joint whose motor lags, with motors=True, got 'b_joint/torque'"):
                state_space(Scene(lagging), [], ["b_joint/torque"])
        self.assertEqual((C[0].tolist(), np.any(D[0])), ([0, 0, 0, 0, 1, 0, 0], False))

    def test_torques_that_lag_of_repeated_links(self):
        links = {name: rod(1.0, joint={"motor": {"time_constant": 0.1}}) for name in "ab"}
        scene = Scene({"chain": ["a", "b"], "links": {**links, "a": {**links["a"], "repeat": 2}}})
        for k, name in enumerate(scene.joints):
            *_, C, _ = state_space(scene, [], [f"{name}/torque"], equilibrium(scene), np.zeros(3), motors=True)
            np.testing.assert_array_equal(C, [np.arange(9) == 6 + k])

    def test_a_base_that_moves_is_a_driven_base(self):
        # Small motions ± of the base cancel even powers of their size; cubes are below 1e-7. They begin at rest and last until
        # less than 1e-8 of the start is left.
        scene = {"chain": ["a", "b"], "links": {"a": rod(0.8, 1.0, joint={"damping": 6.0, "stiffness": 3.0}),
                                                "b": rod(0.5, 2.0, joint={"damping": 2.0, "stiffness": 6.0})}, "integrator": {"tolerance": 1e-13}, "start": "rest"}
        free = Scene(scene)
        q = equilibrium(free)
        size, hertz = 1e-4, 0.7
        omega = 2 * np.pi * hertz
        t = np.linspace(20, 20 + 2 / hertz, 41)[:-1]  # two periods
        basis = np.exp(-1j * omega * t) * 2 / len(t)
        for axis in ("x", "y", "angle"):
            with self.subTest(axis=axis):
                A, B, C, D = state_space(free, ["base/" + axis], ["a_joint/position", "b_joint/position"], q, np.zeros(2))
                H = C @ np.linalg.solve(1j * omega * np.eye(len(A)) - A, B) + D
                answers = []
                for sign in (1, -1):
                    base = {axis: {"amplitude": sign * size, "frequency": hertz}}
                    answers.append(simulate(Scene({**scene, "base": base}), t)[:, :2].T)
                amplitude = (answers[0] - answers[1]) / 2 @ basis  # of the sine: −i
                np.testing.assert_allclose(amplitude / (-1j * size * -omega ** 2), H[:, 0], rtol=0, atol=1e-6 * abs(H).max())
        # A base that is carried along carries its chain: states of its own.
        A, B, C, D = state_space(free, ["base/x", "base/angle"], ["tip/x", "tip/angle", "b/velocity_x"], q, np.zeros(2))
        self.assertEqual((A.shape, B.shape, C.shape), ((8, 8), (8, 2), (3, 8)))
        np.testing.assert_array_equal(C[:, 4], [1, 0, 0])
        np.testing.assert_array_equal(C[:, 6], [0, 0, 1])
        np.testing.assert_allclose(C[:2, 5], [C[0, 0], 1], atol=1e-15)

    def test_wrong_names_are_refused_in_words(self):
        scene = cart_pole()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            held = Scene({"chain": ["a", "b"], "links": {"a": rod(1.0), "b": rod(1.0)}, "tip": {"pin": {"x": {"offset": 1.0}, "y": {"offset": 0.0}}}})
        for of, inputs, outputs, words in (
                (scene, ["cart_join"], [], r"inputs/0: expected a joint, base/x, .*, got 'cart_join' \(did you mean cart_joint\?\)"),
                (scene, ["pol/force_x"], [], r"inputs/0: expected a name of cart, pole, .*, got 'pol' \(did you mean pole\?\)"),
                (scene, ["pole,1/force_x"], [], "inputs/0: expected a point as in \"pole,0.4,0\", got 'pole,1'"),
                (scene, ["pole,1,nan/force_x"], [], "inputs/0: expected a point"),
                (scene, [], ["pole_joint/speed"], "outputs/0: expected NAME/ and one of position, velocity, .*, got 'pole_joint/speed'"),
                (scene, "cart_joint", [], "inputs: expected a list of names, got 'cart_joint'"),
                (scene, ["base/x", "base/x"], [], "inputs: expected each name once, got 'base/x' again"),
                (held, ["base/x"], [], "inputs/0: expected none beside tip of the scene, got one"),
                (held, [], ["b/pin_force_x"], "outputs/0: expected none beside tip of the scene, got one")):
            with self.assertRaisesRegex(ValueError, "^" + words):
                state_space(of, inputs, outputs)
        np.testing.assert_array_equal(state_space(scene, [], [])[0], linearize(scene)[0])


class Tools(InFolder):
    def run_tool(self, name, *arguments):
        return subprocess.run([os.path.join(BIN, name), *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True, check=False)

    def test_modes_prints_and_draws(self):
        run = self.run_tool("modes", "cart_pole", "--q", "0,1.5707963267948966", "--plot", self.path("out.pdf"))
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        self.assertRegex(run.stdout, r"(?s)^cart_pole at q = 0, 1.5708\nmode .*\n   1 +0 +0.0000 +free .*\n   2 +[0-9.]+ +-1.0000 +unstable .*decays")
        self.assertTrue(os.path.getsize(self.path("out.pdf")) > 1000)

    def test_bode_lists_every_name(self):
        said = self.run_tool("bode", "--help").stdout
        for name in (*systems.OF_JOINTS, *systems.OF_POINTS, *systems.PIN_FORCES, *systems.OF_IMUS, "torque", "force_x", "moment"):
            self.assertRegex(said, f"/{name}\\b")

    def test_bode_says_where_there_is_no_response(self):
        """To first order a hanging pole only swings sideways: what is computed is the rounding of its angle."""
        run = self.run_tool("bode", "cart_pole", "--q", "0,-1.5707963", "--input", "cart_joint", "--output", "tip/y", "tip/x", "--csv",
                            self.path("out.csv"), "--plot", self.path("out.svg"))
        self.assertEqual((run.returncode, run.stdout), (0, ""))
        self.assertTrue(run.stderr.startswith("bode: tip/y from cart_joint: no response\n"), run.stderr)
        with open(self.path("out.csv"), encoding="utf-8") as file:
            rows = list(csv.reader(file))[1:]
        self.assertEqual({tuple(row[1:3]) for row in rows}, {("", "")})
        self.assertTrue(np.isfinite(np.array([row[3:] for row in rows], dtype=float)).all())
        with open(self.path("out.svg"), encoding="utf-8") as file:
            self.assertEqual(re.findall("<!-- (.* from .*) -->", file.read()), ["tip/y from cart_joint: no response", "tip/x from cart_joint"])

    def test_bode_at_a_pose_that_torques_hold(self):
        run = self.run_tool("bode", "double_pendulum", "--q", "0.4,0.6", "--tau", "holding", "--motors", "--input", "lower_joint", "--output",
                            "tip/x", "--from", "1", "--to", "10", "--points", "20")
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        table = np.array(list(csv.reader(run.stdout.splitlines()))[1:], dtype=float)
        A, B, C, D = state_space(Scene.from_file("double_pendulum"), ["lower_joint"], ["tip/x"], [0.4, 0.6], np.zeros(2), tau="holding")
        H = np.array([(C @ np.linalg.solve(2j * np.pi * f * np.eye(4) - A, B) + D)[0, 0] for f in table[:, 0]])
        np.testing.assert_allclose(10 ** (table[:, 1] / 20), abs(H), rtol=1e-9)

    def test_modes_along_the_chain_are_drawn_beside_it(self):
        os.environ["MPLBACKEND"] = "Agg"
        sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../src/tools"))
        spec = importlib.util.spec_from_file_location("modes_tool", os.path.join(sys.path[0], "modes.py"))
        tool = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(tool)
        sys.modules["chain"].EQUATIONS = pathlib.Path(BIN) / "equations"
        telescope = Scene.from_file("telescope")
        reach = 0.2 + 0.15 + 0.6
        figure = tool.draw("telescope", modes(telescope), "")
        for axes, is_along in zip(figure.axes, (False, True, True)):
            pins = [line.get_xdata()[0] for line in axes.lines if line.get_marker() == "o"]
            np.testing.assert_allclose(sorted(pins), [-tool.BESIDE * reach, 0, tool.BESIDE * reach] if is_along else [0, 0, 0], atol=1e-12)

    def test_faults_are_lines(self):
        for tool, *arguments, words in (
                ("modes", "acrobot", "--q", "0.3,0", "modes: q: expected an equilibrium .*"),
                ("modes", "acrobot", "--q", "0.3;0", "modes: --q: expected numbers with commas between, got '0.3;0'"),
                ("modes", "acrobot", "--plot", "a.gif", "modes: --plot: expected a name that ends in .*"),
                ("bode", "acrobot", "--input", "hip", "--output", "hip", "bode: outputs/0: expected NAME/ .*"),
                ("bode", "acrobot", "--input", "hip", "--output", "hip/position", "--from", "0", "bode: --from, --to: expected .*"),
                ("bode", "acrobot", "--input", "hip", "--output", "hip/position", "--tau", "1", "bode: tau: expected .*")):
            run = self.run_tool(tool, *arguments)
            self.assertEqual((run.returncode, run.stdout), (2, ""), run.stderr)
            self.assertRegex(run.stderr, rf"^{words}\n$")


if __name__ == "__main__":
    BIN = sys.argv.pop(1)
    unittest.main()
