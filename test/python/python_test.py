#!/usr/bin/python3
"""The Python module against the tools: the same numbers, bit for bit; its scenes, its pages. python_calls_test.py: its
faults, arrays, threads and stubs.

    python_test.py BIN [unittest options]       BIN: the folder that holds the tools; PYTHONPATH finds planar_chain
"""
import csv
import json
import os
import pickle
import re
import subprocess
import sys
import tempfile
import unittest
import warnings

try:
    import numpy as np
except ImportError:
    print("numpy not found: skipped")
    sys.exit(77)

import planar_chain
import yaml
from planar_chain import Refused, Scene, Simulation

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../support"))
from in_folder import URDF, InFolder  # noqa: E402

BIN = ""
ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../..")
SCENES = os.path.join(ROOT, "config/scenes")
ROD = {"mass": 1, "inertia": 0, "com": [1, 0], "pin": [1, 0]}
PENDULUM = {"chain": ["rod"], "links": {"rod": ROD}, "gravity": [0, 0]}  # M = 1 kg m²


def shipped(name):
    return os.path.join(SCENES, name + ".yaml")


def stdout_of(tool, *arguments):
    return subprocess.run([os.path.join(BIN, tool), *arguments], check=True, stdout=subprocess.PIPE).stdout


class Scenes(InFolder):
    def test_text_file_and_dict_are_the_same_scene(self):
        for name in ("double_pendulum", "driven", "leg", "shaken"):
            with open(shipped(name), encoding="utf-8") as file:
                scene = Scene.from_yaml(file.read())
            motion = planar_chain.simulate(scene, [0.0, 0.5])
            for same in (Scene.from_file(shipped(name)), Scene(scene.to_dict()), pickle.loads(pickle.dumps(scene))):
                self.assertEqual((same.links, same.joints, len(same)), (scene.links, scene.joints, len(scene)))
                self.assertEqual(planar_chain.simulate(same, [0.0, 0.5]).tolist(), motion.tolist())

    def test_numbers_of_numpy_are_numbers(self):
        rod = {"mass": np.int32(1), "inertia": np.float32(0.5), "com": np.array([0.5, 0]), "pin": (1, np.float64(0))}
        scene = Scene({"chain": np.array(["rod"]), "links": {"rod": rod}})
        self.assertEqual(planar_chain.equations(scene)["M"], 0.75)

    def test_a_urdf_is_a_scene(self):
        scene = Scene.from_urdf(URDF, {"links": {"rod": {"initial": {"angle": 0.5}}}})
        self.assertEqual((scene.joints, scene.state.tolist()), (["pin"], [0.5, 0]))
        self.assertEqual(planar_chain.equations(scene)["M"], 0.75)
        for same in (Scene.from_file(self.robot()), Scene.from_yaml(URDF)):
            self.assertEqual(same.to_dict(), Scene.from_urdf(URDF).to_dict())
        with self.assertRaisesRegex(Refused, "scene: expected YAML or a URDF, got a bag"):
            Scene.from_yaml("#ROSBAG V2.0\n")

    def test_each_note_is_a_warning_of_python(self):
        robot = ('<robot name="r"><link name="ground"/><link name="rod"><inertial><origin xyz="0 0 -0.5"/><mass value="2"/>'
                 '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link><joint name="pin" type="revolute">'
                 '<parent link="ground"/><child link="rod"/><axis xyz="0 1 0"/><limit effort="1" velocity="1"/></joint></robot>')
        values = {"robot_description": robot}
        with open(self.path("robot.yaml"), "w", encoding="utf-8") as file:
            json.dump(values, file)
        for read in (lambda: Scene(values), lambda: Scene.from_yaml(json.dumps(values)), lambda: Scene.from_urdf(robot),
                     lambda: Scene.from_file(self.path("robot.yaml"))):
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                scene = read()
                scene.with_values({})  # says nothing again
                pickle.loads(pickle.dumps(scene))
            said = [str(warning.message) for warning in caught]
            self.assertEqual(len([words for words in said if "joint[pin]: a revolute joint without lower and upper: turns freely" in words]), 1, said)
            self.assertEqual({warning.category for warning in caught}, {UserWarning})
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            self.assertRaises(UserWarning, Scene.from_urdf, robot)
            Scene.from_file(shipped("rope"))

    def test_all_faults_come_at_once(self):
        with self.assertRaises(Refused) as caught:
            Scene.from_yaml("chain: [a]\nlinks:\n  a: {mass: heavy, inertia: 1, com: [0, 1]}\n")
        self.assertIsInstance(caught.exception, ValueError)
        again = pickle.loads(pickle.dumps(caught.exception))  # as between processes
        self.assertEqual([repr(fault) for fault in again.faults], [repr(fault) for fault in caught.exception.faults])
        faults = [(fault.path, fault.expected, fault.found, fault.line) for fault in again.faults]
        self.assertEqual(faults, [("links/a/mass", "a number > 0 kg", '"heavy"', 3),
                                  ("links/a/pin", "two finite numbers [x, y], in m", "nothing", 3)])
        self.assertEqual(str(caught.exception).count("\n"), 1)

    def test_a_list_too_deep_to_print_is_refused_in_words(self):
        deep = []
        for _ in range(100000):
            deep = [deep]
        with self.assertRaisesRegex(Refused, "scene: expected a dict .*, got a list"):
            Scene(deep)

    def test_what_is_no_scene_is_refused(self):
        circle = []
        circle.append(circle)
        for chain, words in ((circle, "at most 16 levels"), ([{3: 4}], "keys are text"), ([b"rod"], "expected"),
                             ([object()], "expected a dict"), (["\ud800"], "expected"), ([1j], "expected")):
            with self.assertRaisesRegex(ValueError, words):
                Scene({"chain": chain})
        with self.assertRaises(FileNotFoundError):
            Scene.from_file("missing.yaml")
        for name in ("\udc80.yaml", "\ud800", "a\0b.yaml"):
            with self.assertRaises((FileNotFoundError, ValueError)):
                Scene.from_file(name)
        with self.assertRaisesRegex(ValueError, "one of the scenes that ship: .*double_pendulum"):
            Scene.from_file("missing")
        self.assertEqual(Scene.from_file("triple").to_dict(), Scene.from_file(shipped("triple")).to_dict())


