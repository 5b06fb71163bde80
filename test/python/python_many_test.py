#!/usr/bin/python3
"""simulate_many from Python: against single runs; threads, parameters, failures, interrupts. The double pendulum never
flips where its energy forbids it.

    python_many_test.py BIN [unittest options]        BIN is not used; PYTHONPATH finds planar_chain
"""
import os
import signal
import sys
import threading
import unittest
import warnings

try:
    import numpy as np
except ImportError:
    print("numpy not found: skipped")
    sys.exit(77)

from planar_chain import Refused, Scene, Simulation, simulate, simulate_many

SCENES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../config/scenes")
EXAMPLES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../src/python/examples")
ROD = {"mass": 1.0, "inertia": 1 / 12, "com": [0.5, 0.0], "pin": [1.0, 0.0]}
DOUBLE = Scene({"chain": ["upper", "lower"], "links": {"upper": ROD, "lower": ROD}})
TOLERANCE = 1e-8  # per second, of the scene
RANDOM = np.random.default_rng(23)


class Many(unittest.TestCase):
    def test_each_run_is_the_single_run_to_the_tolerance(self):
        times = [0.0, 0.3, 0.5]
        for runs in range(1, 41):
            starts = np.column_stack([RANDOM.uniform(-2, 0, (runs, 2)), RANDOM.normal(size=(runs, 2))])
            masses, lengths = RANDOM.uniform(0.5, 2, (2, runs))
            parameters = {"links/lower/mass": masses, "links/upper/pin/0": lengths, "links/lower/joint/damping": masses / 9}
            many = simulate_many(DOUBLE, times, starts, parameters)
            self.assertEqual((many.states.shape, many.done.all(), many.reasons), ((runs, 3, 4), True, {}))
            self.assertTrue((many.steps > 0).all())
            for run, start in enumerate(starts):
                single = DOUBLE.with_values({path: values[run] for path, values in parameters.items()}).with_values({
                    "links/upper/initial/angle": start[0], "links/lower/initial/angle": start[1],
                    "links/upper/initial/velocity": start[2], "links/lower/initial/velocity": start[3]})
                growth = 100  # of an error, in half a second
                np.testing.assert_allclose(many.states[run], simulate(single, times), atol=growth * TOLERANCE, rtol=0)

    def test_torques_are_held_as_by_a_loop(self):
        times = [0.0, 0.05, 0.05, 0.1, 0.4]
        for name, bits in (("double_pendulum", False), ("cart_pole", True), ("four_bar", True)):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # what was moved to close the four-bar
                scene = Scene.from_file(name)
            n = len(scene.joints)
            torques = RANDOM.normal(size=(5, len(times), n))
            many = simulate_many(scene, times, torques=torques)
            self.assertEqual((many.states.shape, many.reasons), ((5, len(times), 2 * n), {}))
            for run, states in enumerate(many.states):
                simulation = Simulation(scene)
                for t, tau, state in zip(times, torques[run], states):
                    if t > simulation.time:
                        simulation.hold_torques(tau)
                    simulation.advance_to(t)
                    np.testing.assert_allclose(state, simulation.state, atol=0 if bits else 1e-7, rtol=0)

    def test_runs_go_on_from_a_saved_state(self):
        values = DOUBLE.to_dict()
        lagging = {"effort_limit": 5.0, "friction": 0.3, "motor": {"time_constant": 0.05}, "command_delay": 0.02}
        scene = Scene({**values, "links": {**values["links"], "upper": {**ROD, "joint": lagging}}})
        simulation = Simulation(scene)
        simulation.hold_torques([4.0, 0.1])
        simulation.advance_to(0.21)  # one torque still lags
        saved = simulation.save()
        times = [0.21, 0.3, 0.45]
        torques = RANDOM.normal(size=(7, 3, 2))
        many = simulate_many(scene, times, torques=torques, state=saved)
        self.assertEqual(many.reasons, {})
        for states, steps, run in zip(many.states, many.steps, torques):
            simulation.restore(saved)
            before = simulation.statistics().steps
            for t, tau, state in zip(times, run, states):
                if t > simulation.time:
                    simulation.hold_torques(tau)
                simulation.advance_to(t)
                self.assertEqual(state.tolist(), simulation.state.tolist())
            self.assertEqual(steps, simulation.statistics().steps - before)
        for arguments, fault in (
                ({"state": saved, "times": [0.2]}, "times/0: expected a number >= 0.21 s, the time of the state, got 0.2"),
                ({"state": saved, "scene": DOUBLE}, "saved: expected a state of the same scene"),
                ({"state": Simulation(scene, commands=0).save(), "times": [0.0]}, "state: expected one of a simulation with commands"),
                ({"state": 3}, "state: expected a state that Simulation.save.. returned, got 3"),
                ({"state": saved, "initial": np.zeros((7, 4))}, "state: expected no initial states"),
                ({"state": saved, "torques": None}, "torques: expected those of each run")):
            with self.assertRaisesRegex(Refused, fault):
                simulate_many(**{"scene": scene, "times": [0.4], "torques": torques[:, :1], **arguments})

    def test_values_of_a_ramp_are_numbers_of_a_run(self):
        loads = {"u": {"joint": "upper_joint", "torque": 1.0, "times": [0, 0.5, 1], "values": [0, 0, 0]}}
        scene = Scene({**DOUBLE.to_dict(), "loads": loads})
        values = RANDOM.normal(size=(3, 3))
        many = simulate_many(scene, [1.0], parameters={f"loads/u/values/{i}": values[:, i] for i in range(3)})
        for run in range(3):
            single = Scene({**scene.to_dict(), "loads": {"u": {**loads["u"], "values": values[run].tolist()}}})
            self.assertEqual(many.states[run].tolist(), simulate(single, [1.0]).tolist())

    def test_threads_and_neighbours_do_not_matter(self):
        starts = RANDOM.uniform(-2, 2, (33, 4))
        alone = simulate_many(DOUBLE, [1.0], starts, threads=1).states
        self.assertEqual(simulate_many(DOUBLE, [1.0], starts, threads=3).states.tolist(), alone.tolist())
        self.assertEqual(simulate_many(DOUBLE, [1.0], starts[5:9]).states.tolist(), alone[5:9].tolist())

    def test_a_run_without_end_is_marked_and_the_others_go_on(self):
        rates = [1.0, 1e10, 2.0]
        for method in ("auto", "dopri5"):  # in lanes, and alone
            scene = Scene({**DOUBLE.to_dict(), "integrator": {"method": method}})
            many = simulate_many(scene, [0.0, 0.5], parameters={"links/lower/initial/velocity": rates}, most_steps=20000)
            self.assertEqual(many.done.tolist(), [True, False, True])
            self.assertRegex(many.reasons[1], r"of 0.5 s after 200\d\d steps: the rate of \w+_joint is ")
            self.assertTrue(np.isfinite(many.states[:, 0]).all() and np.isnan(many.states[1, 1]).all())
        many = simulate_many(DOUBLE, [1.0], parameters={"links/lower/initial/velocity": rates})
        self.assertEqual(many.done.tolist(), [True, False, True])

    def refused(self, scene, paths, runs=2):
        with self.assertRaises(Refused) as caught:
            simulate_many(scene, [1.0], parameters={path: np.ones(runs) for path in paths})
        return {fault.path: f"expected {fault.expected}, got {fault.found}" for fault in caught.exception.faults}

    def test_paths_that_lead_to_no_number_are_refused_at_once(self):
        keys = "expected one of the keys mass, inertia, com, pin, repeat, joint, initial, drag, got"
        faults = {"links/lowr/mass": 'expected a link listed in chain (did you mean lower?), got "lowr"', "links/lower/masss": 'expected a known key (did you mean links/lower/mass?), got "masss"',
                  "links/lower/weight": f'{keys} "weight"',
                  "links/lower": "expected the path of a number, got that of a map",
                  "links/lower/com": "expected the path of a number, got that of a list",
                  "links/lower/com/2": 'expected a number of the scene, got [0.5, 0] above "2"',
                  "links/lower/com/1e0": 'expected a number of the scene, got "links/lower/com/1e0"',
                  "links/lower/mass/x": 'expected a number of the scene, got 1 above "x"',
                  "links//lower/mass/": "expected no empty name in the path (did you mean links/lower/mass?), got one",
                  "/": "expected no empty name in the path, got one",
                  "start": "expected the path of a number, got that of initial or rest",
                  "publish/tf": "expected the path of a number, got that of true or false",
                  "robot": "expected one of the keys chain", "": "expected one of the keys chain",
                  "/".join("a" * 16): "expected a path of at most 15 names, got 16"}
        for paths in (faults, *([path] for path in faults)):
            for runs in (0, 1, 2):
                found = self.refused(DOUBLE, paths, runs)
                self.assertEqual(set(found), set(paths))
                for path in paths:
                    self.assertIn(faults[path], found[path])
        # What is missing beside a number is named.
        self.assertEqual(self.refused(DOUBLE, ["loads/push/torque", "links/lower/joint/drive/amplitude"]), {
            "loads/push/joint": "expected the joint in which the torque acts, got nothing",
            "links/lower/joint/drive/frequency": "expected amplitude and frequency, times and values, or offset, got nothing"})
        # What a number and a drive exclude is refused before any run, whichever of them varies.
        for joint, path in (({"drive": "hold"}, "links/upper/joint/friction"), ({"friction": 1}, "links/upper/joint/drive/offset")):
            self.assertEqual(self.refused(Scene({**DOUBLE.to_dict(), "links": {"upper": {**ROD, "joint": joint}, "lower": ROD}}), [path]),
                             {"links/upper/joint/friction": "expected no friction in a driven joint, got 1"})
        with self.assertRaisesRegex(Refused, r"links/lower/masss: expected a known key \(did you mean links/lower/mass\?\)"):
            DOUBLE.with_values({"links/lower/masss": 1})
        for path in ("/".join("a" * 20000), "links/" + "/".join("a" * 20000)):  # a tree as deep overflows the stack
            words = "^(links/)?a/a/.*…: expected a path of at most 15 names, got 2000[01]$"
            self.assertRaisesRegex(Refused, words, DOUBLE.with_values, {path: 1})
            self.assertRaisesRegex(Refused, words, simulate_many, DOUBLE, [], parameters={path: []})

    def test_each_number_of_the_scenes_may_vary_and_nothing_else(self):
        def leaves(value, path=""):
            if isinstance(value, (dict, list)):
                for key, item in value.items() if isinstance(value, dict) else enumerate(value):
                    yield from leaves(item, f"{path}/{key}" if path else str(key))
            else:
                yield path, value
        for name in sorted(os.listdir(SCENES)):
            scene = Scene.from_file(os.path.join(SCENES, name))
            numbers, others = {}, []
            for path, value in leaves(scene.to_dict()):
                if isinstance(value, float):
                    numbers[path] = [value]
                else:
                    others.append(path)
            self.assertEqual(simulate_many(scene, [], parameters=numbers).reasons, {}, name)
            self.assertEqual(set(self.refused(scene, others)), set(others), name)
            misspelt = [path + "x" for path in numbers]
            self.assertEqual(set(self.refused(scene, misspelt)), set(misspelt), name)

    def test_a_bad_value_is_a_fault_of_its_run_wherever_it_stands(self):
        for path, value in (("links/lower/mass", -1), ("links/lower/com/0", np.inf), ("links/lower/initial/velocity", 1e200),
                            ("publish/rate", 5), ("links/lower/repeat", 2)):
            scene = Scene({**DOUBLE.to_dict(), "publish": {"tf_rate": 10, "rate": 50}})
            for others in (0, 1, 2):
                many = simulate_many(scene, [0.1], parameters={path: [value] + [50 if path == "publish/rate" else 1] * others})
                self.assertEqual((list(many.reasons), many.done.tolist()), ([0], [False] + [True] * others), path)

    def test_a_reason_is_one_line(self):
        many = simulate_many(DOUBLE, [1.0], parameters={"links/lower/mass": [-1], "links/upper/mass": [-2]})
        self.assertEqual(many.reasons[0], "links/lower/mass: expected a number > 0 kg, got -1; "
                                          "links/upper/mass: expected a number > 0 kg, got -2")
        self.assertNotIn("\n", simulate_many(DOUBLE, [1.0], np.full((1, 4), np.nan)).reasons[0])

    def test_notes_on_runs_are_told(self):
        numbers = {"links/lower/joint/friction": [0, 1e-12, 1e-3]}
        with self.assertWarnsRegex(UserWarning, "^1 of 3 runs have notes; of run 1: links/lower/joint/friction: is left out"):
            many = simulate_many(DOUBLE, [0.1], parameters=numbers)
        self.assertEqual(list(many.notes), [1])
        self.assertEqual(many.reasons, {})
        with self.assertWarnsRegex(UserWarning, "^links/lower/joint/friction: is left out"):
            weak = DOUBLE.with_values({"links/lower/joint/friction": 1e-12})
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # what the scene has is told already
            weak.with_values({"links/lower/mass": 2})
            self.assertEqual(simulate_many(weak, [0.1], parameters={"links/lower/mass": [1, 2]}).notes, {})

    def test_a_start_that_does_not_close_the_chain_is_told(self):
        closed = Scene.from_file(os.path.join(SCENES, "four_bar.yaml"))
        start = simulate_many(closed, [0], parameters={"links/crank/mass": [1]}).states[0, 0]
        with self.assertWarnsRegex(UserWarning, "^1 of 2 runs have notes; of run 1: the joint rocker_joint is moved by"):
            simulate_many(closed, [0], initial=[start, start + [0.2, -0.1, 0.3, 0, 0, 0]])

    def test_two_values_for_one_state_are_refused(self):
        with self.assertRaises(Refused) as caught:
            simulate_many(DOUBLE, [1.0], np.zeros((2, 4)), {"links/lower/initial/angle": [1, 2], "links/upper/masss": [1, 2],
                                                            "links/upper/initial/velocity": [1, 2]})
        self.assertEqual(sorted((fault.path, fault.expected) for fault in caught.exception.faults)[::2], [
            ("links/lower/initial/angle", "this number or an array of initial states"),
            ("links/upper/masss", "a known key (did you mean links/upper/mass?)")])
        self.assertEqual(len(caught.exception.faults), 3)
        named = Scene({"chain": ["initial"], "links": {"initial": ROD}})
        self.assertTrue(simulate_many(named, [1.0], np.zeros((1, 2)), {"links/initial/mass": [2]}).done.all())

    def test_what_fails_is_marked_and_says_why(self):
        blast = Scene({**DOUBLE.to_dict(), "loads": {"blast": {"joint": "lower_joint", "torque": 0.0, "start": 0.3}}})
        many = simulate_many(blast, [0.2, 0.4], parameters={"links/lower/mass": [1, -1, 1, 1, np.nan],
                                                            "loads/blast/torque": [0, 0, 1e200, 1, 0]})
        self.assertEqual(many.done.tolist(), [True, False, False, True, False])
        self.assertEqual(sorted(many.reasons), [1, 2, 4])
        self.assertEqual(many.reasons[1], "links/lower/mass: expected a number > 0 kg, got -1")
        self.assertIn("gave up", many.reasons[2])
        arrived = ~np.isnan(many.states).any(axis=2)
        self.assertEqual(arrived.tolist(), [[True] * 2, [False] * 2, [True, False], [True] * 2, [False] * 2])

    def test_bad_arguments_are_refused(self):
        for arguments in ({}, {"initial": np.zeros(4)}, {"initial": np.zeros((2, 3))}, {"parameters": {}},
                          {"parameters": {"a": [1, 2], "b": [1]}}, {"initial": np.zeros((2, 4)), "parameters": {"a": [1]}},
                          {"initial": np.zeros((1, 4)), "threads": -1}, {"initial": np.zeros((1, 4)), "times": [1, 0]}):
            with self.assertRaises(ValueError):
                simulate_many(DOUBLE, **{"times": [1.0], **arguments})
        starts = np.zeros((2, 4))
        for times, initial, options, words in (
                ([1.0], np.zeros((2, 3)), {}, "initial: expected an array of runs x 4, got 2 x 3"),
                ([1.0], np.zeros(4), {}, "initial: expected an array of runs x 4, got 4 numbers"),
                ([1.0], None, {}, "initial: expected initial states, parameters, or torques, got none of them"),
                ([1.0], starts, {"torques": np.zeros((2, 3, 2))}, "torques: expected an array of 2 x 1 x 2, for each run, time "
                 "and joint, got 2 x 3 x 2"),
                ([1.0], None, {"torques": [1.0, 2.0]}, "torques: expected an array of runs x 1 x 2, .*, got 2 numbers"),
                ([1.0], starts, {"torques": [[[0, 0]], [[0, np.nan]]]}, "torques/1/0/1: expected a finite number, in N m, got nan"),
                ([1.0], starts, {"torques": "upper_joint"}, "torques: expected an array of numbers, got 'upper_joint'"),
                ([1.0], starts, {"torques": {"upper_joint": [1]}}, "torques: expected a number, got {'upper_joint': \\[1\\]}"),
                ([1.0], starts, {"threads": -1}, "threads: expected a whole number >= 0, got -1"),
                ([1.0], starts, {"threads": 10 ** 9}, "threads: expected at most 1048576, got 1000000000"),
                ([1.0], starts, {"progress": 3}, "progress: expected a function .*, got 3"),
                ([1.0], starts, {"parameters": {"links/lower/mass": [1]}},
                 "links/lower/mass: expected an array of 2 numbers, got 1 number"),
                ([1.0, 0.5, -1, np.nan], starts, {}, r"times/1: expected a finite number >= 1 s .*, got 0.5\n"
                 r"times/2: expected a finite number >= 0.5 s .*, got -1\ntimes/3: expected a finite number >= 0 s .*, got nan"),
                (1.0, starts, {}, "times: expected an array of one dimension, such as .*, got 1.0")):
            with self.assertRaisesRegex(Refused, words):
                simulate_many(DOUBLE, times, initial, **options)
        with self.assertRaisesRegex(Refused, "times/1: expected a finite number >= 2 s .*, got 1"):
            simulate(DOUBLE, [2, 1])

    def test_any_arrays_of_numbers_are_taken(self):
        starts = RANDOM.uniform(-1, 1, (3, 4))
        expected = simulate_many(DOUBLE, [0.5, 1.0], starts).states.tolist()
        padded = np.zeros((3, 8))
        padded[:, ::2] = starts
        for same in (np.asfortranarray(starts), padded[:, ::2], starts.astype(">f8"), starts.tolist(), starts.astype(object)):
            self.assertEqual(simulate_many(DOUBLE, np.array([9, 0.5, 9, 1.0])[1::2], same).states.tolist(), expected)
        self.assertEqual(simulate_many(DOUBLE, [], starts).states.shape, (3, 0, 4))
        self.assertEqual(simulate_many(DOUBLE, [1.0], np.zeros((0, 4))).states.shape, (0, 1, 4))

    def test_results_outlive_the_runs(self):
        states = simulate_many(DOUBLE, [0.0], np.ones((1000, 4))).states
        simulate_many(DOUBLE, [0.0], np.zeros((1000, 4)))
        self.assertTrue((states == 1).all())

    def test_progress_is_told_and_ctrl_c_ends_it(self):
        told = []
        threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
        with self.assertRaises(KeyboardInterrupt):
            simulate_many(DOUBLE, [1e5], np.ones((100, 4)), progress=told.append)
        self.assertGreater(len(told), 1)
        with self.assertRaises(ZeroDivisionError):
            simulate_many(DOUBLE, [1e5], np.ones((100, 4)), progress=lambda ended: 1 / 0)


