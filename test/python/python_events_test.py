#!/usr/bin/python3
"""Events from Python: the conventions of scipy.integrate.solve_ivp, what is refused, what a function may raise.

    python_events_test.py BIN [unittest options]        BIN has simulate; PYTHONPATH finds planar_chain
"""
import copy
import csv
import os
import subprocess
import sys
import tempfile
import unittest

try:
    import numpy as np
except ImportError:
    print("numpy not found: skipped")
    sys.exit(77)

from planar_chain import Refused, Scene, Simulation, equations, simulate

BIN = sys.argv[1]
ROD = {"mass": 1.0, "inertia": 1 / 12, "com": [0.5, 0.0], "pin": [1.0, 0.0]}
DOUBLE = Scene({"chain": ["upper", "lower"], "links": {"upper": {**ROD, "initial": {"angle": 0.4, "velocity": 0.3}}, "lower": {**ROD, "initial": {"angle": 0.2}}},
                "integrator": {"tolerance": 1e-11}})
BALL = Scene({"chain": ["ball"], "links": {"ball": {"mass": 1, "pin": [0, 0], "joint": {"type": "prismatic", "axis": [0, 1]},
                                                    "initial": {"position": 1}}}})


def event(function, terminal=None, direction=None):
    def its(t, q, qd):
        return function(t, q, qd)
    if terminal is not None:
        its.terminal = terminal
    if direction is not None:
        its.direction = direction
    return its


class Events(unittest.TestCase):
    def test_a_ball_bounces(self):
        ground = event(lambda t, q, qd: q[0], True)
        simulation = Simulation(BALL)
        t, speed = np.sqrt(2 / 9.81), np.sqrt(2 * 9.81)
        for _ in range(10):
            self.assertEqual(simulation.advance_to(100, events=[ground]), 0)
            self.assertAlmostEqual(simulation.time, t, delta=1e-12)
            self.assertEqual(simulation.t_events[0].tolist(), [simulation.time])
            self.assertEqual(simulation.y_events[0].tolist(), [simulation.state.tolist()])
            speed *= 0.8
            t += 2 * speed / 9.81
            simulation.set_state(simulation.q, [speed])
        self.assertIsNone(simulation.advance_to(simulation.time + 1e-3, events=[ground]))
        self.assertIsNone(simulation.advance_to(simulation.time + 1e-3))

    def test_as_scipy_finds_them(self):
        try:
            from scipy.integrate import solve_ivp
        except ImportError:
            self.skipTest("scipy not found")

        def slope(t, y):
            return np.concatenate([y[2:], equations(DOUBLE, y[:2], y[2:])["qdd"]])
        ours = [event(lambda t, q, qd: q[1]), event(lambda t, q, qd: qd[0], direction=-1), event(lambda t, q, qd: q[0] + 2.5, True, 1)]
        theirs = []
        for own in ours:
            def its(t, y, own=own):
                return own(t, y[:2], y[2:])
            its.terminal, its.direction = getattr(own, "terminal", False), getattr(own, "direction", 0)
            theirs.append(its)
        expected = solve_ivp(slope, (0, 4), DOUBLE.state, events=theirs, rtol=1e-11, atol=1e-11)
        times = np.linspace(0, 4, 41)
        run = simulate(DOUBLE, times, events=ours)
        self.assertEqual(run.terminal, 2 if expected.status == 1 else None)
        for found, its, states in zip(run.t_events, expected.t_events, run.y_events):
            self.assertEqual((len(found), states.shape), (len(its), (len(its), 4)))
            np.testing.assert_allclose(found, its, atol=1e-7)
        np.testing.assert_allclose(run.y_events[0], expected.y_events[0], atol=1e-6)
        end = run.t_events[2][-1] if run.terminal == 2 else 4
        self.assertEqual(run.times.tolist(), times[times <= end].tolist())
        np.testing.assert_allclose(run.states, simulate(DOUBLE, run.times), atol=1e-9)

    def test_a_number_ends_at_that_zero_whatever_the_rows(self):
        flips = event(lambda t, q, qd: np.float64(np.sin(3 * t)), terminal=np.int64(3))
        for times in ([9.0], np.linspace(0, 9, 91), [np.pi / 3, 2 * np.pi / 3, 3.2]):
            run = simulate(DOUBLE, times, events=flips)  # a function alone
            np.testing.assert_allclose(run.t_events[0], np.pi / 3 * np.arange(1, 4), atol=1e-14)
            self.assertEqual((run.terminal, run.derivatives), (0, {}))
            self.assertTrue((run.times <= np.pi).all())
        at = event(lambda t, q, qd: t - 0.5, True)
        run = simulate(DOUBLE, [0.25, 0.5, 0.75], events=[at], derivatives=["state"])
        self.assertEqual((run.times.tolist(), run.derivatives["state"].shape), ([0.25, 0.5], (2, 4, 4)))
        self.assertEqual(simulate(DOUBLE, [0.25, 0.5], events=[]).terminal, None)

    def test_each_call_has_arrays_of_its_own(self):
        kept = []
        Simulation(DOUBLE).advance_to(0.1, events=lambda t, q, qd: kept.append((t, q, qd)) or 1.0)
        self.assertGreater(len(kept), 2)
        self.assertGreater(len({q.tobytes() for _, q, _ in kept}), 2)

    def test_what_cannot_be_watched_is_refused(self):
        simulation = Simulation(DOUBLE)
        for events, words in ((3, "events: expected a function of t, q and qd, or a list of them, got 3"),
                              ("q", "events: expected a function of t, q and qd, or a list of them, got 'q'"),
                              ([max, 3], "events/1: expected a function of t, q and qd, got 3"),
                              ([event(max, terminal=-1)], r"events/0.terminal: expected a whole number >= 0, got -1"),
                              ([event(max, terminal="yes")], r"events/0.terminal: expected a whole number >= 0, got 'yes'"),
                              ([event(max, direction="up")], r"events/0.direction: expected a number, got 'up'"),
                              ([lambda t, q, qd: "up"], "events/0: expected a number, got 'up'"),
                              ([lambda t, q, qd: np.nan], "events/0: expected a finite number at t = .* s, got nan")):
            for call in (lambda: simulation.advance_to(simulation.time + 0.1, events=events),
                         lambda: simulate(DOUBLE, [0.1], events=events)):
                self.assertRaisesRegex(Refused, words, call)
        with self.assertRaises(ZeroDivisionError):
            simulation.advance_to(2, events=lambda t, q, qd: 1 / 0)
        with self.assertRaisesRegex(RuntimeError, "another thread advances this simulation"):
            simulation.advance_to(2, events=lambda t, q, qd: simulation.energy_balance().residual)
        twin = copy.deepcopy(simulation)
        simulation.advance_to(2)
        twin.advance_to(2)
        self.assertEqual(simulation.state.tolist(), twin.state.tolist())
        self.assertEqual(twin.t_events, [])


