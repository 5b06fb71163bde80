#!/usr/bin/python3
"""plot: what it reads from CSV and bag is what simulate wrote; what it draws over time; what it refuses. plot_strobe_test.py: --strobe.

    plot_test.py BIN [unittest options]        BIN: the folder that holds simulate, equations and plot
"""

import os
import re
import shutil
import subprocess
import unittest
import xml.etree.ElementTree

import numpy as np
import rosbag
import rospy
from planar_chain.msg import CommandTaken, JointTorque, SimStatus
from sensor_msgs.msg import JointState

from plot_tool import BIN, JOINTS, SCENE, SCENES, Body, PlotTool, plot, plot_panels, plot_read, plot_runs


class Plot(PlotTool):
    @unittest.skipUnless(os.path.exists("/dev/full"), "no /dev/full")
    def test_output_that_cannot_be_written_fails(self):
        self.simulate("--csv", self.path("run.csv"))
        with open("/dev/full", "w", encoding="ascii") as full:
            run = subprocess.run([os.path.join(BIN, "plot"), self.path("run.csv")], stdout=full, stderr=subprocess.PIPE,
                                 universal_newlines=True, check=False)
        self.assertEqual((run.returncode, run.stderr),
                         (1, "plot: cannot write standard output: No space left on device\n"))
        os.symlink("/dev/full", self.path("full.svg"))
        run = self.run_tool("plot", self.path("run.csv"), "--output", self.path("full.svg"))
        self.assertEqual((run.returncode, run.stderr), (1, f"plot: cannot write {self.path('full.svg')}: No space left on device\n"))

    def test_csv_and_bag_are_read_as_they_were_written(self):
        table, bag = self.path("run.csv"), self.path("run.bag")
        self.simulate("--rate", "100", "--csv", table, "--bag", bag)
        read, recorded = plot.read_csv(table), plot.read_bag(bag, None)
        rows = np.loadtxt(table, delimiter=",", skiprows=1)
        self.assertEqual((read.joints, recorded.joints), (JOINTS, JOINTS))
        np.testing.assert_array_equal(np.column_stack([read.t, read.q, read.qd]), rows[:, :-1])
        np.testing.assert_array_equal(read.energy[1]["T + V, less that of the start"], rows[:, -1] - rows[0, -1])

        # The bag has that motion at its own rate.
        shift = recorded.t + 0.01 * np.argmin(abs(rows[:, 1] - recorded.q[0, 0]))
        for j in range(3):
            np.testing.assert_allclose(np.interp(shift, rows[:, 0], rows[:, 1 + j]), recorded.q[:, j], atol=2e-2)
        with rosbag.Bag(bag) as file:
            efforts = [state.effort for _, state, _ in file.read_messages("/joint_states")]
        np.testing.assert_array_equal(recorded.effort, efforts)
        t, parts = recorded.energy
        total = parts["T"] + parts["V"] - parts["supplied"] + parts["dissipated"]
        np.testing.assert_allclose(total - recorded.balance[1], rows[0, -1], rtol=1e-12)
        self.assertEqual(len(t), len(recorded.error[1]))

    def test_every_panel_is_drawn_and_names_what_it_shows(self):
        bag, picture = self.path("run.bag"), self.path("run.svg")
        self.simulate("--bag", bag)
        for more in ([], ["--dark", "--panels", *plot.NAMES], ["--joints", "hand_pin"]):
            run = self.run_tool("plot", bag, "--output", picture, *more)
            self.assertEqual((run.returncode, run.stdout), (0, f"written to {picture}\n"), run.stderr)
            # Text is drawn as outlines; matplotlib notes it in comments.
            with open(picture, encoding="utf-8") as file:
                text = file.read()
            for label in ("angle q (rad)", "torque τ (N m)", "energy (J)", "T, kinetic", "V, potential", "phase portrait", "hand_pin"):
                self.assertTrue(label in text, label)
            for label, there in (("energy imbalance", "--panels" in more), ("(tolerances)", "--panels" in more), ("elbow_pin", "--joints" not in more)):
                self.assertEqual(label in text, there, label)
            xml.etree.ElementTree.parse(picture)

    def test_an_encoder_is_nobodys_joint_states(self):
        scene, bag = self.path("sensed.yaml"), self.path("sensed.bag")
        with open(os.path.join(SCENES, "cart_pole.yaml"), encoding="utf-8") as file:
            text = file.read()
        with open(scene, "w", encoding="utf-8") as file:
            file.write(text + "\nsensors: {enc: {joints: all}, imu: {link: pole}}\n")
        run = self.run_tool("simulate", scene, "--duration", "1", "--bag", bag)
        self.assertEqual(run.returncode, 0, run.stderr)
        with rosbag.Bag(bag) as file:
            self.assertGreater(file.get_message_count("/planar_chain/enc"), 10)
            states = file.get_message_count("/joint_states")
        for node in (None, "/planar_chain"):
            motion = plot.read_bag(bag, node)
            self.assertEqual((motion.joints, len(motion.t), motion.events), (["cart_joint", "pole_joint"], states, {}))

    # ---- What interrupts a motion ----

    def interrupted(self):
        """A bag of 200 ticks at 100 Hz: a pause of a second before tick 101, a reset at 151, a set_state at 181."""
        path = self.path("interrupted.bag")
        with rosbag.Bag(path, "w") as bag:
            def write(topic, message, stamp):
                message.header.stamp = rospy.Time.from_sec(stamp)
                bag.write(topic, message, message.header.stamp)

            def status(stamp, tick, paused=False):
                write("/planar_chain/status", SimStatus(
                    tick=tick, tick_stamp=rospy.Time.from_sec(stamp_of(tick)), paused=paused, kinetic=tick,
                    scene_time=0.01 * (tick - 151 if tick >= 151 else tick - 1),
                    standstill="paused" if paused else ""), stamp)

            def stamp_of(tick):
                return 50 + 0.01 * tick + (1 if tick > 100 else 0)

            for tick in range(1, 201):
                angle = 3 + 0.02 * tick - (4 if tick > 150 else 0) - (2 if tick > 180 else 0)
                write("/joint_states", JointState(name=["a"], position=[angle], velocity=[2], effort=[0]), stamp_of(tick))
                if tick % 10 == 5:
                    status(stamp_of(tick) + 0.001, tick)
            for stamp in (51.2, 51.7):
                status(stamp, 100, True)
            for tick, kind in ((151, CommandTaken.RESET), (160, CommandTaken.JOINT_TORQUE), (181, CommandTaken.SET_STATE)):
                bag.write("/planar_chain/commands_taken", CommandTaken(tick=tick, kind=kind), rospy.Time(51))
        return path

    def test_lines_are_broken_where_the_motion_is(self):
        motion = plot.read_bag(self.interrupted(), None)
        self.assertEqual(motion.events, {100: "pause", 150: "reset", 180: "set_state"})
        t, q, qd, effort = motion.curves(0)
        self.assertEqual(list(np.flatnonzero(np.isnan(q))), [100, 151, 182])
        for curve in (t, qd, effort):
            np.testing.assert_array_equal(np.isnan(curve), np.isnan(q))
        np.testing.assert_array_equal(q[~np.isnan(q)], motion.q[:, 0])
        # No stroke is steeper than the rate, 0.02 rad a tick.
        self.assertLess(np.nanmax(abs(np.diff(q))), 0.021)
        # What status says is broken at the same places; what it says in the pause is no motion.
        t, kinetic = motion.broken(*[motion.energy[0], motion.energy[1]["T"]])
        self.assertEqual([(kinetic[k - 1], kinetic[k + 1]) for k in np.flatnonzero(np.isnan(kinetic))],
                         [(95, 105), (145, 155), (175, 185)])

    def test_a_reset_is_seen_without_commands_taken(self):
        states = 50 + 0.01 * np.arange(1, 201)
        statuses = [SimStatus(tick=tick, tick_stamp=rospy.Time.from_sec(states[tick - 1]), scene_time=scene_time)
                    for tick, scene_time in ((60, 0.6), (140, 1.4), (175, 0.25))]
        self.assertEqual(plot_read.events_of(states, statuses, []), {149: "reset"})
        self.assertEqual(plot_read.events_of(states, statuses[:2], []), {})

    def test_a_settle_is_no_reset(self):
        # It adds a tick, but no time of the scene.
        states = 50 + 0.01 * np.arange(1, 201)
        statuses = [SimStatus(tick=tick, tick_stamp=rospy.Time.from_sec(states[tick - 1]),
                              scene_time=0.01 * (tick - 2 if tick >= 40 else tick - 1)) for tick in range(5, 200, 10)]
        self.assertEqual(plot_read.events_of(states, statuses, [CommandTaken(tick=40, kind=CommandTaken.SETTLE)]), {39: "settle"})
        for seen in (statuses, statuses[4:]):
            self.assertEqual(plot_read.events_of(states, seen, []), {})

    def test_wrapped_angles_stay_within_a_turn(self):
        motion = plot.read_bag(self.interrupted(), None)
        _, q, _, _ = motion.curves(0, wrap=True)
        there = q[~np.isnan(q)]
        self.assertTrue(np.all((there > -np.pi) & (there <= np.pi)))
        np.testing.assert_allclose(np.exp(1j * there), np.exp(1j * motion.q[:, 0]), atol=1e-12)
        self.assertLess(np.nanmax(abs(np.diff(q))), 0.021)
        motion.q = np.array([[np.pi], [-np.pi], [3 * np.pi]])
        motion.t, motion.qd, motion.effort, motion.events = np.arange(3.0), motion.q, None, {}
        np.testing.assert_array_equal(motion.curves(0, wrap=True)[1], [np.pi] * 3)

    def test_events_are_named_on_the_picture(self):
        bag, picture = self.interrupted(), self.path("run.svg")
        run = self.run_tool("plot", bag, "--wrap", "--output", picture)
        self.assertEqual(run.returncode, 0, run.stderr)
        with open(picture, encoding="utf-8") as file:
            text = file.read()
        for name in ("pause", "reset", "set_state"):
            self.assertIn(f"<!-- {name} -->", text)

    def test_the_tip_does_not_move_in_a_pause(self):
        motion = plot.read_bag(self.interrupted(), None)
        joint = {"name": "a", "lower": None, "upper": None}
        body = Body({"links": [{"name": "a", "pin": [1, 0], "com": [1, 0], "joint": joint}], "gravity": [0, 0]})
        q = motion.track(body).at(np.array([motion.t[99], motion.t[99] + 0.6, motion.t[100]])).q
        self.assertEqual(q.ravel().tolist(), motion.q[[99, 99, 100], 0].tolist())

    def test_formats_and_the_usual_name(self):
        table = self.path("run.csv")
        self.simulate("--csv", table)
        for output, mark in ((None, b"\x89PNG"), (self.path("a.pdf"), b"%PDF"), (self.path("a.png"), b"\x89PNG")):
            run = self.run_tool("plot", table, *(["--output", output] if output else []))
            self.assertEqual(run.returncode, 0, run.stderr)
            with open(output or table + ".png", "rb") as file:
                self.assertTrue(file.read().startswith(mark))

    def test_many_joints_are_some_of_them_along_the_chain(self):
        motion = plot_read.Motion([f"j{k}" for k in range(100)], None, None, None)
        columns = plot.chosen(motion, [])
        self.assertEqual((len(columns), columns[0], columns[-1]), (plot.MOST_JOINTS, 0, 99))
        self.assertEqual(plot.chosen(motion, ["j7", "j3"]), [7, 3])

    @staticmethod
    def turning(torque=0.0):
        """A joint that turns at 2 rad/s for 5 s; errors of 1e-3, but for two."""
        t = np.linspace(0, 5, 101)
        motion = plot_read.Motion(["a"], t, 2 * t[:, np.newaxis], np.full((101, 1), 2.0), np.full((101, 1), torque))
        motion.prismatic = []
        motion.energy = t, {"T": np.full(101, 8.0), "V": 0 * t, "supplied": 0 * t, "dissipated": 1e-8 * t}
        motion.balance, motion.error = (t, 1e-15 * np.sin(9 * t)), (t, np.where(t == 0, 0, np.where(t == 2.5, 1e-15, 1e-3)))
        return motion

    def test_panels_show_what_there_is(self):
        usual = [axes.get_ylabel() for axes in plot.draw(self.turning(), [0], "", False).axes if axes.get_ylabel()]
        self.assertEqual(usual, ["angle q (rad)", "rate q̇ (rad/s)", "energy (J)", "rate q̇ (rad/s)"])  # the last is the portrait's
        figure = plot.draw(self.turning(), [0], "turning", False, plot.NAMES)
        figure.canvas.draw()
        panels = {axes.get_ylabel().replace("\n", " "): axes for axes in reversed(figure.axes) if axes.get_ylabel()}
        self.assertEqual(list(reversed(panels)), ["angle q (rad)", "energy (J)", "energy imbalance (1e-12 J)", "error estimate (tolerances)",
                                                  "rate q̇ (rad/s)"])
        self.assertIn("torque τ (N m)", [axes.get_ylabel() for axes in plot.draw(self.turning(3.0), [0], "", False).axes])
        self.assertEqual([line.get_label() for line in panels["energy (J)"].lines], ["T, kinetic", "dissipated"])
        self.assertEqual([axes.yaxis.get_offset_text().get_text() for axes in panels.values()], [""] * 5)
        # What does not move is no noise: the imbalance is 1e-16 of the energy.
        low, high = panels["energy imbalance (1e-12 J)"].get_ylim()
        self.assertGreater(high - low, 1e-12)
        self.assertGreater(panels["error estimate (tolerances)"].get_ylim()[0], 1e-4)
        motion = self.turning()
        motion.error, motion.rounding = (motion.t, np.where(motion.t < 4, 1e-49, 1e-4)), 1e-7
        low, high = next(axes for axes in plot.draw(motion, [0], "", False, ["error"]).axes if axes.get_ylabel().startswith("error")).get_ylim()
        self.assertTrue(1e-8 < low < 1e-7 and 1e-4 < high < 1e-3, (low, high))
        # Numbers have the sign of minus that matplotlib gives to others.
        ticks = [label.get_text() for axes in panels.values() for label in axes.get_yticklabels()]
        self.assertTrue(any("\N{MINUS SIGN}" in tick for tick in ticks) and not any("-" in tick for tick in ticks if "mathdefault" not in tick), ticks)
        # Rows have equal gaps.
        edges = [axes.get_position() for axes in figure.axes if axes.get_ylabel() and axes.get_position().x0 < 0.3]
        self.assertEqual(len(edges), 5)
        gaps = [above.y0 - below.y1 for above, below in zip(edges, edges[1:])]
        self.assertLess(max(gaps), 1.5 * min(gaps))

    def test_prismatic_joints_have_units_of_their_own(self):
        scene, bag, table, picture = os.path.join(SCENES, "cart_pole.yaml"), self.path("run.bag"), self.path("run.csv"), self.path("run.svg")
        run = self.run_tool("simulate", scene, "--duration", "2", "--bag", bag, "--csv", table)
        self.assertEqual(run.returncode, 0, run.stderr)
        along, turn, either = ("position q (m)", "speed q̇ (m/s)"), ("angle q (rad)", "rate q̇ (rad/s)"), ("q (rad or m)", "rate q̇ (rad/s or m/s)")
        for arguments, labels, others in (([bag], along + turn, either), ([table], either, along + turn),
                                          ([table, "--scene", scene], along + turn, either),
                                          ([bag, "--joints", "cart_joint"], along, turn + either),
                                          ([bag, "--joints", "pole_joint"], turn, along + either)):
            run = self.run_tool("plot", *arguments, "--output", picture)
            self.assertEqual(run.returncode, 0, run.stderr)
            with open(picture, encoding="utf-8") as file:
                found = re.findall("<!-- (.*) -->", file.read())
            self.assertEqual([label in found for label in labels + others], [True] * len(labels) + [False] * len(others), arguments)
        unknown = plot.draw(plot_read.Motion(list("abc"), np.arange(2.0), np.ones((2, 3)), np.ones((2, 3))), [2], "", False)
        self.assertEqual(unknown.axes[0].get_ylabel(), "q (rad or m)")
        # A position is no angle: it is not wrapped.
        motion = plot.read_bag(bag, None)
        motion.q[:, 0] += 10
        np.testing.assert_array_equal(motion.curves(0, wrap=True)[1], motion.q[:, 0])

    def test_a_number_of_a_prismatic_joint_has_its_unit(self):
        for path, units in (("links/a/mass", ["kg"] * 3), ("links/a/joint/damping", ["N m s/rad", "N s/m", "N m s/rad or N s/m"]),
                            ("links/a/joint/rotor_inertia", ["kg m²", "kg", "kg m² or kg"]), ("links/a/inertia", ["kg m²"] * 3),
                            ("links/a/initial/velocity", ["rad/s", "m/s", "rad/s or m/s"]), ("links/a/initial/position", ["m"] * 3)):
            self.assertEqual([plot_runs.with_unit(path, links) for links in (["b"], ["a"], None)], [f"{path} ({unit})" for unit in units])

    def test_no_more_than_six_panels_unless_asked_for(self):
        for present, portraits, names, left_out in (
                (["q", "rate", "torque", "energy", "imbalance"], 1, ["q", "rate", "torque", "energy", "phase"], []),
                (["q", "q", "rate", "rate", "torque", "energy"], 2, ["q", "torque", "energy", "phase"], ["rate"]),
                (["q", "q", "rate", "rate", "torque", "torque", "energy"], 2, ["q", "torque", "phase"], ["rate", "energy"])):
            self.assertEqual(plot.usual(present, portraits), (names, left_out))

    def test_numbers_at_axes_have_the_digits_that_tell_them_apart(self):
        for locs, power, texts in (([1.3257e-5, 1.3258e-5, 1.3259e-5], -5, ["1.3257", "1.3258", "1.3259"]), ([0, 0.25, 0.5], 0, ["0.00", "0.25", "0.50"]),
                                   ([-2e6, 0, 2e6], 6, ["\N{MINUS SIGN}2", "0", "2"]), ([3.0], 0, ["3"])):
            formatter = plot_panels.Plain(power)
            formatter.set_locs(locs)
            self.assertEqual([formatter(x) for x in locs], texts)
        motion = self.turning()
        motion.q = 1.3257e-5 + 1e-7 * np.sin(motion.t)[:, np.newaxis]
        figure = plot.draw(motion, [0], "", False)
        figure.canvas.draw()
        for axis in [axis for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)]:
            self.assertEqual(axis.get_offset_text().get_text(), "")

    def test_names_that_would_overlap_stand_above_one_another(self):
        motion = self.turning()
        motion.events = {50: "set_state", 51: "reset", 52: "pause", 90: "fault"}
        figure = plot.draw(motion, [0, 0, 0], "", False)
        figure.canvas.draw()
        boxes = [text.get_window_extent() for axes in figure.axes for text in axes.texts]
        self.assertEqual(len(boxes), 4)
        boxes += [axes.get_legend().get_window_extent() for axes in figure.axes if axes.get_legend()] + [figure._suptitle.get_window_extent()]
        for k, box in enumerate(boxes):
            self.assertFalse(any(box.overlaps(other) for other in boxes[:k]), k)

    def test_commands_references_and_sensors_stand_beside_the_states(self):
        path = self.path("signals.bag")
        with rosbag.Bag(path, "w") as bag:
            def write(topic, message, stamp):
                message.header.stamp = rospy.Time.from_sec(stamp)
                bag.write(topic, message, message.header.stamp)

            for tick in range(1, 101):
                write("/joint_states", JointState(name=["a", "b"], position=[1, 2], velocity=[0, 0], effort=[0, 0]), 50 + 0.01 * tick)
                if tick % 10 == 0:
                    write("/planar_chain/status", SimStatus(tick=tick, tick_stamp=rospy.Time.from_sec(50 + 0.01 * tick), scene_time=0.01 * tick),
                          50 + 0.01 * tick)
                    write("/planar_chain/encoder", JointState(name=["b"], position=[tick]), 50 + 0.01 * tick)
                    write("/wanted", JointState(name=["a", "elsewhere"], position=[0.5, 9], velocity=[3, 9]), 50 + 0.01 * tick)
            for number, (tick, time, more) in enumerate((
                    (11, 0.1, {"kind": CommandTaken.JOINT_TORQUES, "joint_torques": [2, 0]}),
                    (21, 0.2, {"kind": CommandTaken.JOINT_TORQUE, "start": 0.3, "joint_torque": [JointTorque(joint="a", torque=5.0, duration=0.2)]}),
                    (81, 0.8, {"kind": CommandTaken.CLEAR_COMMANDS}))):
                bag.write("/planar_chain/commands_taken", CommandTaken(number=number, tick=tick, scene_time=time, **more), rospy.Time.from_sec(50 + time))
        motion = plot.read_bag(path, None)
        np.testing.assert_allclose(motion.scene_time, 0.01 * np.arange(1, 101), atol=1e-9)
        found = {(each.kind, each.joint, each.panel): each for each in motion.signals}
        self.assertEqual(set(found), {("command", "a", 3), ("sensor", "b", 1), ("reference", "a", 1), ("reference", "a", 2)})
        self.assertEqual(found["sensor", "b", 1].values.tolist(), list(range(10, 101, 10)))
        self.assertEqual(found["reference", "a", 2].values.tolist(), [3] * 10)
        # Held from 0.1 s on (0.09 s after the first state), 5 N m more from 0.3 to 0.5 s, nothing from 0.8 s on.
        command = found["command", "a", 3]
        for t, torque in ((0.05, 0), (0.15, 2), (0.25, 2), (0.35, 7), (0.55, 2), (0.75, 2), (0.85, 0)):
            self.assertAlmostEqual(np.interp(t, command.t, command.values), torque, msg=str(t))
        figure = plot.draw(motion, [0, 1], "", False)
        self.assertEqual([text.get_text() for text in figure.axes[-1].get_legend().get_texts()], ["a", "b", "command", "reference", "sensor"])
        motion.cut(0.2, 0.4)
        command = next(each for each in motion.signals if each.kind == "command")
        self.assertEqual((command.t[0], command.values[0], len(motion.t), motion.signals[-1].t.max() <= 0.4), (0.2, 2.0, 21, True))

    def test_from_and_to_cut_what_is_drawn(self):
        motion = plot.read_bag(self.interrupted(), None)
        motion.cut(0.5, 2.6)
        self.assertEqual(motion.events, {50: "pause", 100: "reset"})
        self.assertTrue(0.5 <= motion.t[0] and motion.t[-1] <= 2.6 and len(motion.q) == len(motion.t) and motion.energy[0][-1] <= 2.6)
        table = self.path("short.csv")
        with open(table, "w", encoding="utf-8") as file:
            file.write("t,q_a,qd_a,energy\n0,0,0,0\n1,0,0,0\n2,0,0,0\n")
        self.assertEqual(self.run_tool("plot", table, "--from", "0.5").returncode, 0)
        self.assertIn("--from and --to: expected two states of " + table + " or more between them, of 0 to 2 s, got 1.5 and 2 s",
                      self.refused(table, "--from", "1.5"))

    def test_a_phase_portrait_wraps_what_passes_half_a_turn(self):
        phase = next(axes for axes in plot.draw(self.turning(), [0], "turning", False).axes if axes.get_title())
        q = phase.lines[0].get_xdata()
        self.assertTrue(np.nanmax(abs(q)) <= np.pi and np.isnan(q).sum() == 2)
        np.testing.assert_allclose(np.sin(q[~np.isnan(q)]), np.sin(2 * np.linspace(0, 5, 101)), atol=1e-12)

    def test_a_phase_portrait_of_few_states_is_dots(self):
        t, motion = np.linspace(0, 5, 101), self.turning()
        for rate, is_line in ((2.0, True), (20.0, False)):
            motion.q = rate * t[:, np.newaxis]
            motion.qd = rate * (1 + 0.3 * np.sin(motion.q))
            phase = next(axes for axes in plot.draw(motion, [0], "", False).axes if axes.get_title())
            self.assertEqual(phase.lines[0].get_linestyle() == "-", is_line)
            self.assertEqual("dots: too few" in phase.get_title(), not is_line)
        # A joint at rest, up to noise, is a line.
        noise = 1e-17 * np.random.default_rng(1).normal(size=(2, 101))
        self.assertFalse(plot.is_coarse(*noise) or plot.is_coarse(1.0 + noise[0], noise[1]))

    def test_prismatic_joints_have_a_portrait_of_their_own_and_energies_colours(self):
        motion = plot_read.Motion(["a", "b"], np.linspace(0, 5, 101), np.tile(np.linspace(0, 5, 101), (2, 1)).T, np.ones((101, 2)))
        motion.energy = motion.t, {"T": np.ones(101), "V": np.ones(101)}
        for prismatic, labels in ((["a"], ["position q (m)", "angle q (rad)"]), ([], ["angle q (rad)"]), (None, ["q (rad or m)"])):
            motion.prismatic = prismatic
            figure = plot.draw(motion, [0, 1], "", False)
            phases = [axes for axes in figure.axes if axes.get_title()]
            self.assertEqual([axes.get_xlabel() for axes in phases], labels)
            joints = [line.get_color() for axes in phases for line in axes.lines if line.get_label() in "ab"]
            energy = next(axes for axes in figure.axes if axes.get_ylabel() == "energy (J)")
            self.assertEqual(len({*joints, *(line.get_color() for line in energy.lines)}), 4)
            self.assertEqual([text.get_text() for text in energy.get_legend().get_texts()], ["T, kinetic", "V, potential"])

    def test_many_runs_show_where_they_are_dense(self):
        def runs(count):
            x = np.random.default_rng(1).normal(size=(count, 2))
            return plot.Runs(["run", "links/a/mass", "loads/p/force/0", "t", "q_a", "qd_a", "reason"],
                             [[k, a, b, 1.0, a * b, 0.0, ""] for k, (a, b) in enumerate(x)])
        few, many = (plot.draw_runs(runs(count), [0], "", False, "b").axes for count in (100, 20000))
        # Points are coloured by the second number, above those over the second by the first.
        self.assertEqual([axes.get_xlabel() for axes in few], ["links/a/mass (kg)", "loads/p/force/0 (N)", "loads/p/force/0 (N)", "links/a/mass (kg)"])
        x, y = np.random.default_rng(1).normal(size=(100, 2)).T
        for axes, other in zip(few, (y, x)):
            np.testing.assert_array_equal(axes.collections[0].get_array(), other)
        cells = [axes.collections[0].get_array() for axes in many[:2]]
        self.assertEqual([each.sum() for each in cells], [20000, 20000])
        self.assertGreater(min(each.max() for each in cells), 50)
        self.assertEqual([axes.get_xlabel() for axes in many[2:]], ["runs in a cell"] * 2)
        # A grid has few values of each number: all its points are coloured.
        grid = plot.Runs(["run", "a", "b", "t", "q_a", "qd_a", "reason"], [[k, k % 60, k // 60, 1.0, k, 0.0, ""] for k in range(3000)])
        self.assertEqual([len(axes.collections[0].get_offsets()) for axes in plot.draw_runs(grid, [0], "", False, "b").axes[:2]], [3000, 3000])

    def test_refusals_say_what_was_expected_and_found(self):
        table = self.path("run.csv")
        self.simulate("--csv", table)
        self.assertIn("--joints: expected joints of shoulder_pin, elbow_pin, hand_pin, got knee",
                      self.refused(table, "--joints", "knee"))
        self.assertIn("ends in .png, .svg or .pdf, got a.gif", self.refused(table, "--output", "a.gif"))
        none = self.path("none.csv")
        self.assertEqual(self.refused(none), f"plot: {none}: expected a .csv or .bag that can be read, got nothing: No such file or directory\n")
        self.assertIn("--output: expected a file that can be written, got /none/a.png: No such", self.refused(table, "--output", "/none/a.png"))
        self.assertIn("got elbow (did you mean elbow_pin?)", self.refused(table, "--joints", "elbow"))
        for name in (table, SCENE):
            picture = self.path(os.path.basename(name) + ".png")
            os.symlink(name, picture)
            for strobe in (SCENE, "triple"):
                self.assertIn("--output: expected a file that is not another of the run's",
                              self.refused(table, "--strobe", strobe, "--output", picture))
        other = self.path("other.csv")
        for text, fault in (("", "got nothing"), ("a,b\n1,2\n", "got a, b"), ("t,q_a,qd_a,energy\n0,0,0,0\n", "got 1"),
                            ("t,q_a,qd_a,energy\n0,0,x,0\n", "expected 4 numbers, got could not convert string to float: 'x'"),
                            ("t,q_a,qd_a,energy\n0,0,0,0\n1,1_0,0,0\n", "row 2: expected 4 numbers, got could not convert string to float: '1_0'"),
                            ("t,q_a,qd_a,energy\n0,0,0,0\n1,0,0\n", "other.csv, row 2: expected 4 numbers, got 3 cells"),
                            ("t,q_a,qd_a,energy\n0,0,0,0\n1,0,0,0,0\n", "other.csv, row 2: expected 4 numbers, got 5 cells"),
                            ("t,q_a,qd_a,energy\n0,0,-2e307,0\n1,1,1e308,0\n", "other.csv, qd_a: expected numbers up to 1e+300, got -2e+307"),
                            ("t,q_a,qd_a,energy\n0,0,0,0\n1,inf,1,0\n", "other.csv, q_a: expected numbers up to 1e+300, got inf"),
                            ("run,links/a/mass,t,q_a,qd_a,reason\n0,1,1,1,1,\n1,1,1,1\n", "row 2: expected 5 numbers and a reason, got 4 cells"),
                            ("run,links/a/mass,t,q_a,qd_a,reason\n0,x,1,1,1,\n", "row 1: expected 5 numbers and a reason, got could not"),
                            ("run,links/a/mass,t,q_a,qd_a,reason\n0,1,1,1e308,1,\n", "other.csv, q_a: expected numbers up to 1e+300, got 1e+308"),
                            ("\ufefft,q_a,qd_a,energy\n0,0,0,0\n2,0,0,0\n1,0,0,0\n", "other.csv, row 3: expected a time after 2 s, got 1 s"),
                            ("t,q_a,qd_a,energy\n0,nan,0,0\n1,nan,0,0\n", "other.csv: expected angles, got nan alone"),
                            ("t,q_a,qd_a,energy\n0,0,0,0\n1,nan,0,0\n", "other.csv, row 2, q_a: expected a number, got nan"),
                            ("t,q_a,q_a,qd_a,qd_a,energy\n0,0,0,0,0,0\n1,0,0,0,0,0\n", "each once, got t, q_a, q_a,"),
                            ("run,t,q_a,qd_a,reason\n0,1,1,1,\n", "expected the columns t, q_"),
                            ("run,x,t,q_a,qd_a,reason\n0,1,nan,1,1,\n", "expected runs with finite times t, got none"),
                            ("run,x,t,q_a,qd_a,reason\n", "expected runs with finite times t, got none"),
                            ("run,t,reason\n0,1,\n", "expected the columns t, q_")):
            with open(other, "w", encoding="utf-8") as file:
                file.write(text)
            self.assertIn(fault, self.refused(other))
        with open(other, "w", encoding="utf-8") as file:
            file.write("t,q_a,qd_a,energy\n0,0,0,0\n1,0,0,0\n")
        self.assertIn("--scene: expected the scene of a, got that of shoulder_pin, elbow_pin, hand_pin", self.refused(other, "--scene", SCENE))
        self.assertIn("--output: expected a name that ends in", self.refused(other, "--output", ""))
        for more, fault in ((("--strobe", ""), 'plot: "": expected a file, or one of the scenes that ship'), (("--apart", "0"), "--at and --apart: expected --strobe SCENE beside them, got nothing"),
                            (("--strobe", SCENE, "--wrap", "--joints", "a"), "--strobe: expected no --joints and no --wrap beside it, got both"),
                            (("--strobe", SCENE, "--at", "1_0", "2"), "argument --at: invalid float value: '1_0'")):
            self.assertIn(fault, self.refused(other, *more))
        self.assertIn("--node: expected a bag beside it, got " + other, self.refused(other, "--node", "left"))
        self.assertIn("got nothing: Is a directory", self.refused(self.folder))
        for data in (b"\xff\xfe\x00", b"\0" * 5000, b"\x80" * 5000, b"t,q_a,qd_a,energy\n0,0,0,\xc3\x28\n"):
            with open(other, "wb") as file:
                file.write(data)
            self.assertRegex(self.refused(other), r"^plot: .*other.csv: expected a table in text, got other bytes \(.*\)\n$")
        for scale in (1e300, 1e-300):
            with open(other, "w", encoding="utf-8") as file:
                file.writelines(["t,q_a,qd_a,energy\n", *(f"{k},{scale * (-1) ** k},{-scale * (-1) ** k},{scale * k}\n" for k in (0, 1))])
            self.assertEqual(self.run_tool("plot", other).returncode, 0)
        bag = self.path("no.bag")
        with open(bag, "w", encoding="utf-8") as file:
            file.write("no bag")
        self.assertIn("expected a bag that can be read", self.refused(bag))

    def test_dollars_are_no_formula_and_what_is_nan_throughout_is_left_out(self):
        table, picture = self.path("$a_{$.csv"), self.path("run.svg")
        with open(table, "w", encoding="utf-8") as file:
            file.write("t,q_$b_{$,qd_$b_{$,energy\n0,0,0,nan\n1,1,0,nan\n")
        run = self.run_tool("plot", table, "--output", picture)
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        with open(picture, encoding="utf-8") as file:
            text = file.read()
        self.assertTrue("<!-- $a_{$.csv -->" in text and "<!-- $b_{$ -->" in text and "start (J)" not in text)

    def test_a_table_that_may_be_cut_is_said(self):
        table = self.path("cut.csv")
        for end, note in (("", f"plot: note: {table}: the last line has no end: its last number may be cut off\n"), ("\n", ""), ("\r\n", "")):
            with open(table, "w", encoding="utf-8", newline="") as file:
                file.write("t,q_a,qd_a,energy\n0,0,0,0\n1,0,0,0.12" + end)
            run = self.run_tool("plot", table)
            self.assertEqual((run.returncode, run.stderr), (0, note))

    def test_after_a_clock_that_went_back_the_rest_is_drawn(self):
        # Ten states a second, from 5 s to 6.9 s, then from 6 s on. rosbag sorts by receipt.
        for receipts in (lambda k, stamp: rospy.Time(10 + k), lambda k, stamp: stamp):
            with rosbag.Bag(self.path("back.bag"), "w") as bag:
                for k in range(50):
                    stamp = rospy.Time.from_sec(5 + k / 10 if k < 20 else 4 + k / 10)
                    for topic, message in (("/joint_states", JointState(name=["a"], position=[k], velocity=[0])),
                                           ("/planar_chain/status", SimStatus(tick=k, tick_stamp=stamp, kinetic=k))):
                        message.header.stamp, message.header.seq = stamp, k
                        bag.write(topic, message, receipts(k, stamp))
            run = self.run_tool("plot", self.path("back.bag"))
            self.assertEqual((run.returncode, run.stderr), (
                0, f"plot: note: {self.path('back.bag')}: the clock went back; only the 30 states after that are drawn, of 50\n"))
            motion = plot.read_bag(self.path("back.bag"), None)
            self.assertEqual((motion.q[:, 0].tolist(), motion.energy[1]["T"].tolist()), (list(range(20, 50)),) * 2)
            np.testing.assert_allclose(motion.t, np.arange(30) / 10, atol=1e-9)

    def test_states_of_another_robot(self):
        for efforts, names, drawn in (([], ["a"], True), ([1.0], ["a"], True), ([1.0, 2.0], ["a"], False), (None, ["a"], False), ([], [], False)):
            with rosbag.Bag(self.path("robot.bag"), "w") as bag:
                for k in range(1, 9):
                    state = JointState(name=names, position=[0.1 * k] * len(names), velocity=[0.0] * len(names),
                                       effort=[0.0] * (k % 2) if efforts is None else efforts)
                    state.header.stamp = rospy.Time(k)
                    bag.write("/joint_states", state, rospy.Time(k))
            if drawn:
                self.assertEqual(self.run_tool("plot", self.path("robot.bag")).returncode, 0)
            else:
                self.assertIn("expected an angle, a rate and perhaps an effort of the same joints in each state", self.refused(self.path("robot.bag")))

    def test_a_bag_whose_recorder_was_killed(self):
        self.simulate("--bag", self.path("whole.bag"))
        cut, empty = self.path("cut.bag.active"), self.path("empty.bag")
        with rosbag.Bag(self.path("whole.bag")) as whole, rosbag.Bag(self.path("open.bag"), "w", chunk_threshold=10000) as recorder:
            for topic, message, received in whole.read_messages():
                recorder.write(topic, message, received)
            shutil.copy(recorder.filename, cut)
        self.assertEqual(self.refused(cut), f"plot: {cut}: expected a bag that can be read, got one without an index; its recorder still "
                         f"runs or was killed (to mend it: rosbag reindex {cut})\n")
        subprocess.run(["rosbag", "reindex", "--quiet", cut], check=True, timeout=60)
        self.assertEqual(self.run_tool("plot", cut).returncode, 0)
        with rosbag.Bag(empty, "w"):
            pass
        self.assertIn("got a bag without messages", self.refused(empty))


if __name__ == "__main__":
    unittest.main()
