#!/usr/bin/python3
"""fit, the tool: the recordings that ship, bad CSVs, exit statuses, interruption; bags: a recorded run with friction, stops and commands
fits itself back.

    fit_tool_test.py BIN [unittest options]        BIN: the folder that holds the tools; PYTHONPATH finds planar_chain
"""
import importlib.util
import json
import math
import os
import pty
import signal
import subprocess
import sys
import unittest

from fit_test import COM, MASS, PENDULUM, found  # skips without scipy  # pylint: disable=wrong-import-order
import numpy as np
import yaml

from planar_chain import BadFit, Scene, fit, simulate
from planar_chain.fitting.recordings import read_csv
from planar_chain.fitting.solve import first_state

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../support"))
from in_folder import InFolder  # noqa: E402

BIN = ""
LIMIT = 120  # s
RECORDINGS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../config/recordings")
HAS_ROS = all(importlib.util.find_spec(name) for name in ("rosbag", "genpy"))


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

    def test_a_prediction_of_data_is_noted(self):
        one, other, same = self.recording("single_0.csv"), self.recording("single_1.csv"), self.path("same.csv")
        os.symlink(one, same)
        result = self.run_tool(self.recording("single.yaml"), "--data", one, "--vary", "links/arm/inertia", "--predict", same, other)
        self.assertIn(f"note: the fit uses {same} of --predict too\n", result.stderr)
        self.assertNotIn(other, result.stderr)

    def test_the_single_pendulum_that_ships(self):
        fitted = self.path("fitted.yaml")
        result = self.run_tool(self.recording("single.yaml"), "--data", *(self.recording(f"single_{k}.csv") for k in range(3)), "--vary",
                               "links/arm/inertia", "links/arm/joint/damping", "--predict", self.recording("single_3.csv"),
                               self.recording("single_4.csv"), "--output", fitted, "--plot", self.path("fit.png"), "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        said = json.loads(result.stdout)
        self.assertEqual(said["units"], {"arm_joint": "rad"})
        self.assertLess(max(one["error"]["arm_joint"] for one in said["data"]), 0.03)
        self.assertLess(max(one["from_fitted_start"]["arm_joint"] for one in said["predictions"]), 0.03)
        self.assertGreater(os.path.getsize(self.path("fit.png")), 10000)
        self.assertEqual(Scene.from_file(fitted).to_dict()["links"]["arm"]["joint"]["damping"],
                         float(f"{said['numbers'][1]['value']:.10g}"))
        with open(fitted, encoding="utf-8") as after, open(self.recording("single.yaml"), encoding="utf-8") as before:
            changed = [k for k, (one, other) in enumerate(zip(after, before)) if one != other]
        self.assertEqual(len(changed), 2)

    def test_a_hint_leads_to_the_single_pendulum_in_every_recording(self):
        data = [self.recording(f"single_{k}.csv") for k in range(5)]
        command = [self.recording("single.yaml"), "--data", *data, "--predict", *data, "--json", "--vary", "links/arm/inertia"]
        damped = json.loads(self.run_tool(*command, "links/arm/joint/damping").stdout)
        self.assertRegex(damped["warnings"][0], r"sign q̇ and q̇ \|q̇\| of arm_joint, together")
        advice = damped["warnings"][0].rpartition("--vary ")[2].split()
        better = json.loads(self.run_tool(*command, *advice).stdout)
        self.assertEqual(better["warnings"], [])
        self.assertLess(max(one["from_first_sample"]["arm_joint"] for one in better["predictions"]), 0.03)  # 0.020; with damping 0.032

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

    def test_rates_of_some_joints(self):
        rows = [f"{k / 100},{math.sin(k / 100)},{math.cos(k / 100)},{1 + 100 * (k == 0)}" for k in range(100)]
        data = self.write("some.csv", "\n".join(["t,q_upper_joint,q_lower_joint,qd_lower_joint", *rows]))
        recording = read_csv(data, ["upper_joint", "lower_joint"])
        self.assertEqual(recording.qd[0, 1], 101)
        self.assertAlmostEqual(first_state(recording)[2], 1, delta=0.01)  # by the angles
        self.assertEqual(first_state(recording)[3], 101)  # as measured

    def test_bad_csvs_name_the_line(self):
        for text, words in ((self.CSV.replace("0.05,", "0.04,"), "line 7: expected a time after 0.04 s, got 0.04 s, a repeated stamp"),
                            (self.CSV.replace("0.05,", "0.01,"), "line 7: expected a time after 0.04 s, got 0.01 s, an unsorted stamp"),
                            (self.CSV.replace("0.05,", "0.05,nan#").replace(next(
                                row for row in self.CSV.split("\n") if row.startswith("0.05,"))[5:], "", 1).replace("nan#", "nan"),
                             "line 7: expected a finite number of q_arm_joint, or an empty field for a gap, got 'nan'"),
                            (self.CSV.replace("q_arm_joint", "q_arn_joint"), "got 'q_arn_joint'"),
                            (self.CSV.replace("0.05,", "0.05,1,"), "line 7: expected 2 fields, got 3"),
                            (self.CSV + "1,1_0\n", "line 102: expected a finite number of q_arm_joint, or an empty field for a gap, got '1_0'"),
                            ("t,q_arm_joint\n" + "".join(f"{k},\n" for k in range(20)), "bad.csv: expected angles of the joint arm_joint, got none"),
                            (self.CSV + "1e7,0\n", "bad.csv: expected samples at most 1000 s apart, got 1e+07 s before t = 1e+07 s (a wrong stamp?)"),
                            ("", "expected the columns t, q_arm_joint, got none"),
                            ("t,q_arm_joint\n0,1\n", "expected at least 10 samples, got 1")):
            result = self.run_tool(self.recording("single.yaml"), "--data", self.write("bad.csv", text), "--vary", "links/arm/inertia")
            self.assertEqual(result.returncode, 2, result.stdout + result.stderr)
            self.assertIn(words, result.stderr)
        for arguments, words in ((("--data", self.path("none.csv")), "none.csv: No such file"),
                                 (("--data", self.recording("single_0.csv"), "--plot", "x.txt"), "--plot: expected a name"),
                                 (("--data", self.recording("single_0.csv"), "--output", "-"), "--output: expected a file, as standard output has"),
                                 (("--data", self.recording("single_0.csv"), "--vary", "links/arm/mass=0,5"), "0,5' (a decimal point, not a comma?)"),
                                 (("--data", self.recording("single_0.csv"), "--windows", "x"), "--windows"),
                                 (("--data", self.recording("single_0.csv"), "--windows", "0.3,1_0"), "--windows"),
                                 (("--data", self.recording("single_0.csv"), "--pieces", "1_0"), "invalid float value: '1_0'"),
                                 (("--data", self.recording("single_0.csv"), "--node", ""), "--node: expected a bag beside it, got none"),
                                 (("--data", self.recording("single_0.csv"), "--effort"), "--effort: expected a bag beside it, got none"),
                                 (("--data", *[self.recording("single_0.csv")] * 2), "single_0.csv 2 times")):
            result = self.run_tool(self.recording("single.yaml"), "--vary", "links/arm/inertia", *arguments)
            self.assertEqual(result.returncode, 2)
            self.assertIn(words, result.stderr)
        with open(self.recording("single.yaml"), "rb") as file:
            text = file.read()
        for other in (text.replace(b": ", b":\t"), b"# gr\xf6\xdfe\n" + text):  # which yaml-cpp reads
            with open(self.path("other.yaml"), "wb") as file:
                file.write(other)
            result = self.run_tool(self.path("other.yaml"), "--data", self.recording("single_0.csv"), "--vary", "links/arm/inertia", "--output",
                                   self.path("fitted.yaml"))
            self.assertEqual(result.returncode, 2, result.stderr)
            self.assertRegex(result.stderr, "^fit: .*other.yaml: expected YAML in UTF-8 that PyYAML reads too .*, got .*\n$")
        own = self.write("own.csv", self.CSV)
        with open(self.recording("single.yaml"), encoding="utf-8") as file:
            scene = self.write("own.yaml", file.read())
        for outputs in (("--output", own), ("--output", scene), ("--output", self.path("x.svg"), "--plot", self.path("./x.svg")),
                        ("--plot", self.path("x.svg"))):
            if len(outputs) == 2 and "--plot" in outputs:
                os.symlink(own, self.path("x.svg"))
            result = self.run_tool(scene, "--data", own, "--vary", "links/arm/inertia", *outputs)
            self.assertEqual(result.returncode, 2)
            self.assertIn(f"fit: {outputs[-2]}: expected a file that is not another of the run's, got {outputs[-1]}", result.stderr)

    def test_a_recording_that_may_be_cut_is_said(self):
        data = self.write("cut.csv", self.CSV[:-1])
        for arguments in ((), ("--predict", self.write("whole.csv", self.CSV))):
            warnings = json.loads(self.run_tool(self.recording("single.yaml"), "--data", data, "--vary", "links/arm/inertia", "--json",
                                                *arguments).stdout)["warnings"]
            self.assertEqual(warnings[-1], f"{data}: the last line has no end: its last number may be cut off")

    def test_a_urdf_is_written_out_as_links(self):
        rod = Scene.from_file(self.robot())
        data = {"t": 0.02 * np.arange(100)}
        data["q_pin"] = simulate(rod.with_values({"links/rod/initial/angle": 0.5}), data["t"])[:, 0]
        csv = self.write("swing.csv", "\n".join([",".join(data), *(f"{t},{q}" for t, q in zip(*data.values()))]))
        with self.assertRaisesRegex(ValueError, r"inertia: expected .* \(the tools sweep and fit write a URDF out as links"):
            rod.with_values({"links/rod/inertia": 0.2})
        vary = [self.path("robot.urdf"), "--data", csv, "--vary", "links/rod/inertia=0.2", "--output"]
        self.assertIn("--output: expected the name of a YAML scene", self.run_tool(*vary, self.path("fitted.urdf")).stderr)
        result = self.run_tool(*vary, self.path("fitted.yaml"))
        self.assertEqual(result.returncode, 0, result.stderr)
        fitted = Scene.from_file(self.path("fitted.yaml"))
        self.assertEqual(fitted.joints, ["pin"])
        self.assertAlmostEqual(fitted.to_dict()["links"]["rod"]["inertia"], 0.25, delta=1e-6)

    def test_a_fit_that_does_not_converge_keeps_the_best(self):
        # Two evaluations are allowed in the last window, which does not suffice.
        short = ("import os, runpy, sys; from planar_chain.fitting import solve; solve.LAST_CALLS = 2; sys.argv.pop(0); "
                 "sys.path[0] = os.path.dirname(os.path.realpath(sys.argv[0])); runpy.run_path(sys.argv[0], run_name='__main__')")
        run = subprocess.run([sys.executable, "-c", short, os.path.join(BIN, "fit"), self.recording("single.yaml"), "--data",
                              self.recording("single_0.csv"), "--vary", "links/arm/inertia", "links/arm/joint/damping", "--output",
                              self.path("fitted.yaml")], stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True,
                             timeout=LIMIT)
        self.assertEqual(run.returncode, 1, run.stderr)
        self.assertIn("fit: the fit did not converge: 2 evaluations were not enough; this is the best so far", run.stderr)
        self.assertIn("links/arm/joint/damping", run.stdout)
        best = Scene.from_file(self.path("fitted.yaml")).to_dict()["links"]["arm"]
        self.assertAlmostEqual(best["inertia"], 4.5e-4, delta=5e-5)

    def test_a_bad_fit_is_said_first(self):
        with open(self.recording("single_0.csv"), encoding="utf-8") as file:
            header, *rows = file.read().split()
        upside_down = [f"{float(row.split(',')[0])},{float(row.split(',')[1]) + math.pi}" for row in rows]
        data = self.write("turned.csv", "\n".join([",".join(header.split(",")[:2]), *upside_down]))
        result = self.run_tool(self.recording("single.yaml"), "--data", data, "--vary", "links/arm/inertia", "--output",
                               self.path("fitted.yaml"))
        self.assertEqual(result.returncode, 1, result.stdout)
        self.assertIn("that of arm_joint from −x (change all signs, or subtract π)", result.stdout)
        self.assertRegex(result.stdout, r"turned.csv +[\d.]+ s ")
        self.assertRegex(result.stdout.split("\n")[0], "^The fit is bad: .*the numbers are wrong")
        with open(self.path("fitted.yaml"), encoding="utf-8") as file:
            self.assertTrue(file.readline().startswith("# The fit is bad: "))
        Scene.from_file(self.path("fitted.yaml"))

    def test_an_interruption_keeps_the_best(self):
        data = [self.recording(f"double_{k}.csv") for k in range(3)]
        command = [os.path.join(BIN, "fit"), self.recording("double.yaml"), "--data", *data, "--vary", "links/upper/inertia",
                   "links/lower/inertia", "links/lower/com/0", "links/upper/joint/friction=0.0001", "--output", self.path("fitted.yaml")]
        mine, terminal = pty.openpty()  # progress is printed on a terminal only
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=terminal, universal_newlines=True) as run:
            os.close(terminal)
            error = shown(mine, until="evaluations (Ctrl-C keeps the best)")
            run.send_signal(signal.SIGINT)
            error += shown(mine)
            said = run.communicate(timeout=LIMIT)[0]
        os.close(mine)
        self.assertEqual(run.returncode, 130, error)
        self.assertIn("fit: interrupted; this is the best so far", error)
        self.assertIn("links/lower/inertia", said)
        self.assertTrue(os.path.exists(self.path("fitted.yaml")))