class Tool(unittest.TestCase):
    def simulate(self, *arguments):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "out.csv")
            done = subprocess.run([os.path.join(BIN, "simulate"), "double_pendulum", "--csv", path, *arguments],
                                  stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True)
            with open(path) if os.path.exists(path) else open(os.devnull) as file:
                rows = [[float(x) for x in row] for row in list(csv.reader(file))[1:]]
        return done, rows

    def test_until_ends_at_an_angle(self):
        done, rows = self.simulate("--duration", "9", "--until", " upper_joint= 0.5 ")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertAlmostEqual(rows[-1][1], 0.5, delta=1e-15)
        self.assertGreater(rows[-2][1], 0.5)
        self.assertIn(f"t = {rows[-1][0]:g} s by", done.stdout)
        self.assertEqual(rows[-2][0], (len(rows) - 2) / 100)
        done, rows = self.simulate("--duration", "0.1", "--until", "upper_joint=-40")
        self.assertEqual((done.returncode, rows[-1][0], done.stderr), (0, 0.1, "note: the joint of --until did not pass its angle\n"))

    def test_until_names_what_is_wrong(self):
        form = "--until: expected JOINT = ANGLE, such as 'upper_joint = 1.57' (rad; m of a prismatic joint), got "
        for text, words in (("upper_joint", form), ("upper_joint = x", form), ("= 3", form), ("upper_joint = nan", form),
                            ("upper_joint = 1 2", form),
                            ("uper_joint = 1", '--until: expected a joint of the chain (did you mean upper_joint?), got "uper_joint"')):
            done, _ = self.simulate("--duration", "1", "--until", text)
            self.assertEqual(done.returncode, 2)
            self.assertIn(words, done.stderr)
        done, _ = self.simulate("--duration", "1", "--until", "upper_joint = 1", "--bag", "/dev/null")
        self.assertEqual(done.returncode, 2)


if __name__ == "__main__":
    sys.argv.pop(1)
    unittest.main()
