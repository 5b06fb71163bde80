#!/usr/bin/python3
"""simulate --bag and --commands, seen with rosbag's own reader and fed by its own writer: no master runs.

    bag_test.py BIN [unittest options]        BIN: the folder that holds simulate; ROS's environment is needed
"""
import csv
import math
import os
import re
import signal
import subprocess
import sys
import time
import unittest
import xml.etree.ElementTree

import genpy
import rosbag
from geometry_msgs.msg import Point, Vector3
from planar_chain.msg import CommandTaken, JointTorque, LinkForce, SimStatus
from std_msgs.msg import Float64MultiArray

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../support"))
from in_folder import InFolder  # noqa: E402

BIN = ""
ROD = "{mass: 1, inertia: 1e-1, com: [0.5, 0], pin: [1, 0], initial: {angle: 0.4}}"
CHAIN = f"chain: [upper, lower]\nlinks: {{upper: {ROD}, lower: {ROD}}}\n"
SCENE = CHAIN + "publish: {rate: 300, tf_rate: 70, status_rate: 10}\n"


def stamp_of(k, rate=300):
    """ns; whole at the end, so that nothing adds up"""
    return (2 * k * 10**9 + rate) // (2 * rate)


def time_of(nanoseconds):
    return genpy.Time(nanoseconds // 10**9, nanoseconds % 10**9)


def running():
    """{pid: (that of the parent, the command)} of all processes that have not ended."""
    said = subprocess.run(["ps", "-eo", "pid,ppid,stat,args"], stdout=subprocess.PIPE, universal_newlines=True, check=True).stdout
    rows = (line.split(None, 3) for line in said.splitlines()[1:])
    return {int(pid): (int(parent), command) for pid, parent, state, command in rows if state[0] != "Z"}


def below(pid):
    """{pid: command} of what this process started, and what that started."""
    everyone = running()
    found = {one: command for one, (parent, command) in everyone.items() if parent == pid}
    for one in list(found):
        found.update(below(one))
    return found


class Bags(InFolder):
    def test_an_interrupted_run_leaves_a_whole_bag(self):
        bag = self.path("out.bag")
        with open(self.path("scene.yaml"), "w") as file:
            file.write(SCENE)
        with subprocess.Popen([os.path.join(BIN, "simulate"), self.path("scene.yaml"), "--duration", "1e5", "--bag", bag],
                              stderr=subprocess.PIPE, universal_newlines=True) as run:
            deadline = time.monotonic() + 60
            while not (os.path.exists(bag) and os.path.getsize(bag) > 10 ** 6) and time.monotonic() < deadline:
                time.sleep(0.01)
            for _ in range(2):  # timeout(1) sends two
                run.send_signal(signal.SIGINT)
            error = run.communicate(timeout=60)[1]
        self.assertEqual(run.returncode, 130)
        stamps = [received for received, _ in self.read("out.bag")["/joint_states"]]
        self.assertEqual(stamps, [stamp_of(k) for k in range(1, len(stamps) + 1)])
        said = re.search("the last row is at t = (.*) s, of 100000 s", error).group(1)
        self.assertEqual(float(said), len(stamps) / 300)

    def test_a_run_shorter_than_a_tick_has_no_bag(self):
        result = self.run_tool("--duration", "0.003", "--bag", self.path("out.bag"))
        self.assert_refused(result, "--duration: expected at least a tick of 0.0033333333333333335 s, the first with messages, got 0.003")
        self.assertFalse(os.path.exists(self.path("out.bag")))
        self.simulate("--duration", "0.003", "--write-urdf", self.path("robot.urdf"))
        self.assertEqual(len(self.bag("--duration", "0.0034")["/joint_states"]), 1)

    def test_what_a_urdf_does_not_have_is_told(self):
        link = ROD[:-1] + ", joint: {drag: 0.1, damping: 0.2, friction: 0.1, lower: -1, upper: 2, effort_limit: 3}}"
        urdf = self.path("robot.urdf")
        result = self.run_tool("--duration", "0.1", "--write-urdf", urdf, scene=f"chain: [a]\nlinks: {{a: {link}}}\ngravity: [0, -1]\n")
        self.assertEqual(result.stderr, f"simulate: {urdf} is without what URDF does not have: drag, gravity, initial/angle, stop_damping, stop_stiffness\n")
        closed = "chain: [a, b, c]\nlinks: {a: %s, b: %s, c: %s}\ntip: {pin: [1.5, 0]}\n" % ((ROD.replace("0.4", "0.1"),) * 3)
        result = self.run_tool("--duration", "0.1", "--write-urdf", urdf, scene=closed)
        self.assertIn("URDF does not have: initial/angle, tip\n", result.stderr)
        cart = "chain: [a, b]\nlinks: {a: {mass: 1, joint: {type: prismatic}, initial: {position: 1}}, b: {mass: 1, inertia: 1, com: [1, 0], pin: [1, 0]}}\n"
        result = self.run_tool("--duration", "0.1", "--write-urdf", urdf, scene=cart)
        self.assertIn("URDF does not have: initial/position\n", result.stderr)
        bare = self.run_tool("--duration", "0.1", "--write-urdf", urdf, scene="chain: [a]\nlinks: {a: {mass: 1, inertia: 1, com: [1, 0], pin: [1, 0]}}\n")
        self.assertEqual(bare.stderr, "")

    @unittest.skipUnless(os.path.exists("/dev/full"), "no /dev/full")
    def test_a_urdf_that_cannot_be_written_says_why(self):
        result = self.run_tool("--duration", "0.1", "--write-urdf", "/dev/full")
        self.assertEqual((result.returncode, result.stderr),
                         (1, "simulate: cannot write /dev/full: No space left on device\n"))

    def run_tool(self, *arguments, scene=SCENE):
        with open(self.path("scene.yaml"), "w") as file:
            file.write(scene)
        command = [os.path.join(BIN, "simulate"), self.path("scene.yaml"), *arguments]
        return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              universal_newlines=True, timeout=60)

    def simulate(self, *arguments, scene=SCENE):
        result = self.run_tool(*arguments, scene=scene)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stdout

    def bag(self, *arguments, name="out.bag", scene=SCENE):
        """{topic: [(ns at which it was received, message)]} of a run with these arguments."""
        self.simulate("--bag", self.path(name), *arguments, scene=scene)
        return self.read(name)

    def read(self, name):
        topics = {}
        with rosbag.Bag(self.path(name)) as bag:
            for topic, message, received in bag.read_messages():
                topics.setdefault(topic, []).append((received.to_nsec(), message))
        return topics

    def bytes_of(self, name):
        with open(self.path(name), "rb") as file:
            return file.read()

    def rows(self):
        with open(self.path("out.csv"), newline="") as file:
            return [[float(entry) for entry in row] for row in list(csv.reader(file))[1:]]

    def assert_refused(self, result, *words, status=2):
        self.assertEqual(result.returncode, status, result.stderr)
        for word in words:
            self.assertIn(word, result.stderr)
        self.assertEqual(result.stdout, "")

    # ---- What is written -------------------------------------------------------------------------

    def test_topics_types_and_counts(self):
        topics = self.bag("--duration", "20")  # several chunks
        self.assertEqual({topic: (messages[0][1]._type, len(messages)) for topic, messages in topics.items()}, {
            "/clock": ("rosgraph_msgs/Clock", 6000),
            "/joint_states": ("sensor_msgs/JointState", 6000),
            "/tf": ("tf2_msgs/TFMessage", 1400),
            "/tf_static": ("tf2_msgs/TFMessage", 1),
            "/planar_chain/scene": ("std_msgs/String", 1),
            "/planar_chain/link_states": ("planar_chain/LinkStates", 6000),
            "/planar_chain/status": ("planar_chain/SimStatus", 200)})

    def test_a_bag_has_its_scene(self):
        (_, scene), = self.bag("--duration", "0.1", "--tolerance", "1e-6")["/planar_chain/scene"]
        with open(self.path("again.yaml"), "w") as file:
            file.write(scene.data)
        first = self.path("first.csv"), self.path("scene.yaml"), "--tolerance", "1e-6"
        for out, *rest in (first, (self.path("again.csv"), self.path("again.yaml"))):
            subprocess.run([os.path.join(BIN, "simulate"), *rest, "--duration", "1", "--csv", out], check=True, stdout=subprocess.DEVNULL)
        self.assertEqual(self.bytes_of("first.csv"), self.bytes_of("again.csv"))

    SENSORS = ("sensors:\n  encoders: {joints: all, resolution: 3e-3, noise: 1e-3, delay: 0.005, rate: 100}\n"
               "  imu: {link: lower, point: [0.5, 0.1], angle: 0.3, gyro_noise: 0.01, gyro_bias_walk: 0.1, "
               "accelerometer_noise: 0.05, rate: 400}\nseed: 3\n")

    def test_sensors_are_as_their_users_expect(self):
        topics = self.bag("--duration", "1", scene=SCENE + self.SENSORS)
        encoders, imus = topics["/planar_chain/encoders"], topics["/planar_chain/imu"]
        # sensor_msgs/JointState: "The header specifies the time at which the joint states were recorded."
        self.assertEqual([message.header.stamp.to_nsec() for _, message in encoders], [k * 10 ** 7 for k in range(1, 100)])
        self.assertEqual([message.header.stamp.to_nsec() for _, message in imus], [k * 2500000 for k in range(1, 401)])
        for received, message in encoders:
            self.assertTrue(0 <= received - message.header.stamp.to_nsec() - 5 * 10 ** 6 < 1e9 / 300 + 2)
            self.assertEqual((message.name, len(message.position)), (["upper_joint", "lower_joint"], 2))
            self.assertEqual((message.velocity, message.effort), ((), ()))
        for received, message in imus:
            self.assertTrue(0 <= received - message.header.stamp.to_nsec() < 1e9 / 300 + 2)
            # sensor_msgs/Imu: "If you have no estimate for one of the data elements ... please set element 0 of the
            # associated covariance matrix to -1". robot_localization then ignores the orientation.
            self.assertEqual(message.orientation_covariance, (-1.0,) + 8 * (0.0,))
            # imu_filter_madgwick and robot_localization look the frame up in /tf.
            self.assertEqual(message.header.frame_id, "imu")
            for covariance, noise in ((message.angular_velocity_covariance, 0.01), (message.linear_acceleration_covariance, 0.05)):
                self.assertEqual(covariance, tuple(noise * noise if i % 4 == 0 else 0.0 for i in range(9)))
        transform, = [each for each in topics["/tf_static"][0][1].transforms if each.child_frame_id == "imu"]
        self.assertEqual(transform.header.frame_id, "lower")
        place, turn = transform.transform.translation, transform.transform.rotation
        self.assertEqual((place.x, place.y, place.z), (0.5, 0.1, 0))
        self.assertAlmostEqual(2 * math.atan2(turn.z, turn.w), 0.3, 15)

    def test_what_holds_the_tip_is_that_of_python_to_the_last_bit(self):
        try:
            from planar_chain import Scene, Simulation
        except ImportError:
            self.skipTest("no Python module")
        self.assertNotIn("/planar_chain/tip_wrench", self.bag("--duration", "0.1"))
        scene = SCENE + "tip: {pin: {x: {offset: 1.5, amplitude: 0.1, frequency: 1.0}, y: {offset: 0.2}}}\n"
        topics = self.bag("--duration", "1", scene=scene)
        simulation = Simulation(Scene.from_yaml(scene))
        expected, gaps = [], {}
        for k in range(1, 301):
            simulation.advance_to(k / 300)
            x, y = simulation.tip_force()
            expected.append((stamp_of(k), "base_link", x, y, 0, 0, 0, 0))
            gaps[stamp_of(k)] = simulation.closure_error()
        found = [(message.header.stamp.to_nsec(), message.header.frame_id,
                  *(getattr(part, axis) for part in (message.wrench.force, message.wrench.torque) for axis in "xyz"))
                 for _, message in topics["/planar_chain/tip_wrench"]]
        self.assertEqual(found, expected)
        self.assertGreater(max(y for _, _, _, y, *_ in found), 1)  # N: it carries
        told = [message.closure_error for _, message in topics["/planar_chain/status"]]
        self.assertEqual(told, [gaps[stamp] for stamp, _ in topics["/planar_chain/status"]])
        margins = [message.closure_margin for _, message in topics["/planar_chain/status"]]
        self.assertEqual(margins[-1], simulation.closure_margin())
        self.assertTrue(all(0 < margin < 1 for margin in margins), margins)
        self.assertGreater(max(told), 0)
        self.assertLess(max(told), 1e-12 * 2)  # m, of the reach

    def test_sensors_change_no_state_and_python_measures_the_same(self):
        try:
            from planar_chain import Scene, Simulation
        except ImportError:
            self.skipTest("no Python module")
        states = self.bag("--duration", "1")["/joint_states"]
        topics = self.bag("--duration", "1", name="sensed.bag", scene=SCENE + self.SENSORS)
        self.assertEqual([str(each) for each in topics["/joint_states"]], [str(each) for each in states])
        simulation = Simulation(Scene.from_yaml(SCENE + self.SENSORS), commands=1)
        measured = {"encoders": [], "imu": []}
        for k in range(301):
            simulation.advance_to(k / 300)
            for one in simulation.measure():
                if one.time > 0:
                    measured[one.sensor].append(tuple(one.values))
        self.assertEqual([message.position for _, message in topics["/planar_chain/encoders"]], measured["encoders"])
        self.assertEqual([(message.angular_velocity.x, message.angular_velocity.y, message.angular_velocity.z,
                           message.linear_acceleration.x, message.linear_acceleration.y, message.linear_acceleration.z)
                          for _, message in topics["/planar_chain/imu"]], measured["imu"])

    def test_views_are_those_that_rviz_shows(self):
        views = {topic: messages for topic, messages in self.bag("--duration", "2", "--views").items() if "/view/" in topic}
        self.assertEqual({topic: (messages[0][1]._type, len(messages)) for topic, messages in views.items()}, {
            "/planar_chain/view/" + name: ("visualization_msgs/MarkerArray", 140)
            for name in ("loads", "pin_forces", "springs", "drives", "friction", "trail", "centres", "limits", "scale", "energy")})
        stamp, energy = views["/planar_chain/view/energy"][-1]
        self.assertEqual({stamp, *(marker.header.stamp.to_nsec() for marker in energy.markers)}, {2 * 10**9})
        self.assertEqual(energy.markers[0].text, "2.00 s time")
        trail = views["/planar_chain/view/trail"][-1][1].markers[0]
        self.assertEqual(len(trail.points), 140)
        self.assert_refused(self.run_tool("--duration", "1", "--views"), "--views: expected --bag")

    def test_connections_are_those_of_the_node_and_tf_static_is_latched(self):
        self.bag("--duration", "0.1")
        with rosbag.Bag(self.path("out.bag")) as bag:
            headers = {c.topic: c.header for c in bag._connections.values()}
        self.assertEqual({header["callerid"] for header in headers.values()}, {b"/planar_chain"})
        self.assertEqual({topic for topic, header in headers.items() if header["latching"] == b"1"},
                         {"/tf_static", "/planar_chain/scene"})

    def test_stamps_are_those_of_the_ticks_and_never_0(self):
        topics = self.bag("--duration", "2")
        ticks = [stamp_of(k) for k in range(1, 601)]
        stamps = {topic: [received for received, _ in messages] for topic, messages in topics.items()}
        for topic in ("/clock", "/joint_states", "/planar_chain/link_states"):
            self.assertEqual(stamps[topic], ticks)
        for topic in ("/tf", "/planar_chain/status"):
            self.assertEqual(sorted(set(stamps[topic]) & set(ticks)), stamps[topic])
        self.assertEqual(stamps["/tf_static"], ticks[:1])
        # What the messages say themselves
        self.assertEqual([message.clock.to_nsec() for _, message in topics["/clock"]], ticks)
        for topic in ("/joint_states", "/planar_chain/link_states", "/planar_chain/status"):
            self.assertEqual([message.header.stamp.to_nsec() for _, message in topics[topic]], stamps[topic])
            self.assertEqual([message.header.seq for _, message in topics[topic]], list(range(len(stamps[topic]))))
        for topic in ("/tf", "/tf_static"):
            for received, message in topics[topic]:
                self.assertEqual({t.header.stamp.to_nsec() for t in message.transforms}, {received})

    def test_values_are_those_of_the_csv_to_the_last_bit(self):
        topics = self.bag("--duration", "2", "--csv", self.path("out.csv"))
        rows = self.rows()[1:]
        self.assertEqual([[*m.position, *m.velocity] for _, m in topics["/joint_states"]],
                         [row[1:5] for row in rows])
        by_stamp = dict(zip((received for received, _ in topics["/clock"]), rows))
        for stamp, status in topics["/planar_chain/status"]:
            self.assertEqual(status.sim_time, by_stamp[stamp][0])
            self.assertEqual(status.kinetic + status.potential, by_stamp[stamp][5])
            self.assertEqual((status.real_time_factor, status.overruns, status.lag, status.joint_torque_age),
                             (0, 0, 0, -1))
        for stamp, links in topics["/planar_chain/link_states"]:
            self.assertAlmostEqual(links.pose[1].theta, sum(by_stamp[stamp][1:3]), delta=1e-12)
        for stamp, message in topics["/tf"]:
            for turn, angle in zip((t.transform.rotation for t in message.transforms), by_stamp[stamp][1:3]):
                self.assertAlmostEqual(turn.z, math.sin(angle / 2), delta=1e-15)

    def test_a_rail_turns_with_its_base(self):
        scene = ("chain: [cart, pole]\nlinks:\n  cart: {mass: 1, com: [0.2, 0.1], pin: [0.1, 0.3], joint: {type: prismatic, axis: [1, 0.5]}, "
                 "initial: {position: 0.3}}\n  pole: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0], initial: {angle: 0.4}}\n"
                 "base: {x: {offset: 0.7}, angle: {offset: 0.5, amplitude: 0.4, frequency: 1.0}}\n"
                 "publish: {rate: 100, tf_rate: 100, frame_every: 1}\n")
        topics = self.bag("--duration", "0.5", scene=scene)
        links = dict(topics["/planar_chain/link_states"])
        for stamp, message in topics["/tf"]:
            place, turn = 0, 1
            poses = []
            for transform in message.transforms:
                moved, turned = transform.transform.translation, transform.transform.rotation
                place += turn * complex(moved.x, moved.y)
                turn *= complex(turned.w, turned.z) ** 2
                poses.append((place, turn))
            self.assertEqual(len(poses), 3)  # the pin of the base, cart, pole
            for (place, turn), com, pose in zip(poses[1:], (0.2 + 0.1j, 0.5), links[stamp].pose):
                self.assertLess(abs(place + turn * com - complex(pose.x, pose.y)), 1e-12)
                self.assertLess(abs(turn - complex(math.cos(pose.theta), math.sin(pose.theta))), 1e-12)

    def test_a_bag_does_not_change_the_motion(self):
        self.bag("--duration", "1", "--csv", self.path("out.csv"))
        with_bag = self.rows()
        self.simulate("--duration", "1", "--rate", "300", "--csv", self.path("out.csv"))
        self.assertEqual(self.rows(), with_bag)

    def test_two_runs_give_the_same_bytes(self):
        self.bag("--duration", "10", name="one.bag")
        self.bag("--duration", "10", name="two.bag")
        self.assertGreater(len(self.bytes_of("one.bag")), 10**6)
        self.assertTrue(self.bytes_of("one.bag") == self.bytes_of("two.bag"))

    def test_what_the_scene_does_not_want_is_not_there(self):
        topics = self.bag("--duration", "1", scene=CHAIN + "publish: {tf: false, link_states: false}\n")
        self.assertEqual(set(topics), {"/clock", "/joint_states", "/planar_chain/status", "/planar_chain/scene"})
        self.assertEqual(len(topics["/joint_states"]), 200)

    def test_the_rate_replaces_that_of_the_scene_and_is_judged_as_it_is(self):
        topics = self.bag("--duration", "1", "--rate", "100")
        self.assertEqual([received for received, _ in topics["/joint_states"]], [10**7 * k for k in range(1, 101)])
        self.assert_refused(self.run_tool("--duration", "1", "--rate", "50", "--bag", self.path("new.bag")),
                            "publish/tf_rate")

    def test_a_last_row_between_ticks_is_no_message(self):
        topics = self.bag("--duration", "0.0249", "--rate", "100", "--csv", self.path("out.csv"))
        self.assertEqual([row[0] for row in self.rows()], [0, 0.01, 0.02, 0.0249])
        self.assertEqual([received for received, _ in topics["/clock"]], [10**7, 2 * 10**7])

    def test_a_node_of_another_name_in_a_namespace(self):
        topics = self.bag("--duration", "0.1", "--node", "/left/arm")
        self.assertEqual(set(topics), {"/clock", "/tf", "/tf_static", "/left/joint_states", "/left/arm/status",
                                       "/left/arm/link_states", "/left/arm/scene"})
        self.assertEqual([t.child_frame_id for t in topics["/tf"][0][1].transforms], ["left/upper", "left/lower"])
        for name in ("", "/", "a b"):
            self.assert_refused(self.run_tool("--duration", "1", "--bag", self.path("new.bag"), "--node", name),
                                "--node: expected the name of a node")
        self.assert_refused(self.run_tool("--duration", "1", "--node", "arm"), "--node")

    def test_the_urdf_bears_the_frames_of_tf(self):
        topics = self.bag("--duration", "0.1", "--write-urdf", self.path("out.urdf"), "--node", "/left/arm",
                          scene=SCENE + "frames: {gripper: {link: upper, point: [0.1, 0.2], angle: 1}}\n")
        with open(self.path("out.urdf")) as file:
            links = {link.get("name") for link in xml.etree.ElementTree.parse(file).findall("link")}
        transforms = topics["/tf"][0][1].transforms + topics["/tf_static"][0][1].transforms
        self.assertEqual(links, {t.header.frame_id for t in transforms} | {t.child_frame_id for t in transforms})
        gripper, = [t for t in transforms if t.child_frame_id == "left/gripper"]
        place = gripper.transform.translation
        self.assertEqual((gripper.header.frame_id, place.x, place.y), ("left/upper", 0.1, 0.2))
        self.assertAlmostEqual(2 * math.atan2(gripper.transform.rotation.z, gripper.transform.rotation.w), 1, 14)
        self.assertIn("left/tip", links)
        self.assert_refused(self.run_tool("--duration", "1", "--write-urdf", self.path("scene.yaml")), "--write-urdf")

    # ---- What goes wrong -------------------------------------------------------------------------

    def test_files_that_cannot_be_written_are_refused_and_nothing_is_touched(self):
        with open(self.path("out.csv"), "w") as file:
            file.write("precious")
        for path, why in ((self.path("no/out.bag"), "No such file"), (self.folder, "Is a directory"),
                          (self.path("scene.yaml"), "not another"), (self.path("out.csv"), "not another")):
            result = self.run_tool("--duration", "1e6", "--csv", self.path("out.csv"), "--bag", path)
            self.assert_refused(result, "--bag: expected a file that", why)
        self.assertEqual(self.bytes_of("out.csv"), b"precious")
        self.assertEqual(self.bytes_of("scene.yaml").decode(), SCENE)

    @unittest.skipUnless(os.path.exists("/dev/full"), "no /dev/full")
    def test_a_full_disk_fails_the_run(self):
        for duration in ("0.1", "20"):
            self.assert_refused(self.run_tool("--duration", duration, "--bag", "/dev/full"), "No space left", status=1)

    def test_a_failed_run_keeps_a_whole_bag_that_names_the_fault(self):
        blow_up = SCENE + "loads: {p: {joint: lower_joint, torque: 1e300, start: 0.35}}\n"
        result = self.run_tool("--duration", "1", "--bag", self.path("out.bag"), scene=blow_up)
        self.assert_refused(result, "failed at t = ", status=1)
        topics = self.read("out.bag")
        self.assertNotEqual(topics["/planar_chain/status"][-1][1].fault, "")
        states = topics["/joint_states"]
        self.assertGreaterEqual(len(states), 105)
        self.assertTrue(all(math.isfinite(x) for _, m in states for x in (*m.position, *m.velocity, *m.effort)))

    def test_show_names_what_it_cannot_play(self):
        self.bag("--duration", "0.1", name="one.bag")
        for name, text in (("cut.bag", self.bytes_of("one.bag")[:9000]), ("broken.yaml", b"chain: [a\nlinks: {b: 1}\n"),
                           ("wrong.yaml", b"a: 1\n"), ("view.rviz", b""), ("run.csv", b"")):
            with open(self.path(name), "wb") as file:
                file.write(text)
        for given, words in ((["cut.bag"], "cut.bag: expected a bag that can be read, got one without an index;"),
                             (["none.bag"], "none.bag: expected a bag"), (["one.bag", "none.yaml"], "No such file or directory"),
                             (["one.bag", "broken.yaml"], "broken.yaml is refused:\nline 2: "),
                             (["run.csv"], "run.csv: expected a bag (plot draws a CSV), or a file of rviz"),
                             (["none.rviz"], "none.rviz: expected a bag"), (["view.rviz"], "show: no roscore runs; start a scene first"),
                             (["one.bag", ""], "show: : expected a scene that can be read, got nothing: No such file or directory"),
                             (["one.bag", "wrong.yaml"], "wrong.yaml is refused:\nline 1: a: expected one of the keys chain")):
            result = subprocess.run([os.path.join(BIN, "show"), *(name and self.path(name) for name in given)], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                    env={**os.environ, "ROS_MASTER_URI": "http://localhost:1"}, universal_newlines=True, timeout=60,
                                    check=False)
            self.assertEqual((result.returncode, result.stdout), (2, ""), result.stderr)
            self.assertRegex(result.stderr, "^show: ")
            self.assertIn(words, result.stderr)

    def shown(self, **more):
        """show, without its end: it plays a bag in what takes the place of rviz."""
        self.bag("--duration", "20", name="one.bag")
        with open(self.path("rviz"), "w") as file:
            file.write("#!/usr/bin/python3\nimport rospy\nfrom tf2_msgs.msg import TFMessage\nrospy.init_node('rviz')\n"
                       "rospy.Subscriber('/tf', TFMessage, lambda message: None)\nrospy.spin()\n")
        os.chmod(self.path("rviz"), 0o755)
        environment = {name: value for name, value in os.environ.items() if "DISPLAY" not in name and name != "QT_QPA_PLATFORM"}
        show = subprocess.Popen([os.path.join(BIN, "show"), self.path("one.bag")], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                universal_newlines=True, start_new_session=True,
                                env={**environment, "PATH": self.folder + ":" + os.environ["PATH"], "HOME": self.folder, **more})
        self.addCleanup(show.wait, 60)
        self.addCleanup(show.terminate)
        return show

    def test_show_needs_a_display(self):
        show = self.shown()
        self.assertEqual(show.communicate(timeout=60),
                         ("", "show: rviz needs a display, and DISPLAY is not set. Without one, plot draws a bag\n"))
        self.assertEqual(show.returncode, 1)

    def test_what_show_has_started_ends_with_it(self):
        self.assert_all_end(signal.SIGTERM, 128 + signal.SIGTERM)

    def test_what_show_has_started_ends_with_an_interrupt_of_show_alone(self):
        self.assert_all_end(signal.SIGINT, 0)

    def assert_all_end(self, by, status):
        show = self.shown(DISPLAY=":0", ROS_PACKAGE_PATH="")  # without setup.bash
        deadline = time.monotonic() + 60
        started = {}
        while not any("rosbag/play" in command for command in started.values()) and time.monotonic() < deadline:
            time.sleep(0.1)
            started = below(show.pid)
        show.send_signal(by)
        self.assertNotIn("Traceback", show.communicate(timeout=60)[1])
        self.assertEqual(show.returncode, status)
        for program in ("roscore", "rosmaster", "rviz", "rosbag/play"):
            self.assertTrue(any(program in command for command in started.values()), (program, started))
        while any(pid in running() for pid in started) and time.monotonic() < deadline:
            time.sleep(0.1)
        left = {pid: command for pid, command in started.items() if pid in running()}
        for pid in left:
            os.kill(pid, signal.SIGKILL)
        self.assertEqual(left, {})

    # ---- Commands --------------------------------------------------------------------------------

    def write(self, name, *messages):
        """A bag of (topic, message, ns at which it was received)."""
        with rosbag.Bag(self.path(name), "w") as bag:
            for topic, message, received in messages:
                bag.write(topic, message, time_of(received))

    COMMANDS = [
        CommandTaken(number=1, tick=31, scene_time=30 / 300, kind=CommandTaken.JOINT_TORQUE, joint_torque=[JointTorque(joint="lower_joint", torque=2.0, duration=0.0373)]),
        CommandTaken(number=2, tick=61, scene_time=60 / 300, joint_torques=[0.5, -0.5]),
        CommandTaken(number=3, tick=61, scene_time=60 / 300, kind=CommandTaken.JOINT_TORQUE, joint_torque=[JointTorque(joint="upper_joint", torque=1.5, duration=0.0)]),
        CommandTaken(number=4, tick=91, scene_time=90 / 300,
                     kind=CommandTaken.LINK_FORCE, link_force=[LinkForce(link="lower", point=Point(0.0, 0.0, 0.0), force=Vector3(3.0, 1.0, 0.0), moment=0.2, duration=0.25)])]

    def write_commands(self, name, commands, node="/planar_chain"):
        self.write(name, *((node + "/commands_taken", command, 10**9 + i) for i, command in enumerate(commands)))

    def test_commands_act_from_their_ticks_as_loads_do(self):
        self.write_commands("in.bag", self.COMMANDS)
        said = self.simulate("--duration", "1", "--commands", self.path("in.bag"), "--csv", self.path("out.csv"))
        self.assertIn("commands of /planar_chain: 4 taken\n", said)
        commanded = self.rows()
        self.simulate("--duration", "1", "--rate", "300", "--csv", self.path("out.csv"), scene=SCENE + """
loads:
  one: {joint: lower_joint, torque: 2.0, start: 0.1, stop: 0.1373}
  two: {joint: lower_joint, torque: -0.5, start: 0.2}
  three: {joint: upper_joint, torque: 1.5, start: 0.2}
  four: {link: lower, force: [3, 1], point: [0, 0], moment: 0.2, start: 0.3, stop: 0.55}
""")
        for row, expected in zip(commanded, self.rows()):
            for value, its in zip(row[:5], expected):
                self.assertAlmostEqual(value, its, delta=1e-7)  # the tolerance, grown
        self.simulate("--duration", "1", "--rate", "300", "--csv", self.path("out.csv"))
        self.assertGreater(abs(self.rows()[-1][1] - commanded[-1][1]), 0.01)

    def test_a_bag_of_a_run_with_commands_gives_the_same_run_again(self):
        self.write_commands("in.bag", reversed(self.COMMANDS))
        topics = self.bag("--duration", "1", "--commands", self.path("in.bag"), name="one.bag")
        self.assertEqual([str(message) for _, message in topics["/planar_chain/commands_taken"]],
                         [str(command) for command in self.COMMANDS])
        self.assertEqual(topics["/planar_chain/status"][-1][1].joint_torques_age, 1 - 60 / 300)
        self.bag("--duration", "1", "--commands", self.path("one.bag"), name="two.bag")
        self.assertTrue(self.bytes_of("one.bag") == self.bytes_of("two.bag"))

    def test_another_scene_than_the_recorded_one_is_named(self):
        self.write_commands("in.bag", self.COMMANDS)
        self.bag("--duration", "1", "--commands", self.path("in.bag"), name="one.bag")
        for scene, words in (
                (SCENE.replace("rate: 300", "rate: 3e2"), ""), (SCENE.replace("mass: 1", "mass: 1.00"), ""), (SCENE + "seed: 6\n", ""),
                (SCENE + "sensors: {e: {joints: all, rate: 100}}\n", ""),
                (SCENE + "command_timeout: 0.5\n", "command_timeout was nothing, here it is 0.5"),
                (SCENE.replace("mass: 1", "mass: 2", 1), "links/upper/mass was 1, here it is 2")):
            self.assertNotEqual(scene, SCENE)
            said = self.run_tool("--duration", "1", "--commands", self.path("one.bag"), scene=scene).stderr
            self.assertEqual(said, words and f"simulate: {self.path('one.bag')} was recorded with another scene, so its motion "
                                             f"is not compared: {words}\n")

    def test_without_a_duration_a_run_ends_as_the_recorded_one(self):
        self.write_commands("in.bag", self.COMMANDS)
        self.bag("--duration", "1.23", "--commands", self.path("in.bag"), name="one.bag")  # between two of status
        self.bag("--commands", self.path("one.bag"), name="two.bag")
        self.assertTrue(self.bytes_of("one.bag") == self.bytes_of("two.bag"))
        # Stamps that jump over a pause are not the time that was simulated.
        late = [(topic, message, received + (10**12 if received > 10**9 else 0))
                for topic, messages in self.read("one.bag").items() for received, message in messages]
        for _, message, received in late:
            if hasattr(message, "header"):
                message.header.stamp = time_of(received)
            if hasattr(message, "tick_stamp"):
                message.tick_stamp = time_of(received)
        self.write("late.bag", *late)
        self.bag("--commands", self.path("late.bag"), name="two.bag")
        self.assertTrue(self.bytes_of("one.bag") == self.bytes_of("two.bag"))

        # A busy machine stamps a status late, and its topics come in any order.
        for more in (-10**7, 10**7):
            busy = []
            for topic, messages in self.read("one.bag").items():
                for received, message in messages:
                    if topic == "/planar_chain/status":
                        message.header.stamp = time_of(received + 10**7)
                        received = max(1, received + more)
                    busy.append((topic, message, received))
            self.write("busy.bag", *busy)
            self.bag("--commands", self.path("busy.bag"), name="two.bag")
            self.assertTrue(self.bytes_of("one.bag") == self.bytes_of("two.bag"), more)

        # Times that run backwards, those of the messages too, as with an external clock: the order is that of the ticks.
        for has_stamps in (False, True):
            back = []
            for topic, messages in self.read("one.bag").items():
                for received, message in messages:
                    if has_stamps and hasattr(message, "tick_stamp"):
                        message.tick_stamp = time_of(2 * 10**9 - message.tick_stamp.to_nsec())
                    if has_stamps and hasattr(message, "header"):
                        message.header.stamp = time_of(2 * 10**9 - message.header.stamp.to_nsec())
                    back.append((topic, message, 2 * 10**9 - received))
            self.write("order.bag", *back)
            said = self.simulate("--commands", self.path("order.bag"), "--csv", self.path("out.csv"))
            self.assertIn("4 taken\n", said)
            self.assertAlmostEqual(self.rows()[-1][0], 1.23, places=12)

        # Times that repeat half a second.
        loop = []
        for topic, messages in self.read("one.bag").items():
            for received, message in messages:
                back = 5 * 10**8 if received > 7 * 10**8 else 0
                if hasattr(message, "tick_stamp"):
                    message.tick_stamp = time_of(message.tick_stamp.to_nsec() - back)
                if hasattr(message, "header"):
                    message.header.stamp = time_of(message.header.stamp.to_nsec() - back)
                loop.append((topic, message, received - back))
        self.write("loop.bag", *loop)
        self.bag("--commands", self.path("loop.bag"), name="two.bag")
        self.assertTrue(self.bytes_of("one.bag") == self.bytes_of("two.bag"))

        # The last command lies behind the last state.
        self.write("short.bag", *((topic, message, received) for topic, messages in self.read("one.bag").items()
                                  for received, message in messages if received < 0.25e9 or topic.endswith("commands_taken")))
        self.assertIn("4 taken\n", self.simulate("--commands", self.path("short.bag")))

        result = self.run_tool("--commands", self.path("in.bag"), "--bag", self.path("new.bag"))
        self.assert_refused(result, "--duration: expected a time, for the bag has no states of /planar_chain")
        for tick in (10**8 + 1, 2**64 - 1):
            self.write("in.bag", ("/planar_chain/commands_taken", self.COMMANDS[0], 1),
                       ("/planar_chain/status", SimStatus(tick=tick), 2))
            result = self.run_tool("--commands", self.path("in.bag"), "--bag", self.path("new.bag"))
            self.assert_refused(result, "ticks up to number 100000000", str(tick))
        self.assertFalse(os.path.exists(self.path("new.bag")))

    def test_commands_without_their_ticks_are_refused(self):
        self.write("raw.bag", ("/planar_chain/joint_torques", Float64MultiArray(data=[0.5, -0.5]), 10**9))
        self.assert_replay_refused("raw.bag", "expected a bag with commands on a topic such as …/commands_taken")
        self.assert_replay_refused("raw.bag", "/planar_chain/commands_taken", more=("--node", "planar_chain"))

    def assert_replay_refused(self, name, *words, more=()):
        result = self.run_tool("--duration", "1", "--commands", self.path(name), "--bag", self.path("new.bag"), *more)
        self.assert_refused(result, *words)
        self.assertFalse(os.path.exists(self.path("new.bag")))

    def test_a_bag_that_has_lost_commands_is_refused(self):
        self.write_commands("in.bag", self.COMMANDS[1:])
        self.assert_replay_refused("in.bag", "number 2 where 1 is due")
        self.write_commands("in.bag", self.COMMANDS[:1] + self.COMMANDS[2:])
        self.assert_replay_refused("in.bag", "number 3 where 2 is due")
        self.write_commands("in.bag", [CommandTaken(number=2, kind=CommandTaken.RESET)])
        self.assert_replay_refused("in.bag", "number 2 where 1 is due (a reset that changes the scene skips a number")

    def test_a_refused_command_is_named_where_the_motion_differs(self):
        self.write_commands("in.bag", self.COMMANDS)
        one = self.bag("--duration", "1.23", "--commands", self.path("in.bag"), name="one.bag")
        for _, message in one["/planar_chain/commands_taken"]:
            if message.number == 3:
                message.joint_torque[0].joint = "elbow"
        self.write("odd.bag", *((topic, message, received) for topic, messages in one.items() for received, message in messages))
        result = self.run_tool("--commands", self.path("odd.bag"))
        self.assertEqual(result.returncode, 3, result.stderr)
        self.assertRegex(result.stdout, "3 taken, 1 refused; the first refusal, of command 3: joint_torque/joint: expected .*elbow.*\n"
                         r"  from tick 61 \(0.2\d* s\) on, the motion is not the recorded one: command 3 was refused\n$")

    def test_the_time_of_a_csv_goes_on_over_a_reset(self):
        reset = CommandTaken(number=1, tick=61, scene_time=0.2, kind=CommandTaken.RESET)
        self.write_commands("in.bag", [reset])
        self.simulate("--duration", "0.5", "--commands", self.path("in.bag"), "--csv", self.path("out.csv"))
        rows = self.rows()
        self.assertEqual([row[0] for row in rows], [k / 300 for k in range(151)])
        self.assertEqual(rows[61][1:5], rows[0][1:5])

    def test_states_under_relative_names_are_compared_and_others_told(self):
        self.write_commands("in.bag", self.COMMANDS)
        one = self.bag("--duration", "1.23", "--commands", self.path("in.bag"), name="one.bag")
        for changed, names in ((False, slice(1, None)), (True, slice(1, None)), (True, slice(None))):
            for received, message in one["/joint_states"][100:]:
                message.position = [1.0 * changed, 0.0] if changed else message.position
            self.write("names.bag", *((topic[names], message, received) for topic, messages in one.items()
                                      for received, message in messages))
            for more in ((), ("--node", "planar_chain")):
                result = self.run_tool("--commands", self.path("names.bag"), "--bag", self.path("again.bag"), *more)
                self.assertEqual((result.returncode, result.stderr), (3 if changed else 0, ""), result.stdout)
                self.assertIn("t = 1.23 s", result.stdout)
        with rosbag.Bag(self.path("again.bag")) as again:
            self.assertEqual(set(again.get_type_and_topic_info().topics), set(one))
        self.write("without.bag", *((topic, message, received) for topic, messages in one.items() if not topic.endswith("status")
                                    for received, message in messages))
        words = f"simulate: {self.path('without.bag')} has no joint_states with a status of /planar_chain, so its motion is not compared"
        self.assertEqual(self.run_tool("--commands", self.path("without.bag"), "--duration", "1").stderr, words + "\n")
        self.assertEqual(self.run_tool("--commands", self.path("without.bag")).stderr,
                         words + ", and the run ends with the last that it tells\n")

    def test_a_bag_that_has_lost_the_last_commands_is_named(self):
        self.write_commands("in.bag", self.COMMANDS)
        one = self.bag("--duration", "1.23", "--commands", self.path("in.bag"), name="one.bag")
        for kept in (3, 2):
            self.write("lost.bag", *((topic, message, received) for topic, messages in one.items() for received, message in messages
                                     if not (topic.endswith("commands_taken") and message.number > kept)))
            for more in ((), ("--duration", "1"), ("--duration", "9")):
                result = self.run_tool("--commands", self.path("lost.bag"), *more)
                self.assertEqual((result.returncode, result.stderr), (3, ""))
                # The first tick that shows the command, which is the tick it belongs to.
                tick = self.COMMANDS[kept].tick
                self.assertIn(f"from tick {tick} ({tick / 300:.17g} s) on, the motion is not the recorded one: a command after number "
                              f"{kept}, the last in the bag, is missing, or the node had another version or kind of processor, or the bag was changed\n", result.stdout)
            self.simulate("--commands", self.path("lost.bag"), "--duration", "0.2")  # which ends before it
        # Two ticks before the end, behind the last status.
        late = CommandTaken(number=1, tick=367, scene_time=366 / 300, joint_torques=[1.0, 1.0])
        self.write_commands("in.bag", [late])
        one = self.bag("--duration", "1.23", "--commands", self.path("in.bag"), name="one.bag")
        self.write("lost.bag", ("/planar_chain/commands_taken", CommandTaken(number=1, joint_torques=[0.0, 0.0]), 1), *(
            (topic, message, received) for topic, messages in one.items() if not topic.endswith("commands_taken")
            for received, message in messages))
        self.assertIn("from tick 367 ", self.run_tool("--commands", self.path("lost.bag")).stdout)
        # With another scene, the recorded motion is not expected.
        result = self.run_tool("--commands", self.path("lost.bag"), scene=SCENE.replace("mass: 1", "mass: 2", 1))
        self.assertEqual(result.returncode, 0, result.stdout)

    def test_a_bag_in_which_the_node_was_started_again_is_refused(self):
        self.write_commands("in.bag", self.COMMANDS)
        self.bag("--duration", "1", name="one.bag")
        self.bag("--duration", "1.23", "--commands", self.path("in.bag"), name="two.bag")
        for names, words in ((("one.bag", "two.bag"), "its status 1 is of tick 60 and of tick 60"),
                             (("two.bag", "one.bag"), "its status 1 is of tick 60 and of tick 60"),
                             (("two.bag", "two.bag"), "its command 1 is of tick 31 and of tick 31")):
            entries = []
            for begin, name in zip((0, 5 * 10**9), names):
                for topic, messages in self.read(name).items():
                    for received, message in messages:
                        if hasattr(message, "header"):
                            message.header.stamp = time_of(received + begin)
                        if hasattr(message, "tick_stamp"):
                            message.tick_stamp = time_of(received + begin)
                        entries.append((topic, message, received + begin))
            self.write("twice.bag", *entries)
            self.assert_replay_refused("twice.bag", f"expected one run of /planar_chain, got a second one: {words} (the node was started again")

    def test_bags_that_tell_nothing_are_refused(self):
        self.bag("--duration", "0.1", name="bare.bag")
        self.assert_replay_refused("bare.bag", "expected a bag with commands")
        self.assert_replay_refused("scene.yaml", "expected a bag that can be read, got a file that is no bag")
        self.assert_replay_refused("none.bag", "expected a bag that can be read, got nothing: No such file")
        with open(self.path("cut.bag"), "wb") as file:
            file.write(self.bytes_of("bare.bag")[:9000])
        self.assert_replay_refused("cut.bag", "got one without an index;", "rosbag reindex " + self.path("cut.bag"))
        for wrong in (CommandTaken(number=1, kind=255), CommandTaken(number=1, kind=CommandTaken.LINK_FORCE),
                      CommandTaken(number=1, kind=CommandTaken.JOINT_TRAJECTORY),
                      CommandTaken(number=1, scene_time=math.nan), CommandTaken(number=1, scene_time=math.inf)):
            self.write_commands("in.bag", [wrong])
            self.assert_replay_refused("in.bag", "expected commands with what their kind needs", "number 1")
        for scene_time in (-1, 0.2):
            self.write_commands("in.bag", [CommandTaken(number=1, tick=31, scene_time=scene_time, joint_torques=[0, 0])])
            self.assert_replay_refused("in.bag", "expected commands of a node with ticks of 300 Hz", "tick 31")
        self.write_commands("in.bag", [CommandTaken(number=1, tick=1, joint_torques=[0, 0]),
                                       CommandTaken(number=2, tick=0, joint_torques=[0, 0])])
        self.assert_replay_refused("in.bag", "ticks that do not go back")
        self.write("in.bag", ("/planar_chain/commands_taken", JointTorque(), 1))
        self.assert_replay_refused("in.bag", "of type planar_chain/CommandTaken", "planar_chain/JointTorque")

    def test_commands_of_two_nodes_need_a_choice(self):
        left = CommandTaken(number=1, tick=31, scene_time=0.1, joint_torques=[1.0, 1.0])
        self.write("in.bag", ("/left/planar_chain/commands_taken", left, 1),
                   ("/right/planar_chain/commands_taken", self.COMMANDS[0], 2))
        self.assert_replay_refused("in.bag", "--node: expected one of /left/planar_chain, /right/planar_chain")
        self.assert_replay_refused("in.bag", '--node: expected one of /left/planar_chain, /right/planar_chain, got "/planar_chain"',
                                   more=("--node", "planar_chain"))
        topics = self.bag("--duration", "1", "--commands", self.path("in.bag"), "--node", "left/planar_chain")
        self.assertEqual([str(message) for _, message in topics["/left/planar_chain/commands_taken"]], [str(left)])

    def test_a_command_that_is_wrong_here_is_refused_and_said(self):
        self.write_commands("in.bag", [CommandTaken(number=1, tick=31, scene_time=0.1, joint_torques=[1, 1, 1])])
        result = self.run_tool("--duration", "1", "--commands", self.path("in.bag"))
        self.assertRegex(result.stdout, "0 taken, 1 refused; the first refusal, of command 1: joint_torques/data: expected 2 torques")
        self.assertEqual(result.returncode, 3, result.stderr)

        # Its warning does not go into the bag, which has the number of standard error where that is closed.
        command = BIN + "/simulate", self.path("scene.yaml"), "--duration", "1", "--commands", self.path("in.bag"), "--bag", self.path("out.bag")
        for closed in ("2>&-", ">&- 2>&-", "<&- >&- 2>&-"):
            self.assertIn(subprocess.run(["bash", "-c", f'"$0" "$@" {closed}', *command], stdout=subprocess.DEVNULL, check=False).returncode, (1, 3))
            self.assertEqual(len(self.read("out.bag")["/joint_states"]), 300)

    def test_a_time_far_ahead_of_its_tick_is_not_gone_to(self):
        self.write_commands("in.bag", [CommandTaken(number=1, tick=1, kind=CommandTaken.RESET), CommandTaken(
            number=2, tick=2, scene_time=1e9, kind=CommandTaken.SET_STATE, q=[0, 0], qd=[0, 0])])
        result = self.run_tool("--duration", "0.1", "--commands", self.path("in.bag"), "--most-steps", "20000")
        self.assertEqual((result.returncode, result.stderr), (
            0, "simulate: at 1000000000 s the node had failed, and command 2 came; this run did not fail\n"))

    def test_the_bag_of_commands_is_not_written_over(self):
        self.write_commands("in.bag", self.COMMANDS)
        before = self.bytes_of("in.bag")
        for option in ("--bag", "--csv"):
            self.assert_refused(
                self.run_tool("--duration", "1", "--commands", self.path("in.bag"), option, self.path("in.bag")), option)
        self.assertEqual(self.bytes_of("in.bag"), before)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    BIN = sys.argv.pop(1)
    unittest.main()
