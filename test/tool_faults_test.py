#!/usr/bin/python3
"""Every tool says in words what stops it: bags that are damaged or have other types, standard output that is full, Ctrl-C.

    tool_faults_test.py BIN [unittest options]        BIN: the folder that holds the tools
"""
import os
import signal
import subprocess
import unittest

import genpy
import rosbag
from planar_chain.msg import CommandTaken, JointTorque, SimStatus
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from plot_tool import BIN, SCENE, PlotTool

MARK = "mark_me"
FIT = "fit", SCENE, "--vary", "links/hand/mass", "--data"
REPLAY = "simulate", SCENE, "--commands"


def there(*tools):
    return [tool for tool in tools if os.path.exists(os.path.join(BIN, tool[0]))]


class Faults(PlotTool):
    def bag(self, name, topic, message, joint="pin"):
        state = JointState(name=[joint], position=[0.0], velocity=[0.0])
        with rosbag.Bag(self.path(name), "w") as file:
            for k, (each, what) in enumerate((("/joint_states", state), ("/planar_chain/status", SimStatus()), (topic, message))):
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
        self.assert_all_refuse(self.bag("taken.bag", "/planar_chain/commands_taken", String()), (("plot",), FIT, REPLAY),
                               "expected /planar_chain/commands_taken of type planar_chain/CommandTaken.*, got std_msgs/String")
        self.assert_all_refuse(self.bag("scene.bag", "/planar_chain/scene", SimStatus()), (("plot",), ("show",)),
                               "expected /planar_chain/scene of type std_msgs/String, got planar_chain/SimStatus")

    def test_a_damaged_message_is_said(self):
        command = CommandTaken(number=1, kind=CommandTaken.JOINT_TORQUE, joint_torque=[JointTorque(joint=MARK)])
        for bag, tools in ((self.damaged("state.bag", "/tf", String(), joint=MARK), (("plot",), FIT)),
                           (self.damaged("command.bag", "/planar_chain/commands_taken", command), (("plot",), FIT, REPLAY))):
            self.assert_all_refuse(bag, tools, r"expected a bag that can be read, got a damaged one \(.*\)")

    @unittest.skipUnless(os.path.exists("/dev/full"), "no /dev/full")
    def test_help_that_cannot_be_written_fails(self):
        for tool, *_ in there(("plot",), ("show",), ("fit",), ("sweep",), ("formulas",)):
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
