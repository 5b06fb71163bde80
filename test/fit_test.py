#!/usr/bin/python3
"""fit: made data give back the numbers that made them, with deviations that hold; a recorded run with friction, stops and commands
fits itself back; what the data do not tell; bad input; the scene's text; interruption.

    fit_test.py BIN [unittest options]        BIN: the folder that holds the tools; PYTHONPATH finds planar_chain
"""
import importlib.util
import json
import math
import os
import signal
import subprocess
import sys
import time
import unittest

try:
    import numpy as np
    import scipy  # noqa: F401  pylint: disable=unused-import
    import yaml
except ImportError as missing:
    print(f"{missing}: skipped")
    sys.exit(77)

import fit_statistics
from in_folder import InFolder
from planar_chain import BadFit, Recording, Scene, fit, simulate_many
from planar_chain.fitting.yaml_edit import with_numbers

BIN = ""
LIMIT = 120  # s
RECORDINGS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../config/recordings")
HAS_ROS = all(importlib.util.find_spec(name) for name in ("rosbag", "genpy"))
ROD = {"mass": 1.0, "inertia": 1 / 12, "com": [0.5, 0.0], "pin": [1.0, 0.0]}
PENDULUM = Scene({"chain": ["rod"], "links": {"rod": {**ROD, "joint": {"damping": 0.1}}}})
TIMES = np.arange(0, 2.0001, 0.01)  # s
DOUBLE = fit_statistics.SCENE
MASS, COM, DAMPING = "links/lower/mass", "links/lower/com/0", "links/lower/joint/damping"


def motion(scene, start, times=TIMES):
    """A recording as a dict, without noise."""
    states = simulate_many(scene, times, initial=[start]).states[0]
    n = len(scene)
    return {"t": times, "q": states[:, :n].copy(), "qd": states[:, n:].copy()}


def noisy(recording, seed, noise=1e-3):
    return {**recording, "q": recording["q"] + np.random.default_rng(seed).normal(scale=noise, size=recording["q"].shape)}


def found(result):
    return {number.path: number for number in result.numbers}


