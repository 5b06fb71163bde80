"""Tests that write files: each has a folder of its own, gone when it ends. Its name has a blank and an umlaut."""
import os
import tempfile
import unittest

URDF = """<robot name="r"><link name="world"/>
<link name="rod"><inertial><origin xyz="0 0 -0.5"/><mass value="2"/>
<inertia ixx="0.2" ixy="0" ixz="0" iyy="0.25" iyz="0" izz="0.1"/></inertial></link>
<joint name="pin" type="continuous"><parent link="world"/><child link="rod"/><axis xyz="0 1 0"/></joint></robot>
"""


class InFolder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="für Tests ")
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def path(self, name):
        return os.path.join(self.folder, name)

    def robot(self):
        """The path of a URDF: one rod on the joint pin."""
        with open(self.path("robot.urdf"), "w", encoding="ascii") as file:
            file.write(URDF)
        return self.path("robot.urdf")
