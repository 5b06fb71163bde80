#!/usr/bin/python3
"""The Python module against the tools: the same numbers, bit for bit; its arrays, its faults, its threads, its stubs.

    python_test.py BIN [unittest options]       BIN: the folder that holds the tools; PYTHONPATH finds planar_chain
"""
import ast
import csv
import json
import os
import pickle
import re
import signal
import subprocess
import sys
import threading
import time
import unittest
import warnings

try:
    import numpy as np
except ImportError:
    print("numpy not found: skipped")
    sys.exit(77)

import planar_chain
import yaml
from in_folder import InFolder
from planar_chain import Refused, Scene, Simulation

BIN = ""
ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
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
        inertia = '<inertial><origin xyz="0 0 -0.5"/><mass value="2"/><inertia ixx="1" ixy="0" ixz="0" iyy="0.25" iyz="0" izz="1"/></inertial>'
        robot = (f'<robot name="r"><link name="ground"/><link name="rod">{inertia}</link><joint name="pin" '
                 'type="continuous"><parent link="ground"/><child link="rod"/><axis xyz="0 1 0"/></joint></robot>')
        scene = Scene.from_urdf(robot, {"links": {"rod": {"initial": {"angle": 0.5}}}})
        self.assertEqual((scene.joints, scene.state.tolist()), (["pin"], [0.5, 0]))
        self.assertEqual(planar_chain.equations(scene)["M"], 0.75)

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
        faults = [(fault.path, fault.expected, fault.found, fault.line) for fault in caught.exception.faults]
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

    def test_a_failure_is_raised_and_keeps_the_last_good_state(self):
        scene = Scene({**PENDULUM, "loads": {"blast": {"joint": "rod_joint", "torque": 1e200, "start": 0.3}}})
        simulation = Simulation(scene)
        with self.assertRaisesRegex(planar_chain.Failed, "last good state is kept"):
            simulation.advance_to(1)
        self.assertEqual((simulation.time, simulation.state.tolist()), (0.3, [0, 0]))
        with self.assertRaises(RuntimeError) as failed:
            planar_chain.simulate(scene, [0, 1])
        self.assertNotIn("clear_commands", str(failed.exception))  # there is nothing to go on with

    def test_a_failure_names_its_cure(self):
        cure = r"; set_state\(\), settle\(\), reset\(\) or clear_commands\(\) lets it go on$"
        simulation = Simulation(Scene(PENDULUM))
        simulation.advance_to(0.1)
        for k, mend in enumerate((lambda: simulation.clear_commands(), lambda: simulation.set_state([0.1], [0.2]),
                                  lambda: (simulation.hold_torque(0, 0), simulation.settle()), lambda: simulation.reset())):
            simulation.hold_torque(0, 1e200)
            time_then, state = simulation.time, simulation.state.tolist()
            for _ in range(2):
                with self.assertRaisesRegex(planar_chain.Failed, cure):
                    simulation.advance_to(time_then + 1)
            self.assertEqual((simulation.time, simulation.state.tolist()), (time_then, state))
            mend()
            if k > 0:
                simulation.clear_commands()
            simulation.advance_to(simulation.time + 0.1)

    def test_a_duration_in_the_place_of_a_point_is_told(self):
        with self.assertRaisesRegex(planar_chain.Refused, "point: expected an array of 2 numbers, got one number"):
            Simulation(Scene(PENDULUM)).add_force("rod", [1, 0], 0.1)

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
        huge = Simulation(Scene({"chain": ["a", "b"], "links": {"a": ROD, "b": ROD}}))
        huge.hold_torques([1e308, 1e308])
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

    def test_steps_without_end_stop_with_a_reason(self):
        rods = Scene({"chain": ["a", "b"], "links": {"a": ROD, "b": ROD}})
        simulation = Simulation(rods)
        simulation.hold_torque("b_joint", 1e12)
        with self.assertRaisesRegex(planar_chain.Failed, r"of 100 s after 10000\d\d steps: the rate of b_joint is \S+ rad/s, "
                                    "the torque in b_joint 1e.12 N m; expected at most 1000000 steps"):
            simulation.advance_to(100)
        # The state is that of the last step, from which it can go on.
        self.assertGreater(abs(simulation.qd).max(), 1e8)
        time_then = simulation.time
        self.assertTrue(0 < time_then < 0.005)
        with self.assertRaises(planar_chain.Failed):
            simulation.advance_to(0.005, most_steps=1000)
        self.assertGreater(simulation.time, time_then)
        simulation.hold_torque("b_joint", 0)
        fast = rods.with_values({"links/b/initial/velocity": 1e9})
        with self.assertRaisesRegex(planar_chain.Failed, r"the rate of \w_joint is \S+e.0[89] rad/s"):
            planar_chain.simulate(fast, [0.0, 0.5], most_steps=1000)
        self.assertEqual(planar_chain.simulate(rods, [1], most_steps=10000).shape, (1, 4))
        # The energy guard repeats a fixed step in many small ones.
        coarse = Scene({**rods.to_dict(), "integrator": {"method": "rk4", "step": 1e-4}, "loads": {"blast": {"joint": "b_joint", "torque": 1e12}}})
        self.assertRegex(planar_chain.simulate_many(coarse, [1], parameters={"links/a/mass": [1]}).reasons[0],
                         r"after 10000\d\d steps: .* expected at most 1000000 steps")
        # Steps that the user has chosen are not counted, unless asked for.
        small = Scene({**rods.to_dict(), "integrator": {"method": "rk4", "step": 5e-7}})
        planar_chain.simulate(small, [1])
        with self.assertRaisesRegex(planar_chain.Failed, "after 10\d\d steps"):
            planar_chain.simulate(small, [1], most_steps=1000)

    def test_wrong_types_are_refused_in_words(self):
        scene = Scene(PENDULUM)
        simulation = Simulation(scene)
        rope = Simulation(Scene({"chain": ["r"], "links": {"r": {**ROD, "repeat": 12}}}))
        masked = np.ma.array([0.5], mask=[True])
        for call, words in (
                (lambda: rope.hold_force("x", [1, 0]), "link: .* " + re.escape(f"({', '.join(f'r_{k}' for k in range(1, 13))})")),
                (lambda: Simulation("pendulum"), r"scene: expected a planar_chain.Scene \(Scene.from_file\(.*\) reads one\), got 'pendulum'"),
                (lambda: planar_chain.simulate(scene, "abc"), "times: expected an array of numbers, got 'abc'"),
                (lambda: planar_chain.simulate_many(scene, [1], parameters=[1]), r"parameters: expected a dict, got \[1\]"),
                (lambda: planar_chain.equations(scene, "a"), "q: expected an array of numbers, got 'a'"),
                (lambda: Scene("a.yaml"), r"scene: expected a dict \(Scene.from_file reads a file, from_yaml text\), got 'a.yaml'"),
                (lambda: Scene.from_yaml(3), "text: expected text, got 3"),
                (lambda: scene.with_values({"links/rod/mass": "heavy"}), "links/rod/mass: expected a number, got 'heavy'"),
                (lambda: scene.with_values({"links/rod/mass": True}), "links/rod/mass: expected a number, got True"),
                (lambda: simulation.set_state(np.array([np.timedelta64(1, "s")], dtype=object), [0]), "q: expected a number, got .*timedelta64"),
                (lambda: simulation.set_state(np.array(["1"], dtype=object), [0]), "q: expected a number, got '1'"),
                (lambda: Scene.from_file("a\0b"), "a b: expected a file, or one of the scenes that ship"),
                (lambda: Scene.from_file(""), '"": expected a file, or one of the scenes that ship'),
                (lambda: Scene.from_file(None), "path: expected a path, or the name of a scene that ships, got None"),
                (lambda: simulation.hold_torque(0, "a"), "torque: expected a number, got 'a'"),
                (lambda: simulation.hold_torque(0, np.nan), "torque: expected a finite number, got nan"),
                (lambda: simulation.add_force(0, [1, 0]), "duration: expected a number, got None"),
                (lambda: simulation.hold_force(0, [1, np.inf]), r"force: expected two finite numbers, got \[1, inf\]"),
                (lambda: simulation.hold_force(0, 3), "force: expected an array of 2 numbers, got one number"),
                (lambda: simulation.set_state(None, [0]), "q: expected an array of numbers, got None"),
                (lambda: Scene.from_yaml("\ud800"), r"text: expected text, got '\\ud800'"),
                (lambda: Scene({"\ud800": 1}), "scene: expected a dict whose keys are text, got"),
                (lambda: scene.with_values({"\ud800": 1}), r"numbers: expected text, got '\\ud800'"),
                (lambda: simulation.hold_torque("\ud800", 1), r"joint: expected .*, got '\\ud800'"),
                (lambda: simulation.hold_torque(True, 1.), "joint: expected the name of a joint, or a number from 0 to 0, got True"),
                (lambda: simulation.hold_force(np.False_, [1, 0]), "link: expected the name of a link, or a number from 0 to 0, got "),
                (lambda: simulation.advance_to(1, most_steps=True), "most_steps: expected a whole number >= 1, got True"),
                (lambda: simulation.set_state(masked, [0]), r"q: expected an array without a mask \(filled\(numpy.nan\) makes gaps\), got a masked"),
                (lambda: planar_chain.simulate(scene, masked), "times: expected an array without a mask"),
                (lambda: planar_chain.simulate_many(scene, [1], initial=[masked]), "initial: expected an array without a mask"),
                (lambda: scene.with_values({"links/rod/mass": np.ma.masked}), "links/rod/mass: expected a number, got masked"),
                (lambda: Scene({**PENDULUM, "gravity": np.ma.array([0, 1], mask=[0, 1])}), "gravity: expected an array without a mask"),
                (lambda: simulation.hold_torque(0, 1, until=np.nan), "the end of a command must be a time"),
                (lambda: simulation.hold_torque(0, 1, start=np.nan), "the start of a command must be finite"),
                (lambda: simulation.hold_torque(0, 1, until=-1, start=-2), "a command must end after the present time"),
                (lambda: simulation.hold_torque(0, 1, until=1, start=2), "a command must end after it starts"),
                (lambda: simulation.advance_to("1"), "t: expected a number, got '1'"),
                (lambda: simulation.advance_to(1, most_steps=0), "most_steps: expected a whole number >= 1"),
                (lambda: Simulation(scene, commands="a"), "commands: expected a whole number >= 0")):
            with self.assertRaises((ValueError, TypeError)) as caught:
                call()
            self.assertRegex(str(caught.exception), "^" + words)

    def test_wrong_arguments_of_a_call_are_named(self):
        scene = Scene(PENDULUM)
        simulation = Simulation(scene)
        of_force = "link, force, point=None, duration=None, moment=0.0, start=-?[0-9.einf]+"
        for call, words in (
                (lambda: planar_chain.simulate(scene, [1], x=1), "planar_chain.simulate: expected the arguments scene, times, "
                                                                 "most_steps=None, got unexpected argument 'x'"),
                (lambda: planar_chain.simulate(scene), "planar_chain.simulate: .*, got no argument 'times'"),
                (lambda: planar_chain.simulate(scene, [1], scene=scene), "planar_chain.simulate: .*, got argument 'scene' given twice"),
                (lambda: Simulation(scene, 1, 2, 3), "planar_chain.Simulation: expected the arguments scene, commands=16, got 2 arguments too many"),
                (lambda: Scene(), "planar_chain.Scene: expected the arguments values, got no argument 'values'"),
                (lambda: Scene.from_file("triple", "leg"), "planar_chain.Scene.from_file: expected the arguments path, got 1 argument too many"),
                (lambda: simulation.add_force(0, (0, 1), at=3), "planar_chain.Simulation.add_force: expected the arguments " + of_force +
                                                                ", got unexpected argument 'at'"),
                (lambda: simulation.reset(1), "planar_chain.Simulation.reset: expected the arguments none, got 1 argument too many"),
                (lambda: Simulation.reset(scene), "planar_chain.Simulation.reset: expected the arguments none, got an argument of another type")):
            with self.assertRaises(TypeError) as caught:
                call()
            self.assertRegex(str(caught.exception), "^" + words + "$")

    def test_objects_print_what_they_are(self):
        scene = Scene(PENDULUM)
        simulation = Simulation(scene)
        simulation.advance_to(0.5)
        balance = simulation.energy_balance()
        self.assertEqual((repr(scene), repr(simulation)), ("<Scene, n = 1>", "<Simulation, n = 1, t = 0.5 s>"))
        self.assertEqual(repr(balance.now), f"Energy(kinetic={balance.now.kinetic}, potential={balance.now.potential}, elastic=0.0)")
        self.assertTrue(repr(balance).startswith(f"EnergyBalance(now={balance.now!r}, supplied=0.0, "), balance)
        self.assertRegex(repr(simulation.statistics()), r"^Statistics\(steps=\d+, rejected=\d+, evaluations=\d+, rescues=0, local_error=.*\)$")
        runs = planar_chain.simulate_many(scene, [0.1], parameters={"links/rod/mass": [1, -1, 2]})
        self.assertEqual(repr(runs), "<Runs: 3, 1 failed>")
        measured = Simulation(Scene({**PENDULUM, "sensors": {"angle": {"joints": "all", "rate": 10}}}))
        measured.advance_to(0.05)
        self.assertEqual(repr(measured.measure()[0]), "Measurement(sensor='angle', time=0.0, values=array([0.]))")

    def test_measurements_that_nobody_takes_are_lost_and_counted(self):
        simulation = Simulation(Scene({**PENDULUM, "sensors": {"imu": {"link": "rod", "rate": 1e4}}}))
        simulation.advance_to(20)
        with self.assertWarnsRegex(UserWarning, "^33335 measurements are lost: call measure"):
            taken = simulation.measure()
        self.assertEqual([len(taken), taken[0].number, taken[-1].number], [166666, 33335, 200000])

    def test_what_is_built_is_not_built_again(self):
        scene = Scene(PENDULUM)
        simulation = Simulation(scene)
        simulation.advance_to(1)
        for call, name in ((lambda: simulation.__init__(scene), "Simulation"), (lambda: scene.__init__({}), "Scene"),
                           (lambda: scene.__setstate__(({},)), "Scene")):
            with self.assertRaisesRegex(TypeError, f"^planar_chain.{name}: this object is built already; build another one$"):
                call()
        self.assertEqual((simulation.time, len(scene)), (1, 1))
        derived = type("Derived", (Simulation,), {"__init__": lambda self: Simulation.__init__(self, scene)})()
        self.assertEqual(derived.time, 0)
        with self.assertRaises(TypeError):
            derived.__init__()

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
        functions = {"equations": planar_chain.equations, "linearize": planar_chain.linearize,
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


class Empty(unittest.TestCase):
    def test_what_was_not_initialized_is_refused(self):
        core = sys.modules["planar_chain._core"]
        classes = [thing for thing in vars(core).values() if isinstance(thing, type) and not issubclass(thing, Exception)]
        self.assertEqual(len(classes), 8)
        for each in classes:
            empty = each.__new__(each)
            properties = [name for name, member in vars(each).items() if isinstance(member, property)]
            self.assertTrue(properties, each)
            for name in properties:
                with self.assertRaisesRegex(TypeError, each.__name__ + ": expected an object that __init__"):
                    getattr(empty, name)
        scene, simulation = Scene.__new__(Scene), Simulation.__new__(Simulation)
        for call in (simulation.settle, lambda: simulation.advance_to(1), lambda: Simulation(scene), lambda: len(scene),
                     lambda: planar_chain.simulate(scene, [1]), lambda: planar_chain.simulate_many(scene, [1], [[0]]),
                     lambda: pickle.dumps(scene), scene.to_dict):
            with self.assertRaisesRegex(TypeError, "expected an object that __init__"):
                call()


class Arrays(unittest.TestCase):
    def test_results_are_the_callers_own(self):
        simulation = Simulation(Scene.from_file(shipped("double_pendulum")))
        before = simulation.state
        simulation.advance_to(1)
        self.assertEqual(before.tolist(), [1.2, 0.9, 0, 0])
        simulation.q[0] = 7
        self.assertNotEqual(simulation.q[0], 7)
        states = planar_chain.simulate(Scene(PENDULUM), np.arange(3))
        self.assertEqual((states.shape, states.dtype, states.flags.c_contiguous), ((3, 2), np.float64, True))

    def test_any_array_of_numbers_is_taken(self):
        simulation = Simulation(Scene.from_file(shipped("double_pendulum")))
        simulation.set_state(np.arange(4)[::2], np.array([1, 2], dtype=np.float32))
        self.assertEqual(simulation.state.tolist(), [0, 2, 1, 2])
        for bad in ([[0, 1]], [0], "ab", [0, np.inf], None):
            with self.assertRaises((ValueError, TypeError)):
                simulation.set_state(bad, [0, 0])
        for bad, kind in ((np.array([0, 1j]), "complex128"), (["0", "1"], "<U1"), (np.array([b"0", b"1"]), "S1"),
                          (np.array([0, 1], dtype="m8[s]"), "m8")):
            with self.assertRaisesRegex(Refused, r"^q: expected an array of real numbers, got one of dtype\('.*" + kind):
                simulation.set_state(bad, [0, 0])
        self.assertEqual(simulation.state.tolist(), [0, 2, 1, 2])


    def test_numbers_of_a_scene_are_real_and_no_bytes(self):
        for key, bad, fault in (("com", b"\x01\x02", r"a dict, a list, a number, a bool or text, got b'\\x01\\x02'"),
                                ("com", bytearray(2), "a dict, a list, a number, a bool or text, got bytearray"),
                                ("mass", np.bool_(True), "a number > 0 kg, got true"),
                                ("mass", np.complex128(1 + 2j), r"a real number, got \(1\+2j\)"),
                                ("mass", np.complex64(1), "a real number, got"), ("mass", 1j, "a real number, got 1j")):
            with self.assertRaisesRegex(Refused, f"^links/rod/{key}: expected {fault}"):
                Scene({**PENDULUM, "links": {"rod": {**ROD, key: bad}}})
        with self.assertRaisesRegex(Refused, "^links/rod/mass: expected a number, got"):
            Scene(PENDULUM).with_values({"links/rod/mass": np.complex128(1)})


class Threads(unittest.TestCase):
    def setUp(self):
        self.simulation = Simulation(Scene.from_file(shipped("double_pendulum")))

    def test_sensors_of_a_chain_at_rest_do_not_keep_a_long_step(self):
        scene = Scene({**PENDULUM, "sensors": {"angle": {"joints": "all", "rate": 10000}}})
        with self.assertRaisesRegex(planar_chain.Failed, r"stopped at t = [0-9.]+ s of 1e.12 s after"):
            Simulation(scene).advance_to(1e12, most_steps=3)

    def test_ctrl_c_ends_an_integration(self):
        threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()
        with self.assertRaises(KeyboardInterrupt):
            self.simulation.advance_to(1e6)
        self.assertGreater(self.simulation.time, 0)
        time_then = self.simulation.time
        self.simulation.advance_to(time_then + 1)

    def test_ctrl_c_ends_a_search_for_an_equilibrium(self):
        cable = Scene.from_file(shipped("cable"))
        angles = np.random.default_rng(1).normal(size=len(cable))  # the search takes many seconds
        simulation = Simulation(cable)
        simulation.set_state(angles, np.zeros(len(cable)))
        for search in (lambda: planar_chain.equilibrium(cable, angles), simulation.settle):
            began = time.monotonic()
            threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()
            with self.assertRaises(KeyboardInterrupt):
                search()
            self.assertLess(time.monotonic() - began, 5)

    def test_others_run_while_long_chains_are_computed(self):
        turns, over = [], threading.Event()

        def other():
            while not over.wait(0.001):
                turns.append(0)

        thread = threading.Thread(target=other)
        thread.start()
        self.addCleanup(thread.join)
        self.addCleanup(over.set)
        middle, long = (Scene({"chain": ["rod"], "links": {"rod": {**ROD, "repeat": n}}}) for n in (500, 100000))
        simulation = Simulation(long)
        for name, call in {"Scene": lambda: pickle.loads(pickle.dumps(long)), "Simulation": lambda: Simulation(long),
                           "settle": simulation.settle, "equilibrium": lambda: planar_chain.equilibrium(long),
                           "equations": lambda: planar_chain.equations(middle), "linearize": lambda: planar_chain.linearize(middle),
                           "inverse": lambda: planar_chain.inverse_dynamics(long, np.zeros(100000))}.items():
            before = len(turns)
            call()
            self.assertGreater(len(turns) - before, 5, name)

    def test_others_run_meanwhile_but_not_this_simulation(self):
        refused = []

        def other():
            for _ in range(3):
                time.sleep(0.05)
                try:
                    refused.append(str(self.simulation.state))
                except RuntimeError as error:
                    refused.append(str(error))
            os.kill(os.getpid(), signal.SIGINT)

        thread = threading.Thread(target=other)
        thread.start()
        with self.assertRaises(KeyboardInterrupt):
            self.simulation.advance_to(1e6)
        thread.join()
        self.assertEqual(refused, ["another thread advances this simulation"] * 3)


class Page(unittest.TestCase):
    def test_its_examples_run_one_after_the_other(self):
        with open(os.path.join(ROOT, "src/python/README.md"), encoding="utf-8") as file:
            blocks = re.findall(r"^```python\n(.*?)^```$", file.read(), re.MULTILINE | re.DOTALL)
        run = subprocess.run([sys.executable, "-c", "".join(blocks)], cwd=ROOT, stdout=subprocess.PIPE,
                             universal_newlines=True, check=True)
        self.assertIn("robot_description: expected", run.stdout)
        self.assertIn("(1000, 3, 4) True {}", run.stdout)


class Readme(unittest.TestCase):
    def test_its_pushes_are_swings(self):
        """In their order, a minute after each other: no link turns over."""
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


class Package(unittest.TestCase):
    def test_it_loads_nothing_before_it_is_used(self):
        script = "import planar_chain, sys; print('numpy' in sys.modules, 'planar_chain._core' in sys.modules, *dir(planar_chain))"
        loaded = subprocess.run([sys.executable, "-c", script], check=True, stdout=subprocess.PIPE, universal_newlines=True).stdout.split()
        self.assertEqual(loaded[:2], ["False", "False"])
        self.assertLessEqual(set(planar_chain.__all__), set(loaded))
        with self.assertRaises(AttributeError):
            planar_chain.missing  # pylint: disable=pointless-statement,no-member

    def test_messages_are_in_it(self):
        if not os.path.isdir(os.path.join(os.path.dirname(planar_chain.__file__), "msg")):
            self.skipTest("built without ROS")
        from planar_chain.msg import SimStatus
        self.assertEqual(SimStatus().fault, "")

    def test_stubs_name_all_that_there_is(self):
        core = sys.modules["planar_chain._core"]
        folder = os.path.dirname(core.__file__)
        with open(os.path.join(folder, "_core.pyi"), encoding="utf-8") as file:
            stub = ast.parse(file.read())

        def names(body):
            return {node.name: node for node in body if isinstance(node, (ast.FunctionDef, ast.ClassDef))}

        def arguments(node):
            return [argument.arg for argument in node.args.args]

        self.assertEqual(set(names(stub.body)), {name for name in dir(core) if not name.startswith("_")})
        for name, node in names(stub.body).items():
            thing = getattr(core, name)
            self.assertTrue(thing.__doc__, name)
            members = {name: (thing, node)}
            if isinstance(node, ast.ClassDef):
                found = {member for member in vars(thing) if not member.startswith("_")} - {"args"}
                self.assertEqual({member for member in names(node.body) if not member.startswith("_")}, found, name)
                members = {member: (getattr(thing, member), inner) for member, inner in names(node.body).items()}
            for member, (real, inner) in members.items():
                if isinstance(inner, ast.FunctionDef) and callable(real):
                    text = real.__doc__.split("\n")[0]
                    for argument in arguments(inner):
                        self.assertIn(f"{argument}:", text, f"{name}.{member}")


if __name__ == "__main__":
    BIN = sys.argv.pop(1)
    unittest.main()