class Numbers(unittest.TestCase):
    def test_numbers_that_are_off_by_a_third_are_found_again(self):
        data = [motion(DOUBLE, start) for start in fit_statistics.STARTS]
        first = DOUBLE.with_values({path: 1.3 * value for path, value in fit_statistics.TRUE.items()})
        result = fit(first, data, list(fit_statistics.TRUE))
        self.assertTrue(result.converged, result.reason)
        for path, value in fit_statistics.TRUE.items():
            self.assertAlmostEqual(found(result)[path].value / value, 1, delta=1e-6, msg=path)
        self.assertEqual((result.not_told, result.warnings), ([], []))
        self.assertLess(max(error.max() for _, error in result.errors), 1e-7)  # the tolerance of the runs, grown

    def test_deviations_hold(self):
        # Of 120 ratios 95.4 % should be within 2; less than 88 % or a spread off by a fifth has a chance below 1e-3.
        ratios = fit_statistics.ratios(30, 4)
        self.assertGreater(np.mean(abs(ratios) < 2), 0.88)
        self.assertAlmostEqual(ratios.std(), 1, delta=0.2)

    def test_outliers_hardly_count(self):
        data = noisy(motion(PENDULUM, [0.0, 0.0]), 1)
        data["q"][20::40] += 0.5  # rad: a bad contact
        result = fit(PENDULUM, data, ["links/rod/com/0=0.4"])
        one = found(result)["links/rod/com/0"]
        self.assertLess(abs(one.value - 0.5), 4 * one.deviation)
        self.assertLess(one.deviation, 1e-3)
        self.assertAlmostEqual(result.noise[0], 1e-3, delta=2e-4)

    def test_gaps_jitter_and_missing_rates(self):
        random = np.random.default_rng(3)
        times = TIMES + np.concatenate([[0], random.uniform(-0.004, 0.004, len(TIMES) - 1)])
        data = motion(DOUBLE, fit_statistics.STARTS[0], times)
        data["q"][50:80, 1] = np.nan
        data["q"][::7, 0] = np.nan
        del data["qd"]
        result = fit(DOUBLE, data, {COM: 0.4, DAMPING: 0.0})
        self.assertAlmostEqual(found(result)[COM].value, 0.5, delta=1e-6)
        self.assertAlmostEqual(found(result)[DAMPING].value, 0.02, delta=1e-6)

    def test_offsets_of_encoders_and_a_delay_of_torques(self):
        torque = np.where((TIMES * 2) % 1 < 0.5, 2.0, -1.0)
        late = Scene({**PENDULUM.to_dict(), "loads": {"motor": {"joint": "rod_joint", "torque": 1, "times": (TIMES + 0.013).tolist(),
                                                               "values": torque.tolist()}}})
        data = {**motion(late, [-1.0, 0.0]), "tau": torque[:, None]}
        data["q"] += 0.02
        result = fit(PENDULUM, data, {"links/rod/com/0": 0.45, "links/rod/joint/damping": 0.05}, offsets=True, delay=True)
        self.assertAlmostEqual(result.delays[0], 0.013, delta=1e-4)
        self.assertAlmostEqual(result.offsets[0][0], 0.02, delta=1e-4)
        self.assertAlmostEqual(found(result)["links/rod/com/0"].value, 0.5, delta=1e-4)
        hint = fit(PENDULUM, data, {"links/rod/com/0": 0.45}, offsets=True).warnings
        self.assertTrue(any("delay" in line and "--delay" in line for line in hint), hint)

    def test_correlated_residuals_widen_the_deviations(self):
        drag = Scene({**PENDULUM.to_dict(), "links": {"rod": {**ROD, "joint": {"damping": 0.1, "friction": 0.2}}}})
        result = fit(PENDULUM, noisy(motion(drag, [-0.5, 0.0]), 2, 1e-4), ["links/rod/com/0"])
        self.assertGreater(result.correlation_time, 5)
        self.assertEqual(fit(PENDULUM, noisy(motion(PENDULUM, [-0.5, 0.0]), 2), ["links/rod/com/0"]).correlation_time, 1)

    def test_predictions_of_what_was_not_seen(self):
        result = fit(DOUBLE, noisy(motion(DOUBLE, fit_statistics.STARTS[0]), 1), [COM], predict=[noisy(motion(DOUBLE, fit_statistics.STARTS[1]), 2)])
        self.assertAlmostEqual(result.predictions[0].from_fitted_start.mean(), 1e-3, delta=1e-4)
        self.assertLess(result.predictions[0].from_first_window.max(), 0.01)

    def test_driven_joints_keep_their_laws(self):
        scene = {**DOUBLE.to_dict(), "links": {"upper": {**ROD, "joint": {"drive": {"amplitude": 0.5, "frequency": 0.7, "phase": 0.3}}},
                                               "lower": {**ROD, "joint": {"damping": 0.02}}}}
        states = simulate_many(Scene(scene), TIMES, parameters={COM: [0.5]}).states[0]
        whole = Recording("run", TIMES, states[:, :2], states[:, 2:])
        result = fit(Scene(scene), [whole.part(0, 90), whole.part(90, 201)], {COM: 0.4, DAMPING: 0.03})
        self.assertAlmostEqual(found(result)[COM].value, 0.5, delta=1e-6)
        self.assertAlmostEqual(found(result)[DAMPING].value, 0.02, delta=1e-6)