class Motions(InFolder):
    def test_simulate_gives_the_rows_of_the_tool(self):
        for name in ("double_pendulum", "driven", "leg", "rope"):
            stdout_of("simulate", shipped(name), "--duration", "1", "--rate", "20", "--csv", self.path("out.csv"))
            with open(self.path("out.csv"), newline="", encoding="utf-8") as file:
                rows = [[float(number) for number in row] for row in list(csv.reader(file))[1:]]
            states = planar_chain.simulate(Scene.from_file(shipped(name)), [row[0] for row in rows])
            self.assertEqual(states.tolist(), [row[1:-1] for row in rows], name)

    def test_a_simulation_gives_the_same_and_starts_again(self):
        scene = Scene.from_file(shipped("double_pendulum"))
        simulation = Simulation(scene)
        for _ in range(2):
            simulation.advance_to(1)
            state = planar_chain.simulate(scene, [1])[0].tolist()
            self.assertEqual(simulation.state.tolist(), state)
            self.assertEqual([*simulation.q, *simulation.qd], state)
            self.assertLess(abs(simulation.energy_balance().residual), 1e-7)
            self.assertGreater(simulation.statistics().evaluations, simulation.statistics().steps)
            simulation.reset()
            self.assertEqual((simulation.time, simulation.state.tolist()), (0, scene.state.tolist()))

    def test_a_tip_that_leaves_the_reach_is_told_from_a_straight_chain(self):
        links = {"a": {**ROD, "initial": {"angle": 0.4}}, "b": {**ROD, "pin": [0.5, 0], "initial": {"angle": -0.8}}}
        for x, words in (({"amplitude": 0.5, "frequency": 0.2, "offset": 1.3}, "the laws of the held tip leave the reach"),
                         ({"amplitude": -0.5, "frequency": 0.2, "offset": 0.7}, "the laws of the held tip leave the reach")):
            scene = Scene({"chain": ["a", "b"], "links": links, "tip": {"pin": {"x": x, "y": {"offset": 0}}}})
            with self.assertRaisesRegex(planar_chain.Failed, "gave up at t = [0-9.]+ s: " + words + r" of the chain \(longer links"):
                planar_chain.simulate(scene, [3])

    def test_commands_give_their_impulse(self):
        for command, rate in ((lambda s: s.hold_torque("rod_joint", 2.0), 2), (lambda s: s.hold_torques([2.0]), 2),
                              (lambda s: s.hold_torque(0, 2.0, until=0.5), 1),
                              (lambda s: s.add_torque("rod_joint", 2.0, 0.25, start=0.5), 0.5),
                              (lambda s: s.add_force("rod", (0, 10), (1, 0), 1e-9, moment=3), 1.3e-8),
                              (lambda s: s.hold_force(0, (0, 0), (0, 0), moment=-1), -1)):
            simulation = Simulation(Scene(PENDULUM))
            command(simulation)
            simulation.advance_to(1)
            self.assertAlmostEqual(simulation.qd[0], rate, delta=1e-12)
        simulation.clear_commands()
        self.assertEqual(simulation.joint_torques().tolist(), [0])
        for bad in (lambda s: s.hold_torque("elbow", 1), lambda s: s.hold_torque(1, 1), lambda s: s.hold_torques([1, 2]),
                    lambda s: s.add_torque(0, np.nan, 1), lambda s: s.hold_force("rod", (1, 2, 3), (0, 0)),
                    lambda s: s.advance_to(0.5), lambda s: s.set_state([1, 2], [0])):
            with self.assertRaises((ValueError, TypeError)):
                bad(simulation)
        for where, words in (("elbow", r"\(rod_joint\), got 'elbow'"), ("rod", r"\(did you mean rod_joint\?\)"), ("\ud800", "got")):
            with self.assertRaisesRegex(Refused, "joint: expected a joint of the chain .*" + words):
                simulation.hold_torque(where, 1)
        for where in (1, -1, 2 ** 70, 0.5, None, b"rod_joint"):
            with self.assertRaisesRegex(Refused, "joint: expected the name of a joint, or a number from 0 to 0, got"):
                simulation.hold_torque(where, 1)
        simulation.hold_torque(np.int64(0), 0)
        simulation = Simulation(Scene(PENDULUM), commands=1)
        simulation.add_torque(0, 1, 1)
        with self.assertRaisesRegex(RuntimeError, "commands"):
            simulation.add_torque(0, 1, 1)
        huge = Simulation(Scene({"chain": ["a", "b"], "links": {"a": ROD, "b": ROD},
                                 "loads": {name: {"joint": name + "_joint", "torque": 1e308} for name in "ab"}}))
        for call in (huge.accelerations, huge.base_wrench, huge.link_motions, huge.equations, huge.linearize):
            with self.assertRaisesRegex(OverflowError, "are not finite: the numbers are too large"):
                call()

    def test_a_force_acts_at_the_centre_of_mass_by_default(self):
        rod = {"mass": 1, "inertia": 1, "com": [0.5, 0], "pin": [1, 0]}  # about the pin 1.25 kg m²
        for command in (lambda s: s.hold_force("rod", (0, 10)), lambda s: s.add_force("rod", (0, 10), duration=1),
                        lambda s: s.hold_force("rod", (0, 10), (0.5, 0))):
            simulation = Simulation(Scene({"chain": ["rod"], "links": {"rod": rod}, "gravity": [0, 0]}))
            command(simulation)
            self.assertAlmostEqual(simulation.accelerations()[0], 10 * 0.5 / 1.25, delta=1e-14)
        with self.assertRaisesRegex(Refused, "duration: expected a number, got None"):
            simulation.add_force("rod", (0, 10))

    def test_measurements_that_nobody_takes_are_lost_and_counted(self):
        simulation = Simulation(Scene({**PENDULUM, "sensors": {"imu": {"link": "rod", "rate": 1e4}}}))
        simulation.advance_to(20)
        with self.assertWarnsRegex(UserWarning, "^33335 measurements are lost: call measure"):
            taken = simulation.measure()
        self.assertEqual([len(taken), taken[0].number, taken[-1].number], [166666, 33335, 200000])

    def test_driven_joints_and_the_base_follow_points_in_time(self):
        still = {"drive": {"offset": 0.0}}
        scene = Scene({"chain": ["a", "b"], "links": {"a": {**ROD, "joint": still}, "b": ROD}, "base": {"x": {"offset": 0.0}}})
        simulation = Simulation(scene)
        simulation.advance_to(0.5)
        simulation.follow("a_joint", [1.0, 2.0], [0.3, -0.2], rates=[0.1, 0.0])
        simulation.follow_base([1.0, 1.5], [[0.2, 0.1, 0.4], [0.5, 0, 0]], rates=[[1, 0, 0], [0, 0, 0]])
        simulation.advance_to(1.0)
        self.assertAlmostEqual(simulation.q[0], 0.3, delta=1e-14)
        self.assertAlmostEqual(simulation.qd[0], 0.1, delta=1e-13)
        np.testing.assert_allclose(simulation.link_motions()["inner_pin"][0], [0.2, 0.1], atol=1e-14)
        self.assertAlmostEqual(simulation.link_motions()["angle"][0], 0.7, delta=1e-14)
        simulation.advance_to(3.0)
        self.assertAlmostEqual(simulation.q[0], -0.2, delta=1e-14)
        np.testing.assert_allclose(simulation.link_motions()["inner_pin"][0], [0.5, 0], atol=1e-14)
        for call, words in (
                (lambda: simulation.follow("b_joint", [4], [0]), "joint: expected a driven joint: a_joint, got 'b_joint'"),
                (lambda: simulation.follow(0, [3, 2], [0, 1]), "times/0: expected a time after the present one, 3 s, got 3\ntimes/1: expected"),
                (lambda: simulation.follow(0, [4, 5], [0]), "angles: expected 2 x 1 numbers, a row for each time, got 1 number"),
                (lambda: simulation.follow(0, [4], [0], rates=[1]), "rates: expected 0 at the last time"),
                (lambda: simulation.follow(0, [4], [np.nan]), "angles: expected finite numbers"),
                (lambda: simulation.follow_base([4], [[0, 0]]), "poses: expected 1 x 3 numbers"),
                (lambda: Simulation(Scene(PENDULUM)).follow(0, [4], [0]), "joint: expected a driven joint, which this scene does not have"),
                (lambda: Simulation(Scene(PENDULUM)).follow_base([4], [[0, 0, 0]]), "follow_base: expected a scene whose base moves")):
            with self.assertRaisesRegex(Refused, words):
                call()

    def test_torques_are_held_all_or_none(self):
        drive = {"drive": {"amplitude": 0.5, "frequency": 1}}
        simulation = Simulation(Scene({"chain": ["a", "b", "c"], "links": {"a": ROD, "b": {**ROD, "joint": drive}, "c": ROD}}))
        with self.assertRaisesRegex(Refused, "torques/1: expected 0 N m in a driven joint, got 2\ntorques/2: expected a finite number, in N m, got nan"):
            simulation.hold_torques([1, 2, np.nan])
        before = simulation.joint_torques()
        self.assertEqual([before[0], before[2]], [0, 0])
        simulation.hold_torques([1, 0, 3])
        after = simulation.joint_torques()
        self.assertEqual([after[0], after[2]], [1, 3])

    def test_the_linear_model_of_a_cart_pole_is_the_textbooks(self):
        M, m, c, J, g = 1.0, 0.4, 0.25, 0.0085, 9.81  # cart_pole.yaml
        A, B = planar_chain.linearize(Scene.from_file("cart_pole"), [0, np.pi / 2], [0, 0])
        inertia = J + m * c * c
        d = (M + m) * inertia - (m * c) ** 2
        # Coordinates: the cart's place, the pole's angle, counter-clockwise from upright.
        expected = [[0, 0, 1, 0], [0, 0, 0, 1], [0, (m * c) ** 2 * g / d, 0, 0], [0, (M + m) * m * c * g / d, 0, 0]]
        np.testing.assert_allclose(A, expected, atol=1e-13 * np.abs(expected).max())
        np.testing.assert_allclose(B, [[0, 0], [0, 0], [inertia / d, m * c / d], [m * c / d, (M + m) / d]], rtol=1e-13)

    def test_equations_are_those_of_the_tool_by_the_same_letters(self):
        scene = Scene.from_file(shipped("triple"))
        told = json.loads(stdout_of("equations", shipped("triple"), "--json", "--linearize", "--q", "1,2,3", "--t", "0.5"))
        found = planar_chain.equations(scene, q=[1, 2, 3], t=0.5)
        found["A"], found["B"] = planar_chain.linearize(scene, q=[1, 2, 3], t=0.5)
        del told["t"]
        self.assertEqual({letter: array.tolist() for letter, array in found.items()}, told)
        torques = json.loads(stdout_of("equations", shipped("triple"), "--json", "--inverse", "--qdd", "1,2,3"))["tau"]
        self.assertEqual(planar_chain.inverse_dynamics(scene, [1, 2, 3]).tolist(), torques)
        rest = json.loads(stdout_of("equations", shipped("triple"), "--json", "--equilibrium"))["q"]
        self.assertEqual(planar_chain.equilibrium(scene).tolist(), rest)
        simulation = Simulation(scene)
        simulation.settle()
        self.assertEqual(simulation.q.tolist(), rest)

    def test_equations_of_what_is_no_state_are_refused(self):
        scene, arm, nan, inf = Scene.from_file(shipped("double_pendulum")), Scene.from_file(shipped("robot_arm")), np.nan, np.inf
        law = Simulation(arm)
        off = law.q + [1e-5, *[0] * (len(arm) - 1)]
        functions = {"equations": planar_chain.equations, "linearize": lambda scene, q=None, qd=None, t=0: planar_chain.linearize(scene, q, qd, t=t),
                     "inverse": lambda scene, *state: planar_chain.inverse_dynamics(scene, np.zeros(len(scene)), *state)}
        for name, function in functions.items():
            for of, state, words in (
                    (scene, ([nan, 0],), ["q: expected a finite number, in rad, of the joint upper_joint, got nan"]),
                    (scene, ([0, 0], [0, inf], nan), ["t: expected a finite number, in s, got nan",
                                                      "qd: expected a finite number, in rad/s, of the joint lower_joint, got inf"]),
                    (scene, ([1e300, 0],), ["q: expected numbers up to 5.65.*e.16 rad in the joint upper_joint, got 1e.300"]),
                    (scene, ([0],), ["q: expected 2 numbers, one a joint, got 1"]),
                    (scene, ([[0, 0]],), ["q: expected an array of one dimension, got 1 x 2"]),
                    (arm, (off,), [r"q: expected \S+ rad of the driven joint \w+ at t = 0 s, got"]),
                    (arm, (law.q, law.qd + 1), [r"qd: expected \S+ rad/s of the driven joint \w+ at t = 0 s, got"])):
                with self.assertRaises(Refused, msg=(name, state)) as caught:
                    function(of, *state)
                for word in words:
                    self.assertRegex(str(caught.exception), word)
        with self.assertRaisesRegex(Refused, "qdd: expected a finite number, in rad/s², of the joint upper_joint, got nan"):
            planar_chain.inverse_dynamics(scene, [nan, 0])
        with self.assertRaisesRegex(Refused, "q: expected a finite number"):
            planar_chain.equilibrium(scene, [nan, 0])
        for call in (lambda: planar_chain.equations(scene, [0, 1], [1e200, 0]), lambda: planar_chain.linearize(scene, [0, 1], [1e200, 0]),
                     lambda: planar_chain.inverse_dynamics(scene, [0, 0], [0, 1], [1e200, 0])):
            with self.assertRaisesRegex(OverflowError, "not finite: the numbers are too large"):
                call()
        long = Scene({"chain": ["rod"], "links": {"rod": {**ROD, "repeat": 1001}}})
        for function in (planar_chain.equations, planar_chain.linearize):
            with self.assertRaisesRegex(Refused, "chain: expected at most 1000 links"):
                function(long)
        self.assertEqual(len(planar_chain.inverse_dynamics(long, np.zeros(1001))), 1001)

    def test_driven_joints_are_where_their_laws_have_them(self):
        scene = Scene({**PENDULUM, "links": {"rod": {**ROD, "joint": {"drive": {"amplitude": 0.5, "frequency": 1}}}}})
        simulation = Simulation(scene)
        simulation.advance_to(0.25)
        found = planar_chain.equations(scene, t=0.25)
        self.assertEqual([found["q"].tolist(), found["qd"].tolist()], [simulation.q.tolist(), simulation.qd.tolist()])
        self.assertEqual(found["q"], 0.5)
        with self.assertRaisesRegex(Refused, "q: expected 0.5 rad of the driven joint rod_joint at t = 0.25 s, got 0\nqd: expected"):
            simulation.set_state([0], [1])

    def test_a_state_that_is_closed_says_how_far(self):
        bar = Scene.from_file(shipped('four_bar'))
        simulation, still = Simulation(bar), [0, 0, 0]
        q = simulation.q
        off = q + [0, 0.2, 0]
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter('always')
            simulation.set_state(q, still)
            planar_chain.equations(bar, q=q)
            self.assertEqual(caught, [])
            simulation.set_state(off, still)
            planar_chain.equations(bar, q=off)
        moved = simulation.q - off
        most = np.argmax(abs(moved))
        for warning in caught:
            self.assertEqual(str(warning.message), f'q: the joint {bar.joints[most]} is moved by {abs(moved[most]):.6g} rad, and no other by '
                                                   'more, to bring the tip to its place')
        self.assertEqual(len(caught), 2)

    def test_present_equations_have_the_commands_in_them(self):
        simulation = Simulation(Scene.from_file(shipped("driven")))
        simulation.hold_torque(0, 3.0)
        simulation.advance_to(0.7)
        found = simulation.equations()
        np.testing.assert_allclose(found["qdd"], simulation.accelerations(), rtol=1e-10)
        np.testing.assert_allclose(found["tau"], simulation.joint_torques(), atol=1e-12)
        np.testing.assert_allclose(np.linalg.inv(found["M"]), simulation.linearize()[1][len(found["qdd"]):], rtol=1e-9)
        motions = simulation.link_motions()
        np.testing.assert_allclose(motions["angle"], np.cumsum(simulation.q), rtol=1e-15)
        np.testing.assert_allclose(motions["velocity"].ravel(), simulation.qd @ found["V_pd"], atol=1e-12)
        np.testing.assert_allclose(simulation.base_wrench()[:2], -motions["pin_force"][0], rtol=1e-12)


