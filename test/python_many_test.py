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

try:
    import numpy as np
except ImportError:
    print("numpy not found: skipped")
    sys.exit(77)

from planar_chain import Refused, Scene, simulate, simulate_many

EXAMPLES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../src/python/examples")
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

    def test_threads_and_neighbours_do_not_matter(self):
        starts = RANDOM.uniform(-2, 2, (33, 4))
        alone = simulate_many(DOUBLE, [1.0], starts, threads=1).states
        self.assertEqual(simulate_many(DOUBLE, [1.0], starts, threads=3).states.tolist(), alone.tolist())
        self.assertEqual(simulate_many(DOUBLE, [1.0], starts[5:9]).states.tolist(), alone[5:9].tolist())

    def test_a_path_that_leads_nowhere_is_refused_at_once(self):
        with self.assertRaisesRegex(Refused, "links/lowr: expected a link listed in chain"):
            simulate_many(DOUBLE, [1.0], parameters={"links/lowr/mass": [1, 2]})

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
        with self.assertRaisesRegex(ValueError, "initial: expected an array of runs x 4, got 2 x 3"):
            simulate_many(DOUBLE, [1.0], np.zeros((2, 3)))
        reasons = simulate_many(DOUBLE, [1.0], parameters={"links/lower/com/2": [1], "links/lower/mass/x": [1]}).reasons
        self.assertIn("links/lower/com/2: expected a place in the scene", reasons[0])

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
