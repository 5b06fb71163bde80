#!/usr/bin/python3
"""two_chains.launch: two chains in two namespaces, by the /clock of a bag that begins again and again, with a third chain
in it. Nobody warns of anything, and the chains go on from their states. And two chains that `show` puts into one rviz."""

import os
import signal
import subprocess
import sys

import roslib.packages
import rosbag
import rospy
import rostest
import yaml
from rosgraph_msgs.msg import Clock, Log
from sensor_msgs.msg import JointState
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import MarkerArray

from ros_node import LIMIT, Listener, Node, Running, nanoseconds, rod

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), '../support'))
from in_folder import InFolder  # noqa: E402

SECONDS = 2
TICK = 0.005  # s
PACKAGE = roslib.packages.get_pkg_dir('planar_chain')


def write_bag(path):
    """What a robot might have recorded: without /clock, which rosbag play makes."""
    simulate = roslib.packages.find_node('planar_chain', 'simulate')[0]
    subprocess.run([simulate, PACKAGE + '/config/scenes/triple.yaml', '--duration', str(SECONDS),
                    '--bag', path + '.all', '--node', '/played/planar_chain'],
                   check=True, stdout=subprocess.DEVNULL, timeout=LIMIT)
    with rosbag.Bag(path + '.all') as everything, rosbag.Bag(path, 'w') as bag:
        for topic, message, received in everything.read_messages():
            if topic != '/clock':
                bag.write(topic, message, received)


def times_back(stamps):
    return [i for i in range(1, len(stamps)) if stamps[i] < stamps[i - 1]]