def run_examples(page, folder, cut=()):
    """Runs the Python code of a page, in a folder; cut: pairs of a text and a shorter one. Returns what it prints."""
    with open(os.path.join(ROOT, page), encoding="utf-8") as file:
        code = "".join(re.findall(r"^```python\n(.*?)^```$", file.read(), re.MULTILINE | re.DOTALL))
    for text, shorter in cut:
        assert text in code, text
        code = code.replace(text, shorter)
    return subprocess.run([sys.executable, "-c", code], cwd=folder, stdout=subprocess.PIPE, universal_newlines=True, check=True).stdout


class Pages(unittest.TestCase):
    def test_the_examples_run_one_after_the_other(self):
        with tempfile.TemporaryDirectory() as folder:
            said = run_examples("src/python/README.md", folder)
            self.assertGreater(os.path.getsize(os.path.join(folder, "movie.html")), 1000)
        self.assertIn("robot_description: expected", said)
        self.assertIn("(1000, 3, 4) True {}", said)

    def test_the_controller_of_the_first_page_balances_the_pole(self):
        with tempfile.TemporaryDirectory() as folder:
            said = run_examples("README.md", folder, [
                ('animate(scene, times, states).save("swing_up.gif", dpi=80)', "print(plant.state)"),
                ("times = np.arange(251) / 50", "times = np.arange(6) / 50")])
            self.assertGreater(os.path.getsize(os.path.join(folder, "pendulum.gif")), 1000)
        np.testing.assert_allclose(np.array(said.strip("[]\n").split(), dtype=float), [0, np.pi / 2, 0, 0], atol=0.1)