class Words(unittest.TestCase):
    def test_only_a_product_is_seen(self):
        result = fit(PENDULUM, noisy(motion(PENDULUM, [-0.5, 0.0]), 5), ["links/rod/mass", "links/rod/com/0", "links/rod/inertia"])
        self.assertIn("1 combination of them", result.not_told[0])
        self.assertEqual(result.not_told[1], "only mass·com of rod; inertia + mass·com² of rod (about its inner pin) are seen")

    def test_a_number_that_is_not_seen(self):
        result = fit(DOUBLE, noisy(motion(DOUBLE, fit_statistics.STARTS[0]), 5), ["links/lower/pin/0", COM])  # the tip carries nothing
        self.assertEqual(result.not_told, ["links/lower/pin/0 is not seen"])
        self.assertEqual(found(result)["links/lower/pin/0"].value, 1.0)

    def test_the_scale_of_all_masses_is_not_seen(self):
        result = fit(PENDULUM, noisy(motion(PENDULUM, [-0.5, 0.0]), 5),
                     ["links/rod/mass", "links/rod/inertia", "links/rod/joint/damping"])
        self.assertIn("(inertia + mass·com²)/(mass·com) of rod", " ".join(result.not_told))
        self.assertRegex(" ".join(result.not_told), r"open: links/rod/mass \+100 %, links/rod/inertia \+100 %, links/rod/joint/damping \+100 %")

    def test_what_the_model_lacks(self):
        for key, words in (("friction", "sign q̇"), ("damping", "go with q̇ of")):
            joint = {"damping": 0.0, key: 0.3}
            lacking = Scene({"chain": ["rod"], "links": {"rod": {**ROD, "joint": joint}}})
            result = fit(lacking.with_values({f"links/rod/joint/{key}": 0.0}), noisy(motion(lacking, [0.5, 0.0]), 6), ["links/rod/com/0"])
            self.assertTrue(any(words in line and f"--vary links/rod/joint/{key}" in line for line in result.warnings), (key, result.warnings))
        times = np.arange(0, 6, 0.02)
        plain = Scene({"chain": ["rod"], "links": {"rod": ROD}})
        state, states = [0.5, 0.0], []
        for _ in times:  # q̇ |q̇| as a torque that is held for one step
            states.append(state)
            load = {"drag": {"joint": "rod_joint", "torque": -0.05 * state[1] * abs(state[1])}}
            state = simulate_many(Scene({**plain.to_dict(), "loads": load}), [0.02], initial=[state]).states[0, 0].tolist()
        result = fit(plain, noisy({"t": times, "q": np.array(states)[:, :1]}, 7), ["links/rod/com/0"])
        self.assertTrue(any("q̇ |q̇|" in line and "drag" in line for line in result.warnings), result.warnings)

    def test_bounds_are_named(self):
        result = fit(PENDULUM, noisy(motion(PENDULUM, [-0.5, 0.0]), 5), ["links/rod/com/0=0.4:0.3:0.45"])
        self.assertIn("links/rod/com/0 ran to its bound 0.45", result.warnings)


