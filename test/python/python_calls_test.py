#!/usr/bin/python3
"""The Python module: wrong calls in words, failures, what objects print; its arrays, its threads, its stubs.

    python_calls_test.py BIN [unittest options]       BIN is not used; PYTHONPATH finds planar_chain
"""
import ast
import os
import pickle
import re
import signal
import subprocess
import sys
import threading
import time
import unittest

from python_test import PENDULUM, ROD, shipped  # skips without numpy  # pylint: disable=wrong-import-order
import numpy as np

import planar_chain
from planar_chain import Refused, Scene, Simulation


class Calls(unittest.TestCase):
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
                (lambda: Scene.from_urdf("robot.urdf"), r"text: expected the text of a URDF, as of open\(path\).read\(\), got 'robot.urdf'"),
                (lambda: planar_chain.simulate(scene, 10), r"times: expected an array .*, such as numpy.linspace\(0, 10, 1001\), got 10$"),
                (lambda: Scene.from_yaml(3), "text: expected text, got 3"),
                (lambda: scene.with_values({"links/rod/mass": "heavy"}), "links/rod/mass: expected a number, got 'heavy'"),
                (lambda: scene.with_values({"links/rod/mass": True}), "links/rod/mass: expected a number, got True"),
                (lambda: simulation.set_state(np.array([np.timedelta64(1, "s")], dtype=object), [0]), "q: expected a number, got .*timedelta64"),
                (lambda: simulation.set_state(np.array(["1"], dtype=object), [0]), "q: expected a number, got '1'"),
                (lambda: Scene.from_file("a\0b"), "a b: expected a file, or one of the scenes that ship"),
                (lambda: Scene.from_file(""), '"": expected a file, or one of the scenes that ship'),
                (lambda: Scene.from_file(None), "path: expected a path, or the name of a scene that ships, got None"),
                (lambda: simulation.set_state([True], [0]), "q: expected an array of real numbers, got one of dtype.'bool'"),
                (lambda: simulation.hold_torque(0, "a"), "torque: expected a number, got 'a'"),
                (lambda: simulation.hold_torque(0, np.nan), "torque: expected a finite number, got nan"),
                (lambda: simulation.add_force(0, [1, 0]), "duration: expected a number, got None"),
                (lambda: simulation.hold_force(0, [1, np.inf]), r"force: expected two numbers from -1e100 to 1e100, got \[1, inf\]"),
                (lambda: simulation.hold_force(0, [1, 0], [1e308, 0]), r"point: expected two numbers from -1e100 to 1e100, got \[1e.308, 0\]"),
                (lambda: simulation.add_force(0, [1, 0], None, 1, 1e101), "moment: expected a number from -1e100 to 1e100, got 1e.101"),
                (lambda: simulation.hold_torques([1e308]), "torques/0: expected a number from -1e100 to 1e100, in N m, got 1e.308"),
                (lambda: simulation.hold_force(0, 3), "force: expected an array of 2 numbers, got one number"),
                (lambda: simulation.set_state(None, [0]), "q: expected an array of numbers, got None"),
                (lambda: Scene.from_yaml("\ud800"), r"text: expected text, got '\\ud800'"),
                (lambda: Scene({"\ud800": 1}), "scene: expected a dict whose keys are text, got"),
                (lambda: scene.with_values({"\ud800": 1}), r"numbers: expected text, got '\\ud800'"),
                (lambda: simulation.hold_torque("\ud800", 1), r"joint: expected .*, got '\\ud800'"),
                (lambda: simulation.hold_torque("nö", 1.), "joint: expected .*, got 'nö'"),
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
                                                                 "most_steps=None, derivatives=None, events=None, got unexpected argument 'x'"),
                (lambda: planar_chain.simulate(scene, [1], method="rk4"),
                 r"planar_chain.simulate: .*, got unexpected argument 'method' \(give it to the scene: " +
                 re.escape('Scene({**scene.to_dict(), "integrator": {\'method\': \'rk4\'}}))')),
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
        self.assertEqual((repr(scene), repr(simulation)),
                         ("<Scene, n = 1, links: rod; joints: rod_joint>", "<Simulation, n = 1, t = 0.5 s>"))
        self.assertEqual(repr(Scene.from_file("cart_pole")), "<Scene, n = 2, links: cart, pole; joints: cart_joint, pole_joint\n gravity, "
                         "2 joint limits, 1 effort limit>")
        self.assertRegex(repr(Scene.from_file("rope")), r"^<Scene, n = \d+, links: \w+, .*, ... \(\d+\); joints: .* \(\d+\)\n gravity, \d+ dampers>$")
        self.assertEqual(repr(balance.now), f"Energy(kinetic={balance.now.kinetic}, potential={balance.now.potential}, elastic=0.0)")
        self.assertTrue(repr(balance).startswith(f"EnergyBalance(now={balance.now!r}, supplied=0.0, "), balance)
        self.assertRegex(repr(simulation.statistics()), r"^Statistics\(steps=\d+, rejected=\d+, evaluations=\d+, rescues=0, local_error=.*\)$")
        runs = planar_chain.simulate_many(scene, [0.1], parameters={"links/rod/mass": [1, -1, 2]})
        self.assertEqual(repr(runs), "<Runs: 3, 1 failed>")
        measured = Simulation(Scene({**PENDULUM, "sensors": {"angle": {"joints": "all", "rate": 10}}}))
        self.assertEqual(repr(Scene({**PENDULUM, "sensors": {"imu": {"link": "rod"}}}))[-11:], "\n 1 sensor>")
        measured.advance_to(0.05)
        self.assertEqual(repr(measured.measure()[0]), "Measurement(sensor='angle', time=0.0, values=array([0.]))")

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

    def test_a_duration_in_the_place_of_a_point_is_told(self):
        with self.assertRaisesRegex(planar_chain.Refused, "point: expected an array of 2 numbers, got one number"):
            Simulation(Scene(PENDULUM)).add_force("rod", [1, 0], 0.1)


class Failures(unittest.TestCase):
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
            simulation.hold_torque(0, 1e100)
            time_then, state = simulation.time, simulation.state.tolist()
            for _ in range(2):
                with self.assertRaisesRegex(planar_chain.Failed, cure):
                    simulation.advance_to(time_then + 1)
            self.assertEqual((simulation.time, simulation.state.tolist()), (time_then, state))
            mend()
            if k > 0:
                simulation.clear_commands()
            simulation.advance_to(simulation.time + 0.1)

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


class Empty(unittest.TestCase):
    def test_what_was_not_initialized_is_refused(self):
        core = sys.modules["planar_chain._core"]
        classes = [thing for thing in vars(core).values() if isinstance(thing, type) and not issubclass(thing, Exception)]
        self.assertEqual(len(classes), 11)
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

    def test_sensors_within_a_bad_fixed_step_end_with_the_steps(self):
        fast = {**PENDULUM["links"]["rod"], "initial": {"velocity": 1e7}}
        simulation = Simulation(Scene({"chain": ["a", "b"], "links": {"a": fast, "b": {**fast, "initial": {"velocity": -3e7}}},
                                       "integrator": {"method": "rk4", "step": 0.01},
                                       "sensors": {"angle": {"joints": "all", "rate": 1000}}}))
        with self.assertRaisesRegex(planar_chain.Failed, "expected at most 1000 steps"):
            simulation.advance_to(1, most_steps=1000)
        self.assertLess(simulation.statistics().evaluations, 20000)

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
        self.assertEqual(refused, ["another thread advances this simulation, or it calls an event function, which may not use it"] * 3)


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
    sys.argv.pop(1)
    unittest.main()