class Readme(unittest.TestCase):
    def test_its_pushes_are_swings(self):
        """Gives the pushes in their order, a minute after each other: no link turns over."""
        with open(os.path.join(ROOT, "README.md"), encoding="utf-8") as file:
            commands = re.findall(r"(?:settle\b|rostopic pub -1 \S+/(\w+) \S+ (?:\\\n *)?'(.*)')", file.read())
        self.assertEqual([topic for topic, _ in commands], ["", "joint_torque", "link_force", "joint_torques"])
        simulation = Simulation(Scene.from_file(shipped("double_pendulum")))
        simulation.advance_to(12)
        simulation.settle()
        rest = simulation.q
        for topic, message in commands[1:]:
            its = yaml.safe_load(message)
            if topic == "joint_torque":
                simulation.add_torque(its["joint"], its["torque"], its["duration"])
            elif topic == "link_force":
                simulation.add_force(its["link"], [its["force"]["x"], 0], [its["point"]["x"], 0], its["duration"])
            else:
                simulation.hold_torques(its["data"])
            angles = []
            for _ in range(1200):
                simulation.advance_to(simulation.time + 0.05)
                angles.append(abs(simulation.q - rest))
            self.assertTrue(np.all(np.max(angles, axis=0) < np.pi), (topic, np.max(angles, axis=0)))
            self.assertGreater(np.max(angles), 0.1)


if __name__ == "__main__":
    BIN = sys.argv.pop(1)
    unittest.main()