class Bad(unittest.TestCase):
    def refused(self, words, *arguments, **named):
        with self.assertRaises(ValueError) as caught:
            fit(*arguments, **named)
        for word in (words,) if isinstance(words, str) else words:
            self.assertIn(word, str(caught.exception))

    def setUp(self):
        self.good = motion(PENDULUM, [-0.5, 0.0])

    def changed(self, **others):
        return {**self.good, **others}

    def test_recordings(self):
        q, t = self.good["q"], self.good["t"]
        com = ["links/rod/com/0"]
        short = {key: value[:20] for key, value in self.good.items()}
        self.refused(["at least 0.3 s, the first window", "got 0.19 s"], PENDULUM, short, com)
        self.refused(["motion of the joint rod_joint", "never moves"], PENDULUM, self.changed(q=np.full_like(q, -1.5)), com)
        self.refused(["looks like degrees", "rad"], PENDULUM, self.changed(q=np.degrees(q)), com)
        self.refused("a finite angle of rod_joint", PENDULUM, self.changed(q=np.where(t[:, None] == t[5], np.inf, q)), com)
        self.refused("got none", PENDULUM, self.changed(q=np.full_like(q, np.nan)), com)
        self.refused("sample 5: expected a finite time", PENDULUM, self.changed(t=np.where(t == t[5], np.nan, t)), com)
        self.refused(["sample 7: expected a time after", "repeated"], PENDULUM, self.changed(t=np.where(t == t[7], t[6], t)), com)
        self.refused(["sample 7", "unsorted"], PENDULUM, self.changed(t=np.where(t == t[7], t[4], t)), com)
        self.refused("201 x 1 numbers, got 201 x 2", PENDULUM, self.changed(q=np.hstack([q, q])), com)
        self.refused("expected a path, a Recording or a dict", PENDULUM, {"t": t}, com)
        self.refused("at least one recording", PENDULUM, [], com)
        self.assertTrue(fit(PENDULUM, self.changed(q=q + 20 * math.pi), com, many_turns=True).converged)

    def test_numbers(self):
        same = "the same number"
        self.refused(same, PENDULUM, self.good, ["links/rod/mass", "links/rod/mass=2"])
        self.refused(same, PENDULUM, self.good, ["links/rod/com/0", "links/rod/mass", "links/rod/com/0=0.4"])
        self.refused('a link listed in chain, got "rood"', PENDULUM, self.good, ["links/rood/mass=1"])
        self.refused("expected a first value for links/rod/joint/friction", PENDULUM, self.good, ["links/rod/joint/friction"])
        self.refused("LOW <= FIRST <= HIGH", PENDULUM, self.good, ["links/rod/mass=1:2:3"])
        self.refused("PATH=FIRST:LOW:HIGH", PENDULUM, self.good, ["links/rod/mass=1:2"])
        self.refused("the initial state of each recording is always fitted", PENDULUM, self.good, ["links/rod/initial/angle"])
        self.refused("at least one number", PENDULUM, self.good, [])
        self.refused("--windows: expected increasing times", PENDULUM, self.good, ["links/rod/mass"], windows=[2, 1])

    def test_a_scene_that_cannot_run(self):
        self.refused(["expected a scene that moves from the first values", "links/rod/inertia"], PENDULUM, self.good,
                     ["links/rod/inertia=-1:-2:1"])


class Text(unittest.TestCase):
    TEXT = """# mine
chain: [a, b]          # two
links:
  a: &rod {mass: 1, inertia: 1e-1, com: [0.5, 0], pin: [1, 0]}   # a rod
  b:
    <<: *rod
    joint:
      damping: 0.1     # guessed

      # the end
gravity: [0, -9.81]
"""

    def test_only_the_numbers_change(self):
        text = with_numbers(self.TEXT, {"links/a/com/0": 0.25, "links/b/joint/damping": 1e-7, "gravity/1": -9.8})
        lines = text.split("\n")
        gone = [line for line in self.TEXT.split("\n") if line not in lines]
        self.assertEqual([line.strip()[:7] for line in gone], ["a: &rod", "damping", "gravity"])
        self.assertEqual(len(lines), len(self.TEXT.split("\n")) + 1)  # what b had by its merge
        values = yaml.safe_load(text)
        self.assertEqual((values["links"]["a"]["com"], values["links"]["b"]["com"], values["gravity"][1]), ([0.25, 0], [0.5, 0], -9.8))
        for line in ("# mine", "# two", "   # a rod", "     # guessed", "      # the end"):
            self.assertIn(line, text)

    def test_what_is_missing_is_added_and_aliases_keep_their_values(self):
        text = with_numbers("chain: [a, b]\nlinks:\n  a: &rod {mass: 1, com: [1, 0]}\n  b: *rod  # same\n",
                            {"links/b/mass": 2, "links/a/joint/friction": 0.5, "links/b/com/1": 0.25})
        self.assertEqual(yaml.safe_load(text)["links"], {"a": {"mass": 1, "com": [1, 0], "joint": {"friction": 0.5}},
                                                         "b": {"mass": 2.0, "com": [1, 0.25], "joint": {"friction": 0}}})
        self.assertIn("  # same", text)


