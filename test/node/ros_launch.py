#!/usr/bin/python3
"""sim.launch: a node that is killed comes back where it is asked to; a URDF moves; a real-time factor makes
the node's time everybody's."""

import os
import re
import signal
import subprocess
import tempfile
import unittest
import xmlrpc.client

import rosbag
import rosgraph
import rospy
import rostest
from sensor_msgs.msg import JointState

from ros_node import LIMIT, Listener, Node, Running

ROOT = os.path.join(os.path.dirname(os.path.realpath(__file__)), '../..')
ROBOT = """<robot name="r"><link name="ground"/>
<link name="rod"><inertial><origin xyz="0 0 -0.5"/><mass value="2"/>
<inertia ixx="0.2" ixy="0" ixz="0" iyy="0.25" iyz="0" izz="0.1"/></inertial></link>
<joint name="pin" type="continuous"><parent link="ground"/><child link="rod"/><axis xyz="0 1 0"/></joint></robot>
"""


def pid_of(name):
    node = xmlrpc.client.ServerProxy(rosgraph.Master('/ros_launch').lookupNode(name))
    return node.getPid('/ros_launch')[2]


class Launch(unittest.TestCase):
    def setUp(self):
        self.states = Listener('/joint_states', JointState)

    def tearDown(self):
        self.states.close()

    def launch(self, *arguments):
        return Running('roslaunch', 'planar_chain', 'sim.launch', 'rviz:=false', *arguments)

    def test_a_killed_node_comes_back(self):
        with self.launch('scene:=pendulum', 'respawn:=true'):
            self.states.wait_for_count(50)
            killed = pid_of('/planar_chain')
            os.kill(killed, signal.SIGKILL)
            # The chain is let go anew, and stamps are later ones.
            first = self.states.messages[0]
            seen = len(self.states.messages)
            again = self.states.wait_for(
                lambda state: abs(state.position[0] - first.position[0]) < 1e-3, seen)
            self.assertGreater(self.states.messages[again].header.stamp,
                               self.states.messages[seen - 1].header.stamp)
            self.assertNotEqual(pid_of('/planar_chain'), killed)

    def test_a_real_time_factor_sets_use_sim_time(self):
        try:
            with self.launch('scene:=pendulum', 'real_time_factor:=4', 'offset:=2,-0.5'):
                self.states.wait_for_count(50)
                self.assertEqual(rospy.get_param('/planar_chain/publish/offset'), [2, -0.5])
                self.assertIs(rospy.get_param('/use_sim_time'), True)
                self.assertEqual(rospy.get_param('/planar_chain/real_time_factor'), 4)
                self.assertLess(self.states.messages[-1].header.stamp.to_sec(), 1000)
        finally:
            rospy.delete_param('/use_sim_time')
            rospy.delete_param('/planar_chain')

    def test_wall_time_after_a_launch_with_a_clock_of_its_own(self):
        rospy.set_param('/use_sim_time', True)
        try:
            with self.launch('scene:=pendulum'):
                self.states.wait_for_count(50)
                self.assertIs(rospy.get_param('/use_sim_time'), False)
        finally:
            rospy.delete_param('/use_sim_time')
            rospy.delete_param('/planar_chain')

    def test_a_second_launch_leaves_the_first_alone(self):
        with self.launch('scene:=pendulum'):
            self.states.wait_for_count(50)
            run = subprocess.run(['roslaunch', 'planar_chain', 'sim.launch', 'rviz:=false'], stdout=subprocess.PIPE,
                                 stderr=subprocess.STDOUT, universal_newlines=True, timeout=LIMIT, check=False)
            self.assertEqual(run.returncode, 1)
            self.assertTrue(run.stdout.splitlines()[-1].startswith('/planar_chain runs already. '), run.stdout)
            run = subprocess.run([os.path.join(ROOT, 'launch/arguments'), '--'], stderr=subprocess.PIPE, universal_newlines=True, check=False)
            self.assertEqual((run.returncode, run.stderr.count('/planar_chain runs already. ')), (2, 1), run.stderr)
            second = Listener('/second/joint_states', JointState)
            with Running('env', 'ROS_NAMESPACE=second', 'roslaunch', 'planar_chain', 'sim.launch', 'rviz:=false'):
                second.wait_for_count(50)
            second.close()
            self.states.wait_for_count(len(self.states.messages) + 50)
        rospy.delete_param('/second/planar_chain')

    def test_a_recorder_gets_the_first_state(self):
        with tempfile.TemporaryDirectory() as folder:
            with self.launch('scene:=pendulum', 'record:=' + folder + '/run'):
                self.states.wait_for_count(50)
            with rosbag.Bag(folder + '/run.bag') as bag:
                recorded = [state for _, state, _ in bag.read_messages('/joint_states')]
                views = set(bag.get_type_and_topic_info().topics)
        rospy.delete_param('/planar_chain')
        self.assertLessEqual({'/planar_chain/view/' + name for name in (
            'loads', 'pin_forces', 'springs', 'friction', 'drives', 'trail', 'centres', 'limits', 'scale', 'energy')}, views)
        self.assertEqual(recorded[0].header.seq, 0)
        self.assertAlmostEqual(recorded[0].velocity[0], 0, delta=1e-12)

    def test_a_recorder_gets_the_sensors(self):
        with tempfile.TemporaryDirectory() as folder:
            with open(folder + '/sensed.yaml', 'w') as scene:
                scene.write('chain: [rod]\nlinks: {rod: {mass: 1, inertia: 1, com: [1, 0], pin: [2, 0]}}\n'
                            'sensors: {encoder: {joints: all, rate: 100}, imu: {link: rod, rate: 200}}\n')
            with self.launch('scene_file:=' + folder + '/sensed.yaml', 'record:=' + folder + '/run'):
                self.states.wait_for_count(50)
            with rosbag.Bag(folder + '/run.bag') as bag:
                topics = bag.get_type_and_topic_info().topics
        rospy.delete_param('/planar_chain')
        for name in ('encoder', 'imu'):
            self.assertGreater(topics['/planar_chain/' + name].message_count, 10)

    def test_a_recorder_that_dies_ends_the_launch(self):
        with tempfile.TemporaryDirectory() as folder, tempfile.NamedTemporaryFile('w', suffix='.launch') as around:
            around.write('<launch><include file="$(find planar_chain)/launch/sim.launch"><arg name="rviz" value="false"/>'
                         '<arg name="record" value="/proc/run"/></include></launch>')
            around.flush()
            killed = ('planar_chain', 'sim.launch', 'rviz:=false', 'record:=' + folder + '/run')
            for arguments, status in ((killed, 137), ((around.name,), 1)):  # the second cannot write its bag
                with subprocess.Popen(['roslaunch', *arguments], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                      universal_newlines=True) as launch:
                    try:
                        if arguments == killed:
                            self.states.wait_for_count(50)
                            os.kill(pid_of('/record'), signal.SIGKILL)
                        said = launch.communicate(timeout=LIMIT)[0]
                    finally:
                        launch.send_signal(signal.SIGINT)
                self.assertIn('record: the recorder failed with status %d, so ' % status, said)
                self.assertIn('REQUIRED process [record-', said)
        rospy.delete_param('/planar_chain')

    def test_a_refused_scene_is_printed_once_and_ends_the_launch(self):
        def launch(text, *arguments):
            with tempfile.NamedTemporaryFile('w', suffix='.yaml') as scene, tempfile.NamedTemporaryFile('w', suffix='.launch') as around:
                scene.write(text)
                scene.flush()
                around.write('<launch><include file="$(find planar_chain)/launch/sim.launch">'
                             '<arg name="scene_file" value="%s"/><arg name="rviz" value="false"/></include></launch>' % scene.name)
                around.flush()
                run = subprocess.run(['roslaunch', *(arguments and (*arguments, 'scene_file:=' + scene.name) or [around.name])],
                                     stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True, timeout=LIMIT, check=False)
            return run.returncode, run.stdout, scene.name

        heavy = 'chain: [rod]\nlinks: {rod: {mass: -1, inertia: 1, com: [0, 0], pin: [1, 0]}}\n'
        sim = 'planar_chain', 'sim.launch', 'rviz:=false', 'pull:=true'
        for text, words in ((heavy, ':2: links/rod/mass: expected a number > 0 kg, got -1'), ('chain: [a\nlinks: {b: 1}\n', ':2: ')):
            status, said, name = launch(text, *sim)
            self.assertTrue(said.splitlines()[-1].startswith(name + words), said)
            self.assertEqual((status, said.count(words)), (1, 1))
        status, said, name = launch(heavy)  # the node refuses it, as the launch file that includes ours has arguments of its own
        self.assertEqual((status, said.count('links/rod/mass: expected')), (0, 1), said)
        rospy.delete_param('/planar_chain')

    def test_a_misspelt_argument_ends_the_launch(self):
        def run(*arguments):
            run = subprocess.run(['roslaunch', '--nodes', *arguments], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                 universal_newlines=True, timeout=LIMIT, check=False)
            return run.returncode, run.stdout

        status, said = run('planar_chain', 'sim.launch', 'sceen:=rope')
        self.assertNotEqual(status, 0)
        self.assertIn('sim.launch has no argument sceen.', said.splitlines()[-1])
        self.assertIn('No scene is called roep.', run('planar_chain', 'sim.launch', 'scene:=roep')[1].splitlines()[-1])
        self.assertEqual('offset: expected two numbers x,y in m, such as 2.5,0, got 2',
                         run('planar_chain', 'sim.launch', 'offset:=2')[1].splitlines()[-1])
        self.assertIn('scene_file: expected a file', run('planar_chain', 'sim.launch', 'scene_file:=a.yaml')[1].splitlines()[-1])
        self.assertEqual(run('planar_chain', 'sim.launch', 'scene:=rope', 'rviz:=false'), (0, '/planar_chain\n'))
        with tempfile.NamedTemporaryFile('w', suffix='.launch') as around:  # with arguments of its own
            around.write('<launch><include file="$(find planar_chain)/launch/sim.launch"><arg name="rviz" value="false"/>'
                         '</include></launch>')
            around.flush()
            self.assertEqual(run(around.name, 'sceen:=rope'), (0, '/planar_chain\n'))

    def test_each_note_of_a_urdf_is_a_warning(self):
        robot = ROBOT.replace('continuous', 'revolute').replace('</joint>', '<limit effort="1" velocity="1"/></joint>')
        with Node({'robot_description': robot}) as node:
            self.states.wait_for_count(1)
        said = node.wait()[1]
        rospy.delete_param('/planar_chain')
        self.assertEqual(len(re.findall(r'WARN.*joint\[pin\]: .*: turns freely', said)), 1, said)

    def test_a_urdf_is_what_moves(self):
        with tempfile.NamedTemporaryFile('w', suffix='.urdf') as robot, \
                tempfile.NamedTemporaryFile('w', suffix='.yaml') as rest:
            robot.write(ROBOT)
            robot.flush()
            rest.write('links: {rod: {initial: {angle: 1.0}}}\ngravity: [0, 0]\n')
            rest.flush()
            try:
                with self.launch('urdf:=' + robot.name, 'scene_file:=' + rest.name):
                    self.states.wait_for_count(20)
                    state = self.states.messages[-1]
                    self.assertEqual((state.name, state.position), (['pin'], (1.0,)))
                    self.assertIn('<link name="rod">', rospy.get_param('/robot_description'))
            finally:
                rospy.delete_param('/planar_chain')


if __name__ == '__main__':
    rospy.init_node('ros_launch', anonymous=True)
    rostest.rosrun('planar_chain', 'ros_launch', Launch)