class TwoChains(InFolder):
    def listen(self, topic, message_type):
        listener = Listener(topic, message_type)
        self.addCleanup(listener.close)
        return listener

    def test_nobody_warns_when_the_bag_begins_again(self):
        write_bag(self.path('run.bag'))
        said = self.listen('/rosout', Log)
        clock = self.listen('/clock', Clock)
        transforms = self.listen('/tf', TFMessage)
        chains = [self.listen('/%s/joint_states' % side, JointState) for side in ('left', 'right')]
        self.addCleanup(rospy.delete_param, '/use_sim_time')
        with Running('roslaunch', PACKAGE + '/test/node/two_chains.launch', 'bag:=' + self.path('run.bag')):
            again = 0
            for _ in range(2):
                before = clock.messages[again].clock if again else rospy.Time()
                turn = clock.wait_for(lambda told: told.clock > before + rospy.Duration(SECONDS / 2), again)
                again = clock.wait_for(lambda told: told.clock < rospy.Time(SECONDS / 2), turn)
            for chain in chains:
                seen = len(chain.messages)
                chain.wait_for(lambda state: nanoseconds(state) > SECONDS * 5 * 10 ** 8, seen)

        # A machine that stands still for a second may be told of.
        warned = [entry for entry in said.messages if entry.level >= Log.WARN and 'cannot keep up' not in entry.msg]
        self.assertEqual(warned, [])
        # On a slow machine the bag may begin once more before all is shut down.
        begun_again = len(times_back([told.clock for told in clock.messages]))
        self.assertGreaterEqual(begun_again, 2)
        seen_again = range(2, begun_again + 1)
        for chain in chains:
            stamps = list(map(nanoseconds, chain.messages))
            self.assertIn(len(times_back(stamps)), seen_again)
            self.assertNotIn(0, stamps)
            self.assertLess(max(stamps), (SECONDS + 1) * 10 ** 9)
            # From state to state by the mean of both speeds, over the bag's beginning, too.
            for before, after in zip(chain.messages, chain.messages[1:]):
                for i, angle in enumerate(after.position):
                    turned = 0.5 * TICK * (before.velocity[i] + after.velocity[i])
                    self.assertAlmostEqual(angle - before.position[i], turned, delta=0.01)
        stamps_of = {}
        for message in transforms.messages:
            for transform in message.transforms:
                stamps_of.setdefault(transform.child_frame_id, []).append(nanoseconds(transform))
        self.assertEqual({frame.split('/')[0] for frame in stamps_of}, {'left', 'right', 'played'})
        for frame, stamps in stamps_of.items():
            self.assertFalse(any(later == sooner for sooner, later in zip(stamps, stamps[1:])), frame)
            self.assertIn(len(times_back(stamps)), seen_again, frame)

    def test_show_puts_both_in_one_window_with_a_text_each(self):
        with open(self.path('rviz'), 'w', encoding='utf-8') as program:  # in the place of rviz
            program.write('#!/bin/sh\ncp "$2" "%s" && exec sleep 600\n' % self.path('opened'))
        os.chmod(self.path('rviz'), 0o755)
        show = roslib.packages.find_node('planar_chain', 'show')[0]
        environment = dict(os.environ, PATH=self.folder + ':' + os.environ['PATH'], HOME=self.folder, DISPLAY=':0')
        texts = [self.listen('/show/energy_%d' % k, MarkerArray) for k in (0, 1)]
        with Node(rod(), '/left'), Node(rod(gravity=[0.0, -9.81], publish={'offset': [4.0, 0.0]}), '/right'):
            for name in ('middle', '~x'):
                wrong = subprocess.run([show, 'left', name], env=environment, stderr=subprocess.PIPE, universal_newlines=True,
                                       timeout=LIMIT, check=False)
                self.assertEqual((wrong.returncode, wrong.stderr), (2, 'show: /%s/planar_chain: expected a running scene, a file of '
                                                                    'rviz or a bag, got nothing of this name\n' % name))
            process = subprocess.Popen([show, 'left', 'right'], env=environment, start_new_session=True)
            try:
                for text in texts:
                    text.wait_for_count(2)
            finally:
                os.killpg(process.pid, signal.SIGINT)
                process.wait(LIMIT)
        blocks = [text.messages[-1].markers for text in texts]
        for block, node in zip(blocks, ('/left/planar_chain', '/right/planar_chain')):
            self.assertEqual([marker.text.split()[-1] for marker in block],
                             ['time', 'kinetic', 'potential', 'supplied', 'dissipated', 'balance', node])
        (low, high), (above, _) = ([edge(marker.pose.position.y for marker in block) for edge in (min, max)] for block in blocks)
        self.assertGreater(above - high, blocks[0][0].scale.z)
        self.assertGreater(high - low, 6 * blocks[0][0].scale.z)
        left, right = (min(marker.pose.position.x for marker in block) for block in blocks)
        self.assertAlmostEqual(left - right, 4, delta=blocks[0][0].scale.z)  # in frames that are so far apart

        with open(self.path('opened'), encoding='utf-8') as file:
            manager = yaml.safe_load(file)['Visualization Manager']
        self.assertEqual(manager['Views']['Current']['Focal Point'], {'X': 2, 'Y': 0, 'Z': 0})
        groups = {display['Name']: display['Displays'] for display in manager['Displays'] if display['Class'] == 'rviz/Group'}
        self.assertEqual(set(groups), {'/left/planar_chain', '/right/planar_chain'})
        for k, (node, displays) in enumerate(sorted(groups.items())):
            side = node.split('/')[1]
            topics = {display['Name']: display.get('Marker Topic') for display in displays}
            self.assertEqual([display['Enabled'] for display in displays if display['Name'] == 'Scale'], [k == 0])
            self.assertEqual((topics['Energy'], topics['Springs']), ('/show/energy_%d' % k, node + '/view/springs'))
            told = {display.get(key) for display in displays for key in ('Robot Description', 'Update Topic')} - {None}
            self.assertEqual(told, {'/%s/robot_description' % side, '/%s/pull/update' % side})
        self.assertTrue(os.path.exists(self.path('.rviz/planar_chain/left_right.rviz')))


if __name__ == '__main__':
    rospy.init_node('ros_two_chains', anonymous=True)
    rostest.rosrun('planar_chain', 'ros_two_chains', TwoChains)