class Tool(InFolder):
    def run_tool(self, *arguments):
        return subprocess.run([os.path.join(BIN, "fit"), *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              universal_newlines=True, timeout=LIMIT)

    def recording(self, name):
        return os.path.join(RECORDINGS, name)

    def write(self, name, text):
        with open(self.path(name), "w", encoding="utf-8") as file:
            file.write(text)
        return self.path(name)

    def test_the_single_pendulum_that_ships(self):
        fitted = self.path("fitted.yaml")
        result = self.run_tool(self.recording("single.yaml"), "--data", *(self.recording(f"single_{k}.csv") for k in range(3)), "--vary",
                               "links/arm/inertia", "links/arm/joint/damping", "--predict", self.recording("single_3.csv"),
                               self.recording("single_4.csv"), "--output", fitted, "--plot", self.path("fit.png"), "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        said = json.loads(result.stdout)
        self.assertLess(max(one["error"]["arm_joint"] for one in said["data"]), 0.03)
        self.assertLess(max(one["from_fitted_start"]["arm_joint"] for one in said["predictions"]), 0.03)
        self.assertGreater(os.path.getsize(self.path("fit.png")), 10000)
        self.assertEqual(Scene.from_file(fitted).to_dict()["links"]["arm"]["joint"]["damping"],
                         float(f"{said['numbers'][1]['value']:.10g}"))
        with open(fitted, encoding="utf-8") as after, open(self.recording("single.yaml"), encoding="utf-8") as before:
            changed = [k for k, (one, other) in enumerate(zip(after, before)) if one != other]
        self.assertEqual(len(changed), 2)

    def test_the_double_pendulum_that_ships_is_predicted(self):
        data = [self.recording(f"double_{k}.csv") for k in range(3)]
        numbers = ["links/upper/" + key for key in ("inertia", "com/0", "pin/0", "joint/damping")]
        numbers += ["links/lower/" + key for key in ("mass", "inertia", "com/0", "joint/damping")]
        said = json.loads(self.run_tool(self.recording("double.yaml"), "--data", *data[:2], "--vary", *numbers, "--predict", data[2],
                                        "--json").stdout)
        self.assertTrue(said["converged"])
        self.assertLess(max(said["predictions"][0]["from_fitted_start"].values()), 0.012)
        self.assertLess(max(max(one["error"].values()) for one in said["data"]), 0.01)
        self.assertRegex(said["not_told"][0], "[23] combinations")  # two exactly; a damper, hardly seen, is the third

    CSV = "t,q_arm_joint\n" + "".join(f"{k / 100},{math.sin(k / 10)}\n" for k in range(100))

    def test_bad_csvs_name_the_line(self):
        for text, words in ((self.CSV.replace("0.05,", "0.04,"), "line 7: expected a time after 0.04 s, got 0.04 s, a repeated stamp"),
                            (self.CSV.replace("0.05,", "0.01,"), "line 7: expected a time after 0.04 s, got 0.01 s, an unsorted stamp"),
                            (self.CSV.replace("0.05,", "0.05,nan#").replace(next(
                                row for row in self.CSV.split("\n") if row.startswith("0.05,"))[5:], "", 1).replace("nan#", "nan"),
                             "line 7: expected a finite number of q_arm_joint, or an empty field for a gap, got 'nan'"),
                            (self.CSV.replace("q_arm_joint", "q_arn_joint"), "got 'q_arn_joint'"),
                            (self.CSV.replace("0.05,", "0.05,1,"), "line 7: expected 2 fields, got 3"),
                            ("", "expected the columns t, q_arm_joint, got none"),
                            ("t,q_arm_joint\n0,1\n", "expected at least 10 samples, got 1")):
            result = self.run_tool(self.recording("single.yaml"), "--data", self.write("bad.csv", text), "--vary", "links/arm/inertia")
            self.assertEqual(result.returncode, 2, result.stdout)
            self.assertIn(words, result.stderr)
        for arguments, words in ((("--data", self.path("none.csv")), "No such file"),
                                 (("--data", self.recording("single_0.csv"), "--plot", "x.txt"), "--plot: expected a name"),
                                 (("--data", self.recording("single_0.csv"), "--windows", "x"), "--windows")):
            result = self.run_tool(self.recording("single.yaml"), "--vary", "links/arm/inertia", *arguments)
            self.assertEqual(result.returncode, 2)
            self.assertIn(words, result.stderr)

    def test_a_fit_that_does_not_converge_keeps_the_best(self):
        # Noise alone: the pendulum does not explain it, and the last window ends at its number of evaluations.
        from planar_chain.fitting import solve  # pylint: disable=import-outside-toplevel
        most, solve.LAST_CALLS = solve.LAST_CALLS, 2
        self.addCleanup(setattr, solve, "LAST_CALLS", most)
        result = fit(PENDULUM.with_values({"links/rod/com/0": 0.3}), noisy(motion(PENDULUM, [-0.5, 0.0]), 8), ["links/rod/com/0"])
        self.assertFalse(result.converged)
        self.assertIn("2 evaluations were not enough", result.reason)
        self.assertAlmostEqual(found(result)["links/rod/com/0"].value, 0.5, delta=0.01)

    def test_an_interruption_keeps_the_best(self):
        data = [self.recording(f"double_{k}.csv") for k in range(3)]
        command = [os.path.join(BIN, "fit"), self.recording("double.yaml"), "--data", *data, "--vary", "links/upper/inertia",
                   "links/lower/inertia", "links/lower/com/0", "links/upper/joint/friction=0.0001", "--output", self.path("fitted.yaml")]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True) as run:
            time.sleep(3)
            run.send_signal(signal.SIGINT)
            said, error = run.communicate(timeout=LIMIT)
        self.assertEqual(run.returncode, 130, error)
        self.assertIn("interrupted", error)
        if "best so far" in error:  # else it was loading its modules
            self.assertIn("links/lower/inertia", said)
            self.assertTrue(os.path.exists(self.path("fitted.yaml")))


@unittest.skipUnless(HAS_ROS, "no ROS")
class Bags(InFolder):
    ARM = Scene({
        "chain": ["upper", "lower"],
        "links": {"upper": {"mass": 1.2, "inertia": 0.08, "com": [0.45, 0.02], "pin": [0.9, 0], "initial": {"angle": -0.6},
                            "joint": {"damping": 0.05, "friction": 0.2, "effort_limit": 4.0}},
                  "lower": {"mass": 0.7, "inertia": 0.03, "com": [0.3, 0], "pin": [0.6, 0], "initial": {"angle": 0.9},
                            "joint": {"damping": 0.02, "friction": 0.08, "lower": -1.2, "upper": 1.2, "stop_stiffness": 60.0,
                                      "stop_damping": 0.3}}},
        "publish": {"rate": 100}})
    TRUE = {MASS: 0.7, COM: 0.3, "links/upper/joint/damping": 0.05, "links/upper/joint/friction": 0.2, "links/lower/joint/friction": 0.08,
            "links/lower/joint/stop_stiffness": 60.0}

    def commands(self):
        """A controller, cut off by the effort limit at times; a kick, a timed torque; a state that is set, and a reset."""
        from geometry_msgs.msg import Point, Vector3  # pylint: disable=import-outside-toplevel
        from planar_chain.msg import CommandTaken, JointTorque, LinkForce  # pylint: disable=import-outside-toplevel
        taken = []

        def add(tick, at=None, **fields):
            taken.append(CommandTaken(number=len(taken) + 1, tick=tick, scene_time=(tick - 1) / 100 if at is None else at, **fields))

        for tick in range(5, 150, 5):
            t = (tick - 1) / 100
            add(tick, joint_torques=[5 * math.sin(3 * t), math.cos(5 * t)])
            if tick == 50:
                add(tick, kind=CommandTaken.JOINT_TORQUE, joint_torque=[JointTorque(joint="lower_joint", torque=2.0, duration=0.137)])
            if tick == 90:
                add(tick, kind=CommandTaken.LINK_FORCE, link_force=[LinkForce(
                    link="lower", point=Point(0.3, 0.1, 0), force=Vector3(3, 1, 0), moment=0.2, duration=0.25)])
        add(151, kind=CommandTaken.SET_STATE, q=[-1.0, 0.8], qd=[2.0, 1.0])
        add(170, kind=CommandTaken.CLEAR_COMMANDS)
        add(250, kind=CommandTaken.RESET)
        add(262, at=0.11, joint_torques=[1.0, 0.5])
        return taken

    def record(self):
        import genpy  # pylint: disable=import-outside-toplevel
        import rosbag  # pylint: disable=import-outside-toplevel
        with rosbag.Bag(self.path("commands.bag"), "w") as bag:
            for k, command in enumerate(self.commands()):
                bag.write("/planar_chain/commands_taken", command, genpy.Time(1, k))
        with open(self.path("arm.yaml"), "w", encoding="utf-8") as file:
            yaml.safe_dump(self.ARM.to_dict(), file)
        result = subprocess.run([os.path.join(BIN, "simulate"), self.path("arm.yaml"), "--duration", "4", "--commands",
                                 self.path("commands.bag"), "--bag", self.path("run.bag")], stdout=subprocess.PIPE,
                                stderr=subprocess.STDOUT, universal_newlines=True, timeout=LIMIT)
        self.assertEqual(result.returncode, 0, result.stdout)
        return self.path("run.bag")

    def test_a_recorded_run_fits_itself_back(self):
        first = self.ARM.with_values({path: (1.3 if k % 2 else 0.7) * value for k, (path, value) in enumerate(self.TRUE.items())})
        result = fit(first, self.record(), list(self.TRUE))
        self.assertTrue(result.converged, result.reason)
        self.assertEqual([name for name, _ in result.errors], ["run.bag, piece 1", "run.bag, piece 2", "run.bag, piece 3"])
        for path, value in self.TRUE.items():
            self.assertAlmostEqual(found(result)[path].value / value, 1, delta=1e-4, msg=path)

    def test_bags_without_what_is_needed(self):
        import genpy  # pylint: disable=import-outside-toplevel
        import rosbag  # pylint: disable=import-outside-toplevel
        from sensor_msgs.msg import JointState  # pylint: disable=import-outside-toplevel

        def bag(name, messages):
            with rosbag.Bag(self.path(name), "w") as file:
                for k, fields in enumerate(messages):
                    message = JointState(**fields)
                    message.header.stamp = genpy.Time(1, 10 ** 7 * k)
                    file.write("/joint_states", message, message.header.stamp)
            return self.path(name)
        good = [{"name": ["gripper", "rod_joint"], "position": [0.1, math.sin(k / 10)]} for k in range(60)]
        self.assertTrue(fit(PENDULUM, bag("good.bag", good), ["links/rod/com/0"]).recordings[0].q[1, 0] == math.sin(0.1))
        for messages, words in (([{**one, "name": ["gripper", "elbow"]} for one in good],
                                 "expected the joints rod_joint on /joint_states, got gripper, elbow"),
                                (good[:30] + [{**good[30], "position": [0, math.nan]}] + good[31:],
                                 "message 31 of /joint_states: expected a finite position of rod_joint, got nan"),
                                ([{"name": ["rod_joint"], "velocity": [1.0]}] * 20, "expected positions on /joint_states, got none"),
                                ([], "expected joint_states of one node")):
            with self.assertRaises(BadFit) as caught:
                fit(PENDULUM, bag("bad.bag", messages), ["links/rod/com/0"])
            self.assertIn(words, str(caught.exception))
        with open(self.path("no.bag"), "wb") as file:
            file.write(b"#ROSBAG V2.0\n")
        with self.assertRaisesRegex(BadFit, "a bag that can be read"):
            fit(PENDULUM, self.path("no.bag"), ["links/rod/com/0"])
        with self.assertRaisesRegex(BadFit, "expected an effort"):
            fit(PENDULUM, self.path("good.bag"), ["links/rod/com/0"], effort=True)


if __name__ == "__main__":
    BIN = sys.argv.pop(1)
    unittest.main(verbosity=2)