def shown(terminal, until=None):
    """The text that a terminal shows until these words come, or until it is closed."""
    text = ""
    while until is None or until not in text:
        try:
            part = os.read(terminal, 4096).decode()
        except OSError:  # closed
            part = ""
        if not part:
            break
        text += part
    return text


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

    def test_pieces_without_a_status_are_told(self):
        import rosbag  # pylint: disable=import-outside-toplevel
        less = self.path("less.bag")
        with rosbag.Bag(self.record()) as bag, rosbag.Bag(less, "w") as out:
            for topic, message, stamp in bag.read_messages():
                if not (topic.endswith("/status") and 150 <= message.tick <= 250):
                    out.write(topic, message, stamp)
        result = fit(self.ARM, less, list(self.TRUE))
        self.assertEqual([name for name, _ in result.errors], ["less.bag, piece 1", "less.bag, piece 2"])
        self.assertIn("less.bag: 1 of 3 pieces, of 99 states, hold no status and are left out: raise publish/status_rate",
                      result.warnings)

    def test_commands_without_a_status_are_refused(self):
        import rosbag  # pylint: disable=import-outside-toplevel
        less = self.path("less.bag")
        with rosbag.Bag(self.record()) as bag, rosbag.Bag(less, "w") as out:
            for topic, message, stamp in bag.read_messages(["/joint_states", "/planar_chain/commands_taken"]):
                out.write(topic, message, stamp)
        for node in (None, "planar_chain"):
            with self.assertRaisesRegex(BadFit, "expected a status of /planar_chain beside its commands_taken, got none"):
                fit(self.ARM, less, list(self.TRUE), node=node)

    def test_pieces_shorter_than_the_first_window_are_told(self):
        result = fit(self.ARM, self.record(), list(self.TRUE), windows=(1.2, 2.4))
        self.assertEqual([name for name, _ in result.errors], ["run.bag, piece 1", "run.bag, piece 3"])
        self.assertIn("run.bag, piece 2: left out, with fewer than 10 samples or shorter than 1.2 s, the first window (--windows)",
                      result.warnings)
        with self.assertRaisesRegex(BadFit, "run.bag, piece 1: expected at least 3 s, the first window"):
            fit(self.ARM, self.record(), list(self.TRUE), windows=(3,))

    def test_a_bag_in_which_the_node_was_started_again_is_refused(self):
        import genpy  # pylint: disable=import-outside-toplevel
        import rosbag  # pylint: disable=import-outside-toplevel
        run = self.record()
        for has_commands, words in ((True, "its command 1 is of tick 5 and of tick 5"), (False, "its status 1 is of tick 20 and of tick 20")):
            with rosbag.Bag(run) as once, rosbag.Bag(self.path("twice.bag"), "w") as bag:
                for later in (0, 100):
                    for topic, message, received in once.read_messages():
                        if topic in ("/joint_states", "/planar_chain/status"):
                            message.header.stamp += genpy.Duration(later)
                            message.header.seq *= not has_commands  # as a writer leaves it that does not count
                        if topic.endswith("/status"):
                            message.tick_stamp += genpy.Duration(later)
                        if has_commands or not (later and topic.endswith("commands_taken")):
                            bag.write(topic, message, received + genpy.Duration(later))
            with self.assertRaisesRegex(BadFit, f"expected one run of /planar_chain, got a second one: {words} "):
                fit(self.ARM, self.path("twice.bag"), list(self.TRUE))

    def test_a_bag_that_lost_the_last_commands_is_refused(self):
        import rosbag  # pylint: disable=import-outside-toplevel
        run = self.record()
        for last, at in ((24, 1.19), (0, 0.09)):
            with rosbag.Bag(run) as whole, rosbag.Bag(self.path("lost.bag"), "w") as bag:
                for topic, message, received in whole.read_messages():
                    if not topic.endswith("commands_taken") or message.number <= last:
                        bag.write(topic, message, received)
            with self.assertRaisesRegex(BadFit, rf"expected every command that the node took, got none of kind JOINT_TORQUES at {at}\d* s, which its"):
                fit(self.ARM, self.path("lost.bag"), list(self.TRUE))

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
        with rosbag.Bag(bag("good.bag", good), "a") as file:  # an encoder beside it
            file.write("/planar_chain/enc", JointState(name=["rod_joint"], position=[9.0]), genpy.Time(1))
        self.assertTrue(fit(PENDULUM, self.path("good.bag"), ["links/rod/com/0"]).recordings[0].q[1, 0] == math.sin(0.1))
        turned = [{**one, "position": [0.1, one["position"][1] + 20 * math.pi]} for one in good]  # rad, though above 50
        self.assertTrue(fit(PENDULUM, bag("turned.bag", turned), ["links/rod/com/0"]).recordings[0].q[1, 0] > 50)
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
        with self.assertRaisesRegex(BadFit, "a bag that can be read, got one without an index; .*rosbag reindex .*no.bag"):
            fit(PENDULUM, self.path("no.bag"), ["links/rod/com/0"])
        with self.assertRaisesRegex(BadFit, "expected an effort"):
            fit(PENDULUM, self.path("good.bag"), ["links/rod/com/0"], effort=True)


if __name__ == "__main__":
    BIN = sys.argv.pop(1)
    unittest.main(verbosity=2)