class Examples(unittest.TestCase):
    def setUp(self):
        sys.path.insert(0, EXAMPLES)
        self.addCleanup(sys.path.remove, EXAMPLES)

    def test_a_small_deviation_grows_by_the_jacobian(self):
        from lyapunov import growth, random_scene
        for _ in range(10):
            scene = Scene({**random_scene(RANDOM).to_dict(), "integrator": {"tolerance": 1e-12}})
            delta, start = RANDOM.normal(size=4), scene.state
            delta *= 1e-7 / np.linalg.norm(delta)
            ends = simulate_many(scene, [2.0], np.array([start + delta, start - delta])).states[:, 0]
            total, direction = growth(scene, 2.0, delta)
            np.testing.assert_allclose((ends[0] - ends[1]) / 2e-7, np.exp(total) * direction,
                                       atol=1e-3 * np.exp(total), rtol=0)

    def test_no_pendulum_flips_where_its_energy_forbids_it(self):
        from flip_map import flip_times
        angles = np.linspace(-np.pi, np.pi, 41)
        flips = flip_times(angles, 20.0)
        forbidden = 3 * np.cos(angles)[:, None] + np.cos(angles)[None, :] > 2
        self.assertTrue(np.isinf(flips[forbidden]).all())
        self.assertGreater(np.isfinite(flips[~forbidden]).mean(), 0.5)
        mirrored = np.isfinite(flips[::-1, ::-1])  # but for chaos the same
        self.assertGreater((np.isfinite(flips) == mirrored).mean(), 0.9)


if __name__ == "__main__":
    sys.argv.pop(1)
    unittest.main()
