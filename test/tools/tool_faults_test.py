#!/usr/bin/python3
"""Every tool says in words what stops it: bags that are damaged or have other types, standard output that is full, Ctrl-C.

    tool_faults_test.py BIN [unittest options]        BIN: the folder that holds the tools
"""
import math
import os
import signal
import subprocess
import unittest
from unittest import mock

import genpy
import rosbag
from planar_chain.msg import CommandTaken, JointTorque, LinkStates, SimStatus
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from plot_tool import BIN, JOINTS, SCENE, PlotTool
import replay  # of src/tools, where plot_tool finds it

MARK = "mark_me"
FIT = "fit", SCENE, "--vary", "links/hand/mass", "--data"
REPLAY = "simulate", SCENE, "--commands"


def there(*tools):
    return [tool for tool in tools if os.path.exists(os.path.join(BIN, tool[0]))]


class Faults(PlotTool):
    def bag(self, name, *entries, joints=("pin",)):
        states = [JointState(name=joints, position=[0.0] * len(joints), velocity=[0.0] * len(joints)) for _ in range(2)]
        states[1].header.stamp = genpy.Time(1)
        with rosbag.Bag(self.path(name), "w") as file:
            for k, (each, what) in enumerate((*(("/joint_states", state) for state in states), ("/planar_chain/status", SimStatus()), *entries)):
                file.write(each, what, genpy.Time(1, k))
        return self.path(name)

    def damaged(self, *given, **more):
        """A bag where the length before each MARK is too large."""
        bag = self.bag(*given, **more)
        with open(bag, "r+b") as file:
            before = b"\x07\0%c\0" + MARK.encode()
            data = file.read()
            self.assertIn(before % 0, data)
            file.seek(0)
            file.write(data.replace(before % 0, before % 255))
        return bag

    def assert_all_refuse(self, bag, tools, words):
        for tool in there(*tools):
            run = self.run_tool(*tool, bag)
            self.assertEqual((run.returncode, run.stdout), (2, ""), run.stderr)
            self.assertRegex(run.stderr, f"^[^\n]*{bag}: {words}\n$")

    def test_another_type_is_named(self):
        self.assert_all_refuse(self.bag("taken.bag", ("/planar_chain/commands_taken", String())), (("plot",), FIT, REPLAY),
                               "expected /planar_chain/commands_taken of type planar_chain/CommandTaken.*, got std_msgs/String")
        self.assert_all_refuse(self.bag("scene.bag", ("/planar_chain/scene", SimStatus())), (("plot",), ("show",)),
                               "expected /planar_chain/scene of type std_msgs/String, got planar_chain/SimStatus")

    def test_a_node_that_is_not_in_the_bag_is_refused(self):
        taken = CommandTaken(number=1, tick=1, joint_torques=[0, 0, 0])
        bag = self.bag("nodes.bag", ("/left/planar_chain/status", SimStatus()), *((f"{name}/commands_taken", taken) for name in (
            "/planar_chain", "/left/planar_chain")))
        for tool in there(("plot",), FIT, REPLAY):
            for node in ("/x", "planar", ""):
                run = self.run_tool(*tool, bag, "--node", node)
                self.assertEqual((run.returncode, run.stdout), (2, ""), run.stderr)
                self.assertRegex(run.stderr, "--node: expected (a node of .*nodes.bag \\(|one of )/left/planar_chain, /planar_chain.*, got [^\n]*\n$"
                                 if node or tool[0] != "simulate" else '--node: expected the name of a node, such as .*, got ""\n$')

    def test_a_damaged_message_is_said(self):
        command = CommandTaken(number=1, kind=CommandTaken.JOINT_TORQUE, joint_torque=[JointTorque(joint=MARK)])
        for bag, tools in ((self.damaged("state.bag", joints=(MARK,)), (("plot",), FIT)),
                           (self.damaged("command.bag", ("/planar_chain/commands_taken", command)), (("plot",), FIT, REPLAY))):
            self.assert_all_refuse(bag, tools, r"expected a bag that can be read, got a damaged one \(.*\)")

    def test_lengths_that_crash_rosbags_reader_are_said(self):
        whole = self.bag("whole.bag", ("/planar_chain/commands_taken", CommandTaken(number=1, tick=1, joint_torques=[0.0] * 3)), joints=JOINTS)
        with open(whole, "rb") as file:
            data = file.read()
        index = data.index(b"op=\x04")
        bag = self.path("flipped.bag")
        # Bits of the index, at which the reader of C++ takes memory of others, or aborts; and of the length of a list, which takes all memory.
        for place, bit, tools in ((58, 7, (("plot",), FIT, REPLAY)), *((*flip, (REPLAY,)) for flip in (
                (19, 3), (31, 3), (70, 3), (74, 7), (77, 3), (85, 3), (-33, 7)))):
            with open(bag, "wb") as file:
                file.write(data[:index + place] + bytes([data[index + place] ^ 1 << bit]) + data[index + place + 1:])
            self.assert_all_refuse(bag, tools, r"expected a bag that can be read, got a damaged one \(.*\)")

    def test_a_recording_that_ends_rosbag_play_is_said(self):
        with open(self.path("rosbag"), "w", encoding="ascii") as file:
            file.write("#!/bin/sh\nexit 245\n")  # as after a segmentation fault
        os.chmod(self.path("rosbag"), 0o755)
        master = mock.Mock(getSystemState=lambda: ([], [("/tf", ["/rviz"])], []))
        play = replay.Play(master, "one.bag", ["/clock"], [])
        with mock.patch.dict(os.environ, {"PATH": self.folder + ":" + os.environ["PATH"]}):
            play.maybe_start()
        play._process.wait(60)  # pylint: disable=protected-access
        self.assertRaisesRegex(replay.NoBag, "^one.bag: expected a bag that rosbag play can play, got its exit status 245$", play.maybe_start)

    def test_messages_without_what_they_need(self):
        for command in (CommandTaken(number=1, kind=255), CommandTaken(number=1, kind=CommandTaken.LINK_FORCE),
                        CommandTaken(number=1, scene_time=math.inf, joint_torques=[0, 0, 0])):
            self.assert_all_refuse(self.bag("bare.bag", ("/planar_chain/commands_taken", command), joints=JOINTS), (FIT, REPLAY),
                                   f"expected commands with what their kind needs, got number 1 of kind {command.kind}")
        bag = self.bag("states.bag", ("/planar_chain/link_states", LinkStates()), ("/planar_chain/status", SimStatus(scene_time=math.inf)))
        run = self.run_tool("plot", bag)
        self.assertEqual((run.returncode, run.stderr), (0, ""))

    def test_a_damaged_definition_is_said(self):
        for tools, topic, was, is_now in (
                ((("plot",), FIT), "/joint_states", b"float64[] position", b"float64[] pos1tion"), ((("plot",), FIT), "/joint_states", b"time stamp", b"time_stamp"),
                ((("plot",), FIT), "/planar_chain/status", b"float64 tolerance", b"float64 tolerancf")):
            bag = self.bag("text.bag")
            with open(bag, "r+b") as file:
                data = file.read()
                self.assertIn(was, data)
                file.seek(0)
                file.write(data.replace(was, is_now))
            self.assert_all_refuse(bag, tools, f"expected {topic} of type .* as this version defines it, got a definition that is damaged.*")

    def test_a_damaged_scene_is_said(self):
        bag = self.bag("scene.bag", ("/planar_chain/scene", String("chain: [a")),
                       ("/planar_chain/commands_taken", CommandTaken(number=1, tick=1, joint_torques=[0, 0, 0])))
        self.assert_all_refuse(bag, (("plot",),), "the scene is refused:\nline 1: scene: expected YAML, got .*")
        self.assert_all_refuse(bag, (REPLAY,), "expected /planar_chain/scene in YAML, got .*")

    def test_faults_of_a_scene_name_its_file(self):
        scene = self.path("scene.yaml")
        with open(scene, "w", encoding="ascii") as file:
            file.write("chain: [a]\nlinks: {a: {mass: -1, inertia: 1, com: [0, 0], pin: [1, 0]}}\n")
        for tool, *more in there(("simulate", "--duration", "1"), ("equations",), ("fit", "--data", "x.csv", "--vary", "links/a/mass"),
                                 ("sweep", "--vary", "links/a/mass=1,2", "--duration", "1", "--output", self.path("out.csv")),
                                 ("formulas", "--format", "c"), ("modes",), ("bode", "--input", "a_joint", "--output", "a/x")):
            run = self.run_tool(tool, scene, *more)
            self.assertEqual(run.returncode, 2, run.stderr)
            self.assertRegex(run.stderr, rf"^({tool}: )?{scene}:2: links/a/mass: expected a number > 0 kg, got -1\n$")

    def test_other_files_and_folders_are_named(self):
        with open(self.path("other.bag"), "wb") as file:
            file.write(b"\x80" * 5000)
        os.mkdir(self.path("folder.bag"))
        for name, words in (("other", "a file that is no bag"), ("folder", "nothing: Is a directory")):
            self.assert_all_refuse(self.path(name + ".bag"), (FIT, REPLAY, ("show",)), "expected a bag that can be read, got " + words)
        whole = self.bag("whole.bag")
        self.assert_all_refuse(self.path("other.bag"), (("show", whole),), "expected a scene that can be read, got other bytes")

    @unittest.skipUnless(os.path.exists("/dev/full"), "no /dev/full")
    def test_pictures_that_cannot_be_written_fail(self):
        self.simulate("--csv", self.path("run.csv"))
        for name in ("full.pdf", "page_chain.pdf"):
            os.symlink("/dev/full", self.path(name))
        page = self.path("page.tex")
        with open(page, "w", encoding="ascii") as file:
            file.write("{page_chain.pdf}")  # it is the page's own
        for tool, picture, *arguments in there(("plot", "full.pdf", self.path("run.csv"), "--output", self.path("full.pdf")),
                                               ("modes", "full.pdf", SCENE, "--plot", self.path("full.pdf")),
                                               ("formulas", "page_chain.pdf", SCENE, "--format", "latex", "--output", page)):
            run = self.run_tool(tool, *arguments)
            self.assertEqual((run.returncode, run.stderr), (1, f"{tool}: cannot write {self.path(picture)}: No space left on device\n"))

    @unittest.skipUnless(os.path.exists("/dev/full"), "no /dev/full")
    def test_help_that_cannot_be_written_fails(self):
        for tool, *_ in there(("plot",), ("show",), ("fit",), ("sweep",), ("formulas",), ("modes",), ("bode",)):
            with open("/dev/full", "w", encoding="ascii") as full:
                run = subprocess.run([os.path.join(BIN, tool), "--help"], stdout=full, stderr=subprocess.PIPE,
                                     universal_newlines=True, check=False)
            self.assertEqual((run.returncode, run.stderr), (1, f"{tool}: cannot write standard output: No space left on device\n"))

    def test_ctrl_c_ends_a_tool_in_a_line(self):
        os.mkfifo(self.path("pipe.csv"))
        for tool, *arguments in there(("plot", "pipe.csv"), (*FIT, "pipe.csv")):
            with subprocess.Popen([os.path.join(BIN, tool), *arguments], stderr=subprocess.PIPE, universal_newlines=True,
                                  cwd=self.folder) as run:
                with open(self.path("pipe.csv"), "wb"):  # from here on the tool reads
                    run.send_signal(signal.SIGINT)
                    said = run.communicate(timeout=60)[1]
            self.assertEqual((run.returncode, said), (130, f"{tool}: interrupted\n"))


if __name__ == "__main__":
    unittest.main()
